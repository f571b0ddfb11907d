//! Bodies to scale, filled, the windscreen left out where it fits.

use ratatui::style::{Color, Modifier, Style};
use ratatui::widgets::canvas::Context;

use super::label_placer::{Body, LabelPlacer};
use super::{Projection, stroke};
use crate::geometry::{Footprint, Point, Vector};
use crate::scenario::{Motion, Obstacle, ObstacleRole};
use crate::tui::loaded::Opened;
use crate::tui::model::{Model, On};
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

/// One body to be drawn.
struct Drawn<'a> {
    importance: u8,
    color: Color,
    body: &'a Footprint,
    motion: &'a Motion,
    stands: bool,
}

pub fn obstacles(
    ctx: &mut Context<'_>,
    model: &Model,
    opened: &Opened,
    view: &Projection,
    step: i64,
) {
    for drawn in seen(model, opened, view, step) {
        if !is_arrow(view, drawn.body) {
            draw_body(ctx, view, &drawn);
        }
    }
}

pub fn ego(ctx: &mut Context<'_>, model: &Model, opened: &Opened, view: &Projection, step: i64) {
    if let Some(drawn) = ego_seen(model, opened, step)
        && view.sees_point(&drawn.motion.pose.position)
        && !is_arrow(view, drawn.body)
    {
        draw_body(ctx, view, &drawn);
    }
}

/// Everybody who is too small for a body is an arrow, the ego on top.
pub fn arrows(
    board: &mut LabelPlacer<'_>,
    model: &Model,
    opened: &Opened,
    view: &Projection,
    step: i64,
) {
    let ego = ego_seen(model, opened, step);
    for drawn in seen(model, opened, view, step).into_iter().chain(ego) {
        if !is_arrow(view, drawn.body) {
            continue;
        }
        let mut style = Style::new().fg(drawn.color);
        if drawn.importance >= 2 {
            style = style.add_modifier(Modifier::BOLD);
        }
        let pose = drawn.motion.pose;
        let glyph = if drawn.stands {
            "▪"
        } else {
            arrow(&view.turned(&pose.forward()))
        };
        board.put(view.at(&pose.position), glyph, style);
    }
}

/// Keeps words off the bodies that have no name.
pub fn keep_clear(
    board: &mut LabelPlacer<'_>,
    model: &Model,
    opened: &Opened,
    view: &Projection,
    step: i64,
) {
    for drawn in seen(model, opened, view, step) {
        let (x, y) = view.at(&drawn.motion.pose.position);
        let (_, width) = drawn.body.shape().size();
        let half = width.min(2.0 * drawn.body.reach()) / 2.0;
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

fn is_arrow(view: &Projection, body: &Footprint) -> bool {
    2.0 * body.reach() < ARROW * view.dot
}

/// Who is in view, the picked and the dangerous ones last, over the others.
fn seen<'a>(model: &Model, opened: &'a Opened, view: &Projection, step: i64) -> Vec<Drawn<'a>> {
    let ego = opened.scene.as_ref().map(|s| s.ego.id);
    let theme = &model.theme;
    let variant = model.variant().filter(|shown| shown.changed);
    let attacker = variant.map(|shown| shown.made.effect.attacker);
    let others = opened
        .scenario
        .obstacles
        .iter()
        .filter(|o| Some(o.id) != ego);
    let mut order: Vec<Drawn<'a>> = others
        .filter_map(|o| {
            let motion = o.motion_at(step)?;
            let body = o.footprint_at(step)?;
            view.sees_around(&motion.pose.position, body.reach())
                .then_some((o, body, motion))
        })
        .map(|(o, body, motion)| {
            let importance = importance(model, opened, o, step);
            let stands = o.role == ObstacleRole::Static;
            Drawn {
                importance,
                color: match importance {
                    _ if attacker == Some(o.id) => theme.attacker,
                    3 => theme.picked,
                    2 => theme.danger,
                    1 => theme.warning,
                    _ if stands => theme.static_obstacle,
                    _ => theme.obstacle,
                },
                body,
                motion,
                stands,
            }
        })
        .collect();
    order.sort_by_key(|drawn| drawn.importance);
    order
}

fn ego_seen<'a>(model: &Model, opened: &'a Opened, step: i64) -> Option<Drawn<'a>> {
    Some(Drawn {
        importance: 4,
        color: model.theme.ego,
        body: opened.scene.as_ref()?.ego_footprint_at(step),
        motion: opened.motion_of(On::Ego, step)?,
        stands: false,
    })
}

/// 3 picked, 2 in danger of collision, 1 risky, 0 any other.
fn importance(model: &Model, opened: &Opened, obstacle: &Obstacle, step: i64) -> u8 {
    let risk = opened
        .series
        .as_ref()
        .and_then(|s| s.at("risk", obstacle.id, step).value());
    match risk {
        Some(risk) if risk <= 1.0 => 2,
        _ if model.picked == Some(obstacle.id) => 3,
        Some(risk) if risk <= 2.0 => 1,
        _ => 0,
    }
}

/// A line from the front, as long as the way of the next half second; under the bodies it crosses.
pub fn velocity(
    ctx: &mut Context<'_>,
    view: &Projection,
    body: &Footprint,
    motion: &Motion,
    color: Color,
) {
    if motion.velocity.abs() > STANDING && view.sees_point(&motion.pose.position) {
        let here = motion.pose.position;
        let (rear, front) = body.at(motion.pose).extent(&here, &motion.pose.forward());
        let reach = if motion.velocity > 0.0 { front } else { rear };
        let nose = here + motion.pose.forward() * reach;
        stroke(
            ctx,
            view,
            &[nose, nose + motion.velocity_vector() * AHEAD],
            color,
        );
    }
}

fn draw_body(ctx: &mut Context<'_>, view: &Projection, drawn: &Drawn<'_>) {
    let (body, motion, color) = (drawn.body, drawn.motion, drawn.color);
    let placed = body.at(motion.pose);
    let (here, forward) = (motion.pose.position, motion.pose.forward());
    let (rear, front) = placed.extent(&here, &forward);
    let part = |part: f64| rear + (front - rear) * part;
    let dots = (front - rear) / view.dot;
    let rings = placed.outlines();
    let mut fill = |ring: &[Point]| {
        let corners: Vec<(f64, f64)> = ring.iter().map(|p| view.at(p)).collect();
        ctx.draw(&Fill::solid(&corners, color));
    };
    if drawn.stands {
        // Static bodies are hollow, moving ones filled.
        if dots < OUTLINE {
            rings.iter().for_each(|ring| fill(ring));
        }
    } else if dots >= SCREENED {
        for ring in &rings {
            for stretch in [(f64::MIN, part(SCREEN.0)), (part(SCREEN.1), f64::MAX)] {
                fill(&cut(ring, &here, &forward, stretch));
            }
        }
    } else if let [ring] = rings.as_slice() {
        fill(&cut(ring, &here, &forward, (f64::MIN, part(POINTED))));
        let aside = motion.pose.left();
        let (right, left) = placed.extent(&here, &aside);
        let base = here + forward * part(POINTED);
        let nose = here + forward * front + aside * f64::midpoint(left, right);
        fill(&[base + aside * left, nose, base + aside * right]);
        // A narrow body may fall between all dots.
        stroke(ctx, view, &[here + forward * rear, nose], color);
        return;
    } else {
        rings.iter().for_each(|ring| fill(ring));
    }
    for mut closed in rings {
        closed.extend(closed.first().copied());
        stroke(ctx, view, &closed, color);
    }
    if drawn.stands && dots >= OUTLINE {
        stroke(ctx, view, &[here, here + forward * front], color);
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
    fn arrows_point_where_somebody_goes() {
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
