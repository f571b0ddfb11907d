//! Bodies to scale: filled, with windscreen, brake lights and indicators where there is room.

use ratatui::style::Color;

use super::canvas::Canvas;
use super::color::mix;
use super::lines::{outlines, stroke};
use super::{Appearance, CellView, MapStyle};
use crate::geometry::{Point, Vector};
use crate::render::scene::{Body, MapScene, Owner};
use crate::scenario::Signal;

/// Seconds ahead that the velocity line shows.
const AHEAD: f64 = 0.5;
/// Slower than this, m/s, there is no velocity line.
const STANDING: f64 = 0.3;
/// A body of fewer dots than this is not hollow: its outline would be a blot.
const OUTLINE: f64 = 9.0;
/// A body of fewer parts of blocks than this has no windscreen.
const SCREENED: f64 = 7.0;
/// A body of fewer dots than this is an arrow: its heading does not show otherwise.
const ARROW: f64 = 5.0;
/// Where a front begins to be pointed, in parts of the length from the rear.
const POINTED: f64 = 0.6;
/// The windscreen, in parts of the length from the rear.
const SCREEN: (f64, f64) = (0.62, 0.80);
/// How dark the windscreen is: the part of the way from the body's colour to the road's.
const GLASS: f64 = 0.55;

/// Arrows by eighths of a turn, from the right to the left.
const ARROWS: [&str; 8] = ["→", "↗", "↑", "↖", "←", "↙", "↓", "↘"];

/// Bodies that are large enough; the others are [arrows](is_arrow).
pub fn draw<'a>(
    canvas: &mut Canvas<'_>,
    look: &Appearance<'_>,
    bodies: impl IntoIterator<Item = &'a Body<'a>>,
    view: &CellView,
) {
    for body in bodies {
        let heading = Heading::new(look, view, body);
        if heading != Heading::Alone {
            filled(canvas, look, view, body, heading);
        }
    }
}

/// The arrow along a direction of the canvas.
#[must_use]
pub fn heading_arrow(direction: &Vector) -> &'static str {
    let eighths = direction.y.atan2(direction.x) / std::f64::consts::FRAC_PI_4;
    ARROWS[(eighths.round() as i64).rem_euclid(8).unsigned_abs() as usize % 8]
}

/// What shows where a body is headed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Heading {
    /// An arrow in place of the body, which is too small.
    Alone,
    /// An arrow on the body.
    OnBody,
    /// A pointed front.
    Pointed,
    /// Its windscreen.
    Windscreen,
    /// Nothing: it stands, or has no front.
    None,
}

impl Heading {
    /// That of a body, by how many dots and parts of blocks it is long.
    #[must_use]
    pub fn new(look: &Appearance<'_>, view: &CellView, body: &Body<'_>) -> Self {
        if 2.0 * body.footprint.reach() < ARROW * view.dot {
            return Self::Alone;
        }
        let parts = body.length() / view.block(look.style);
        match look.style {
            _ if body.stands || !body.has_front => Self::None,
            MapStyle::Ascii => Self::OnBody,
            _ if parts >= SCREENED => Self::Windscreen,
            MapStyle::Cells(_) => Self::OnBody,
            MapStyle::Braille if body.rings.len() == 1 => Self::Pointed,
            MapStyle::Braille => Self::None,
        }
    }
}

/// Lines from the fronts, as long as the way of the next half second; under the bodies they cross.
pub fn velocities(
    canvas: &mut Canvas<'_>,
    look: &Appearance<'_>,
    scene: &MapScene<'_>,
    view: &CellView,
) {
    for body in scene.bodies.iter().chain(&scene.ego) {
        let motion = body.motion;
        if motion.velocity.abs() > STANDING && view.sees_point(&motion.pose.position) {
            let (rear, front) = body.along;
            let reach = if motion.velocity > 0.0 { front } else { rear };
            let nose = motion.pose.position + motion.pose.forward() * reach;
            let color = match body.owner {
                Owner::Ego => look.theme.ego,
                Owner::Obstacle(_) => look.theme.static_obstacle,
            };
            let end = nose + motion.velocity_vector() * AHEAD;
            stroke(canvas, view, &[nose, end], color);
        }
    }
}

fn filled(
    canvas: &mut Canvas<'_>,
    look: &Appearance<'_>,
    view: &CellView,
    body: &Body<'_>,
    heading: Heading,
) {
    let color = look.color(body.role);
    let dots = body.length() / view.dot;
    if body.stands && !look.style.has_backgrounds() && dots >= OUTLINE {
        // Without backgrounds standing bodies are hollow, moving ones filled.
        outlines(canvas, view, &body.rings, color);
        let front = [body.motion.pose.position, body.point(body.along.1, 0.0)];
        return stroke(canvas, view, &front, color);
    }
    let pointed = heading == Heading::Pointed;
    for ring in &body.rings {
        match pointed {
            true => part(canvas, view, body, ring, (f64::MIN, POINTED), color),
            false => area(canvas, view, ring, color),
        }
    }
    let (rear, front) = body.along;
    let (right, left) = body.across;
    let middle = f64::midpoint(left, right);
    // A narrow body may fall between all dots.
    if left - right < 2.0 * view.block(look.style) {
        let inset = 0.3 * body.length().min(view.block(look.style));
        let ends = [rear + inset, front - inset];
        let ends = ends.map(|ahead| view.at(&body.point(ahead, middle)));
        canvas.bar(ends[0], ends[1], color);
    }
    if pointed {
        let base = body.part(POINTED);
        let tip = body.point(front, middle);
        area(
            canvas,
            view,
            &[body.point(base, left), tip, body.point(base, right)],
            color,
        );
    } else if heading == Heading::Windscreen {
        windscreen(canvas, look, view, body, color);
    }
    if body.has_front {
        lamps(canvas, look, view, body);
    }
}

/// A dark band behind the front; where nothing is darker, the gap stays empty.
fn windscreen(
    canvas: &mut Canvas<'_>,
    look: &Appearance<'_>,
    view: &CellView,
    body: &Body<'_>,
    color: Color,
) {
    let glass = mix(color, look.theme.map_ground, GLASS);
    for ring in &body.rings {
        match look.style.has_backgrounds() {
            true => part(canvas, view, body, ring, SCREEN, glass),
            false => canvas.clear(&placed(view, &between(body, ring, SCREEN))),
        }
    }
}

/// Brake lights across the rear, indicators at the corners of their side.
fn lamps(canvas: &mut Canvas<'_>, look: &Appearance<'_>, view: &CellView, body: &Body<'_>) {
    let Some(signals) = body.signals else { return };
    let on = |signal: Signal| signals.signals.contains(&(signal, true));
    let (rear, front) = body.along;
    let (right, left) = body.across;
    let inset = view.dot / 2.0;
    let mut lamp = |from: (f64, f64), to: (f64, f64), color| {
        let at = |(ahead, left)| view.at(&body.point(ahead, left));
        canvas.bar(at(from), at(to), color);
    };
    if on(Signal::BrakingLights) {
        let behind = rear + inset;
        lamp(
            (behind, right + inset),
            (behind, left - inset),
            look.theme.brake_light,
        );
    }
    let hazard = on(Signal::HazardWarningLights);
    let sides = [
        (Signal::IndicatorLeft, left - inset),
        (Signal::IndicatorRight, right + inset),
    ];
    for (signal, side) in sides {
        if hazard || on(signal) {
            for ahead in [rear + inset, front - inset] {
                lamp((ahead, side), (ahead, side), look.theme.indicator);
            }
        }
    }
}

fn area(canvas: &mut Canvas<'_>, view: &CellView, ring: &[Point], color: Color) {
    canvas.area(&placed(view, ring), color);
}

/// The part of a body between two parts of its length.
fn part(
    canvas: &mut Canvas<'_>,
    view: &CellView,
    body: &Body<'_>,
    ring: &[Point],
    stretch: (f64, f64),
    color: Color,
) {
    area(canvas, view, &between(body, ring, stretch), color);
}

fn between(body: &Body<'_>, ring: &[Point], (from, to): (f64, f64)) -> Vec<Point> {
    let pose = body.motion.pose;
    let from = if from == f64::MIN {
        from
    } else {
        body.part(from)
    };
    cut(ring, &pose.position, &pose.forward(), (from, body.part(to)))
}

fn placed(view: &CellView, ring: &[Point]) -> Vec<(f64, f64)> {
    ring.iter().map(|p| view.at(p)).collect()
}

/// The part of a ring that lies between two distances along a direction.
fn cut(ring: &[Point], origin: &Point, along: &Vector, (from, to): (f64, f64)) -> Vec<Point> {
    let place = |p: &Point| (p - origin).dot(along);
    let after = |ring: &[Point], limit: f64, sign: f64| {
        let mut kept = Vec::with_capacity(ring.len() + 2);
        for (i, p) in ring.iter().enumerate() {
            let q = &ring[(i + 1) % ring.len()];
            let (a, b) = (sign * (place(p) - limit), sign * (place(q) - limit));
            if a >= 0.0 {
                kept.push(*p);
            }
            if (a >= 0.0) != (b >= 0.0) {
                kept.push(p + (q - p) * (a / (a - b)));
            }
        }
        kept
    };
    after(&after(ring, from, 1.0), to, -1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrows_point_where_a_body_is_headed() {
        let expected = [
            ((1.0, 0.0), "→"),
            ((1.0, 1.0), "↗"),
            ((0.1, 1.0), "↑"),
            ((-1.0, 0.1), "←"),
            ((-1.0, -0.1), "←"),
            ((0.0, -1.0), "↓"),
            ((1.0, -1.0), "↘"),
        ];
        for ((x, y), glyph) in expected {
            assert_eq!(heading_arrow(&Vector::new(x, y)), glyph, "{x} {y}");
        }
    }

    #[test]
    fn a_body_is_cut_across() {
        let ring = [(-2.0, -1.0), (2.0, -1.0), (2.0, 1.0), (-2.0, 1.0)];
        let ring = ring.map(|(x, y)| Point::new(x, y));
        let front = cut(&ring, &Point::origin(), &Vector::x(), (1.0, f64::MAX));
        assert_eq!(front.len(), 4);
        assert!(front.iter().all(|p| p.x >= 1.0 && p.y.abs() <= 1.0));
        let whole = cut(&ring, &Point::origin(), &Vector::x(), (f64::MIN, f64::MAX));
        assert_eq!(whole, ring);
    }
}
