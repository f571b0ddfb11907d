//! Bodies to scale, filled, the windscreen left out where it fits.

use ratatui::style::{Color, Modifier, Style};
use ratatui::widgets::canvas::Context;

use super::label_placer::{Body, LabelPlacer};
use super::lines::{outlines, stroke};
use super::{CellView, Theme, color};
use crate::geometry::{Point, Vector};
use crate::render::scene::{Body as MapBody, Importance, MapScene, Owner};
use crate::tui::widgets::fill::Fill;

/// Seconds ahead that the velocity line shows.
const AHEAD: f64 = 0.5;
/// Slower than this, m/s, there is no velocity line.
const STANDING: f64 = 0.3;
/// A body of fewer dots than this is not hollow: its outline would be a blot.
const OUTLINE: f64 = 9.0;
/// A body of fewer dots than this has no windscreen, but a pointed front.
const SCREENED: f64 = 14.0;
/// A body of fewer dots than this is an arrow: its heading does not show otherwise.
const ARROW: f64 = 5.0;
/// Where a front begins to be pointed, in parts of the length from the rear.
const POINTED: f64 = 0.6;
/// The windscreen, in parts of the length from the rear.
const SCREEN: (f64, f64) = (0.64, 0.78);

/// Arrows by eighths of a turn, from the right to the left.
const ARROWS: [&str; 8] = ["→", "↗", "↑", "↖", "←", "↙", "↓", "↘"];

/// Bodies that are large enough; the others are arrows.
pub fn draw<'a>(
    ctx: &mut Context<'_>,
    theme: &Theme,
    bodies: impl IntoIterator<Item = &'a MapBody<'a>>,
    view: &CellView,
) {
    for body in bodies {
        if !is_arrow(view, body) {
            filled(ctx, view, body, color(theme, body.role));
        }
    }
}

/// Everybody who is too small for a body is an arrow, the ego on top.
pub fn arrows(board: &mut LabelPlacer<'_>, theme: &Theme, scene: &MapScene<'_>, view: &CellView) {
    let all = scene.bodies.iter().chain(&scene.ego);
    for body in all.filter(|body| is_arrow(view, body)) {
        let mut style = Style::new().fg(color(theme, body.role));
        if body.importance >= Importance::Danger {
            style = style.add_modifier(Modifier::BOLD);
        }
        let pose = body.motion.pose;
        let glyph = if body.stands {
            "▪"
        } else {
            arrow(&view.turned(&pose.forward()))
        };
        board.put(view.at(&pose.position), glyph, style);
    }
}

/// Keeps words off the bodies that have no name.
pub fn keep_clear(board: &mut LabelPlacer<'_>, scene: &MapScene<'_>, view: &CellView) {
    for body in &scene.bodies {
        let (x, y) = view.at(&body.motion.pose.position);
        let (_, width) = body.footprint.shape().size();
        let half = width.min(2.0 * body.footprint.reach()) / 2.0;
        let body = Body {
            x: (x - half, x + half),
            y: (y - half, y + half),
        };
        let cells = board.cells(&body);
        board.reserve(cells);
    }
}

/// The arrow along a direction of the canvas.
fn arrow(direction: &Vector) -> &'static str {
    let eighths = direction.y.atan2(direction.x) / std::f64::consts::FRAC_PI_4;
    ARROWS[(eighths.round() as i64).rem_euclid(8).unsigned_abs() as usize % 8]
}

fn is_arrow(view: &CellView, body: &MapBody<'_>) -> bool {
    2.0 * body.footprint.reach() < ARROW * view.dot
}

/// Lines from the fronts, as long as the way of the next half second; under the bodies they cross.
pub fn velocities(ctx: &mut Context<'_>, theme: &Theme, scene: &MapScene<'_>, view: &CellView) {
    for body in scene.bodies.iter().chain(&scene.ego) {
        let motion = body.motion;
        if motion.velocity.abs() > STANDING && view.sees_point(&motion.pose.position) {
            let (rear, front) = body.along;
            let reach = if motion.velocity > 0.0 { front } else { rear };
            let nose = motion.pose.position + motion.pose.forward() * reach;
            let color = match body.owner {
                Owner::Ego => theme.ego,
                Owner::Obstacle(_) => theme.static_obstacle,
            };
            let end = nose + motion.velocity_vector() * AHEAD;
            stroke(ctx, view, &[nose, end], color);
        }
    }
}

fn filled(ctx: &mut Context<'_>, view: &CellView, body: &MapBody<'_>, color: Color) {
    let pose = body.motion.pose;
    let (here, forward) = (pose.position, pose.forward());
    let (rear, front) = body.along;
    let dots = body.length() / view.dot;
    let mut fill = |ring: &[Point]| {
        let corners: Vec<(f64, f64)> = ring.iter().map(|p| view.at(p)).collect();
        ctx.draw(&Fill::solid(&corners, color));
    };
    if body.stands {
        // Static bodies are hollow, moving ones filled.
        if dots < OUTLINE {
            body.rings.iter().for_each(|ring| fill(ring));
        }
    } else if dots >= SCREENED {
        for ring in &body.rings {
            for stretch in [
                (f64::MIN, body.part(SCREEN.0)),
                (body.part(SCREEN.1), f64::MAX),
            ] {
                fill(&cut(ring, &here, &forward, stretch));
            }
        }
    } else if let [ring] = body.rings.as_slice() {
        fill(&cut(ring, &here, &forward, (f64::MIN, body.part(POINTED))));
        let (right, left) = body.across;
        let base = body.part(POINTED);
        let nose = body.point(front, f64::midpoint(left, right));
        fill(&[body.point(base, left), nose, body.point(base, right)]);
        // A narrow body may fall between all dots.
        stroke(ctx, view, &[body.point(rear, 0.0), nose], color);
        return;
    } else {
        body.rings.iter().for_each(|ring| fill(ring));
    }
    outlines(ctx, view, &body.rings, color);
    if body.stands && dots >= OUTLINE {
        stroke(ctx, view, &[here, body.point(front, 0.0)], color);
    }
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
            assert_eq!(arrow(&Vector::new(x, y)), glyph, "{x} {y}");
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
