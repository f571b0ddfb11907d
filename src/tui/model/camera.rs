//! The map camera: centre, zoom and rotation.

use std::f64::consts::FRAC_PI_2;

use nearmiss_base::geometry::{Bounds, Point, Pose, Vector};

/// The view of the map.
#[derive(Debug, Clone, PartialEq)]
pub struct Camera {
    /// Metres a cell of the terminal is wide.
    pub cell: f64,
    /// How much higher than wide a cell is; 2 where the terminal does not say.
    pub aspect: f64,
    /// The middle, where it is not the ego.
    pub center: Point,
    /// The direction that is up where the ego is not followed and the map is turned, radians.
    pub up: f64,
    /// Where the middle is, seen from the ego that is followed, metres: up the screen, and to its left.
    pub shift: Vector,
    /// Whether the ego stays in the middle.
    pub follow: bool,
    /// Whether the map turns with the ego, which drives along the longer side of the pane: to the right, or upwards.
    pub ego_up: bool,
    /// Whether the pane is wider than high.
    pub wide: bool,
    /// Whether the map chooses its zoom, as long as the ego is followed: until the user zooms or moves it.
    pub auto: bool,
    /// What was fitted, metres across and down the screen; it stays in sight until the user zooms or moves the map.
    pub fitted: Option<(f64, f64)>,
    /// Metres that the map is wide at least, where it chooses.
    pub least: f64,
}

/// Metres that a map shows at first, so that a vehicle is seen before it is near.
pub const NEIGHBOURHOOD: f64 = 36.0;

const NEAREST: f64 = 0.1;
const FARTHEST: f64 = 200.0;

/// How much higher than wide cells usually are.
const ASPECT: f64 = 2.0;

/// Plausible cell aspect ratios; a terminal that reports another is wrong.
const SHAPES: std::ops::RangeInclusive<f64> = 1.0..=4.0;

/// The ego that is followed stays within this part of the view.
const IN_VIEW: f64 = 0.9;
/// And within this part where the user zooms without a pointer.
const IN_MIDDLE: f64 = 0.5;

impl Default for Camera {
    fn default() -> Self {
        Self {
            cell: 0.6,
            aspect: ASPECT,
            center: Point::origin(),
            up: FRAC_PI_2,
            shift: Vector::zeros(),
            follow: true,
            ego_up: true,
            wide: true,
            auto: true,
            fitted: None,
            least: NEIGHBOURHOOD,
        }
    }
}

impl Camera {
    /// Takes the shape of the terminal's cells: how much higher than wide they are, where it is known.
    pub fn shape_cells(&mut self, aspect: Option<f64>) {
        self.aspect = aspect.filter(|a| SHAPES.contains(a)).unwrap_or(ASPECT);
    }

    /// Metres a cell is high.
    #[must_use]
    pub fn row(&self) -> f64 {
        self.cell * self.aspect
    }

    /// Whether so many columns and rows are wider than high.
    #[must_use]
    pub fn is_wide(&self, size: (u16, u16)) -> bool {
        f64::from(size.0) >= f64::from(size.1) * self.aspect
    }

    /// Zooms by a factor; below 1 is in. The middle stays where it is, or the ego that is followed, which is not left at
    /// an edge of so many columns and rows; farther away it comes back to the middle, as its surroundings are to be seen.
    pub fn zoom(&mut self, factor: f64, size: (u16, u16)) {
        self.auto = false;
        self.fitted = None;
        let shift = self.shift;
        self.scale(factor);
        if factor > 1.0 {
            self.shift = shift;
        }
        self.keep_ego_within(IN_MIDDLE, size);
    }

    /// Moves the view so that the ego that is followed is in this part of so many columns and rows around the middle.
    fn keep_ego_within(&mut self, part: f64, (columns, rows): (u16, u16)) {
        let most = |cells: u16, size: f64| part * f64::from(cells) * size / 2.0;
        let (up, left) = (most(rows, self.row()), most(columns, self.cell));
        self.shift.x = self.shift.x.clamp(-up, up);
        self.shift.y = self.shift.y.clamp(-left, left);
    }

    /// The same where it is not the user who zooms.
    pub fn scale(&mut self, factor: f64) {
        let before = self.cell;
        self.cell = (self.cell * factor).clamp(NEAREST, FARTHEST);
        self.shift *= self.cell / before;
    }

    /// Zooms by a factor about a point, which stays where it is on the screen of so many columns and rows, as long as
    /// an ego that is followed stays in view.
    pub fn zoom_about(&mut self, point: &Point, factor: f64, ego: Option<Pose>, size: (u16, u16)) {
        self.auto = false;
        let frame = self.frame(ego);
        let before = self.cell;
        self.cell = (self.cell * factor).clamp(NEAREST, FARTHEST);
        let moved = frame.to_local(point).coords * (1.0 - self.cell / before);
        if self.follow && ego.is_some() {
            self.shift += moved;
            self.keep_ego_within(IN_VIEW, size);
        } else {
            self.stay(frame, Point::from(moved));
        }
    }

    /// Zooms out until this many metres fit into the width of the pane.
    pub fn show_at_least(&mut self, metres: f64, columns: u16) {
        self.least = metres;
        self.cell = self.cell.max(metres / f64::from(columns.max(1)));
    }

    /// Moves the view by cells, to the right and up; the ego is not followed any longer.
    pub fn pan(&mut self, right: f64, up: f64, ego: Option<Pose>) {
        self.auto = false;
        let frame = self.frame(ego);
        self.stay(frame, Point::new(up * self.row(), -right * self.cell));
    }

    /// The ego is not followed any longer: the map stays at a point of the frame.
    pub fn stay(&mut self, frame: Pose, at: Point) {
        self.fitted = None;
        self.center = frame.to_world(&at);
        self.up = frame.heading;
        self.follow = false;
        self.shift = Vector::zeros();
    }

    /// Turns the map with the ego, or north up.
    pub fn turn(&mut self, ego: Option<Pose>) {
        self.ego_up = !self.ego_up;
        self.up = self.heading(ego);
    }

    /// Fits all of `bounds` into these columns and rows.
    pub fn fit(&mut self, bounds: &Bounds, ego: Option<Pose>, (columns, rows): (u16, u16)) {
        let frame = self.frame(ego);
        let half = (bounds.max - bounds.min) / 2.0;
        let size = |axis: Vector| 2.0 * ((half.x * axis.x).abs() + (half.y * axis.y).abs());
        self.stay(frame, frame.to_local(&bounds.center()));
        self.fitted = Some((size(frame.left()), size(frame.forward())));
        self.refit((columns, rows));
    }

    /// What was fitted fits into so many columns and rows, too.
    pub fn refit(&mut self, (columns, rows): (u16, u16)) {
        if let Some((across, down)) = self.fitted {
            let across = across / f64::from(columns.max(1));
            let down = down / (self.aspect * f64::from(rows.max(1)));
            self.cell = (across.max(down) * 1.05).clamp(NEAREST, FARTHEST);
        }
    }

    /// The frame of the view: forward is up on the screen, left is left.
    #[must_use]
    pub fn frame(&self, ego: Option<Pose>) -> Pose {
        match ego {
            Some(Pose { position, .. }) if self.follow => {
                let heading = self.heading(ego);
                let around = Pose { position, heading };
                let position = around.to_world(&Point::from(self.shift));
                Pose { position, heading }
            }
            _ => Pose {
                position: self.center,
                heading: match ego {
                    Some(_) if self.ego_up => self.up,
                    _ => FRAC_PI_2,
                },
            },
        }
    }

    /// The direction that is up where the ego is followed, radians.
    fn heading(&self, ego: Option<Pose>) -> f64 {
        match ego {
            Some(ego) if self.ego_up && self.wide => ego.heading + FRAC_PI_2,
            Some(ego) if self.ego_up => ego.heading,
            _ => FRAC_PI_2,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: (u16, u16) = (100, 40);

    /// Where a point is on the screen, in cells from the middle: right and up.
    fn seen(camera: &Camera, point: &Point, ego: Option<Pose>) -> (f64, f64) {
        let local = camera.frame(ego).to_local(point);
        (-local.y / camera.cell, local.x / camera.row())
    }

    #[test]
    fn the_point_under_the_pointer_stays_there() {
        let ego = Some(Pose::new(30.0, -4.0, 0.7));
        let point = Point::new(36.0, 2.0);
        for (follow, ego_up, aspect) in [
            (true, false, 2.0),
            (true, true, 2.2),
            (false, true, 2.0),
            (false, false, 1.8),
        ] {
            let mut camera = Camera {
                follow,
                ego_up,
                center: Point::new(33.0, 0.0),
                ..Camera::default()
            };
            camera.shape_cells(Some(aspect));
            let before = seen(&camera, &point, ego);
            for factor in [0.85, 0.85, 1.3] {
                camera.zoom_about(&point, factor, ego, SIZE);
            }
            let after = seen(&camera, &point, ego);
            let off = (after.0 - before.0).hypot(after.1 - before.1);
            assert!(off < 1e-9, "{follow} {ego_up}: {before:?} {after:?}");
        }
    }

    #[test]
    fn the_ego_that_is_followed_stays_in_view() {
        let ego = Some(Pose::new(0.0, 0.0, 0.0));
        let mut camera = Camera::default();
        for _ in 0..20 {
            camera.zoom_about(&Point::new(29.0, 0.0), 0.85, ego, SIZE);
        }
        let (right, up) = seen(&camera, &Point::origin(), ego);
        assert!(right.abs() <= 50.0 && up.abs() <= 20.0, "{right} {up}");
        camera.zoom(4.0, SIZE);
        let wider = seen(&camera, &Point::origin(), ego);
        assert!((wider.0 - right / 4.0).abs() < 1e-9, "it comes back");
        camera.zoom(0.5, SIZE);
        let nearer = seen(&camera, &Point::origin(), ego);
        assert!((nearer.0 - wider.0).abs() < 1e-9, "it stays where it is");
    }

    #[test]
    fn the_ego_comes_from_the_edge_where_keys_zoom_in() {
        let ego = Some(Pose::new(0.0, 0.0, 0.0));
        // As the map chooses it where the picked obstacle is far.
        let mut camera = Camera {
            shift: Vector::new(0.0, -24.0),
            ..Camera::default()
        };
        let before = seen(&camera, &Point::origin(), ego);
        assert!(before.0.abs() > 35.0, "{before:?}");
        for _ in 0..2 {
            camera.zoom(0.8, SIZE);
            let (right, up) = seen(&camera, &Point::origin(), ego);
            assert!(right.abs() <= 25.0 && up.abs() <= 10.0, "{right} {up}");
        }
    }

    #[test]
    fn impossible_cells_are_not_believed() {
        let mut camera = Camera::default();
        for (said, taken) in [
            (None, 2.0),
            (Some(f64::NAN), 2.0),
            (Some(0.0), 2.0),
            (Some(2.25), 2.25),
        ] {
            camera.shape_cells(said);
            assert!((camera.aspect - taken).abs() < 1e-12);
        }
    }
}
