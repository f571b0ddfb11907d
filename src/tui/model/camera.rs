//! How the map is seen: where, how much of it, which way up.

use crate::geometry::{Bounds, Point, Pose, Vector};

/// The view of the map.
#[derive(Debug, Clone, PartialEq)]
pub struct Camera {
    /// Metres a cell of the terminal is wide; it is twice as high.
    pub cell: f64,
    /// The middle, where it is not the ego.
    pub center: Point,
    /// Whether the ego stays in the middle.
    pub follow: bool,
    /// Whether the ego drives upwards.
    pub ego_up: bool,
}

const NEAREST: f64 = 0.1;
const FARTHEST: f64 = 200.0;

impl Default for Camera {
    fn default() -> Self {
        Self {
            cell: 0.6,
            center: Point::origin(),
            follow: true,
            ego_up: false,
        }
    }
}

impl Camera {
    /// Zooms by a factor; below 1 is in.
    pub fn zoom(&mut self, factor: f64) {
        self.cell = (self.cell * factor).clamp(NEAREST, FARTHEST);
    }

    /// Zooms out until so many metres fit into the width of the pane.
    pub fn show_at_least(&mut self, metres: f64, columns: u16) {
        self.cell = self.cell.max(metres / f64::from(columns.max(1)));
    }

    /// Moves the view by cells, to the right and up; the ego is not followed any longer.
    pub fn pan(&mut self, right: f64, up: f64, ego: Option<Pose>) {
        let frame = self.frame(ego);
        self.center = frame.to_world(&Point::new(2.0 * up * self.cell, -right * self.cell));
        self.follow = false;
    }

    /// Shows all of `bounds` in so many columns and rows.
    pub fn fit(&mut self, bounds: &Bounds, (columns, rows): (u16, u16)) {
        let size: Vector = bounds.max - bounds.min;
        let (across, down) = (f64::from(columns.max(1)), 2.0 * f64::from(rows.max(1)));
        self.cell = ((size.x / across).max(size.y / down) * 1.05).clamp(NEAREST, FARTHEST);
        self.center = bounds.center();
        self.follow = false;
        self.ego_up = false;
    }

    /// The frame of the view: forward is up on the screen, left is left.
    #[must_use]
    pub fn frame(&self, ego: Option<Pose>) -> Pose {
        let up = match ego {
            Some(ego) if self.ego_up => ego.heading,
            _ => std::f64::consts::FRAC_PI_2,
        };
        let center = match ego {
            Some(ego) if self.follow => ego.position,
            _ => self.center,
        };
        Pose {
            position: center,
            heading: up,
        }
    }
}
