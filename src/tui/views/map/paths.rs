//! Past, recorded and predicted paths, each with its own line style.

use ratatui::style::{Color, Modifier, Style};
use ratatui::widgets::canvas::{Context, Points};

use super::label_placer::{Body, LabelPlacer};
use super::vehicles::velocity;
use super::{Projection, stroke};
use crate::geometry::Point;
use crate::scenario::Track;
use crate::tui::loaded::Opened;
use crate::tui::model::{Foreseen, Model, On};

/// Seconds of the past, and of the recorded future, that obstacles have beside them.
const TRAIL: f64 = 2.0;
/// Dots of a dash and of the gap behind it.
pub const DASH: (f64, f64) = (5.0, 4.0);
/// Dots between the crosses of a constant-velocity path.
const APART: f64 = 9.0;
/// Pieces of a line that are longer than this are no pieces of a road, metres.
const FARTHEST: f64 = 1e100;
/// Dashes that fit on the largest map, at a period of a dot.
const MOST_DASHES: f64 = 10_000.0;
/// Marks the end of a constant-velocity path.
pub const STRAIGHT: &str = "x";

/// Lines behind everyone, dots ahead of them as far as they are recorded, and their velocities.
pub fn trails(ctx: &mut Context<'_>, model: &Model, opened: &Opened, view: &Projection, step: i64) {
    let theme = &model.theme;
    let span = (TRAIL / opened.scenario.dt()).ceil() as i64;
    let shown = model.map.layers.trails;
    for obstacle in &opened.scenario.obstacles {
        let track = obstacle.track();
        let picked = model.picked == Some(obstacle.id);
        let near = |step| {
            let there: Option<_> = track.at(step);
            there.is_some_and(|m| view.sees_around(&m.pose.position, view.half.0))
        };
        if !(picked || near(step) || near(step - span)) {
            continue;
        }
        if shown {
            past(ctx, view, track, step - span..=step, theme.trail);
            let (ahead, color) = match picked {
                true => (i64::MAX, theme.picked),
                false => (step.saturating_add(span), theme.trail),
            };
            recorded(ctx, view, track, step, ahead, color);
        }
        if let (Some(body), Some(motion)) = (obstacle.footprint_at(step), track.at(step)) {
            velocity(ctx, view, body, motion, theme.static_obstacle);
        }
    }
    if let Some(scene) = &opened.scene {
        let track = &scene.ego.track;
        if shown {
            past(ctx, view, track, i64::MIN..=step, theme.ego_trail);
            recorded(ctx, view, track, step, i64::MAX, theme.ego_trail);
        }
        if let Some(motion) = track.at(step) {
            velocity(ctx, view, scene.ego_footprint_at(step), motion, theme.ego);
        }
    }
}

fn past(
    ctx: &mut Context<'_>,
    view: &Projection,
    track: &Track,
    steps: std::ops::RangeInclusive<i64>,
    color: Color,
) {
    for pair in track.during(&steps).windows(2) {
        let ends = [pair[0].1.pose.position, pair[1].1.pose.position];
        stroke(ctx, view, &ends, color);
    }
}

/// A dot for every other step.
fn recorded(
    ctx: &mut Context<'_>,
    view: &Projection,
    track: &Track,
    step: i64,
    last: i64,
    color: Color,
) {
    let ahead = track.during(&(step..=last)).iter().step_by(2);
    let coords: Vec<(f64, f64)> = ahead.map(|(_, m)| view.at(&m.pose.position)).collect();
    ctx.draw(&Points {
        coords: &coords,
        color,
    });
}

/// Predicted courses dashed, the way straight on as crosses: recorded futures are dots.
pub fn futures(ctx: &mut Context<'_>, model: &Model, view: &Projection) {
    for future in &model.map.foresight.futures {
        let color = color(model, future.who);
        for (_, course) in &future.courses {
            let (on, off) = DASH;
            walk(view, course, on * view.dot, off * view.dot, |from, to| {
                ctx.draw(&ratatui::widgets::canvas::Line::new(
                    from.0, from.1, to.0, to.1, color,
                ));
            });
        }
        walk(view, &future.straight, 0.0, APART * view.dot, |at, _| {
            cross(ctx, view, at, model.theme.text);
        });
    }
}

/// A cross of three dots by three.
fn cross(ctx: &mut Context<'_>, view: &Projection, (x, y): (f64, f64), color: Color) {
    let d = view.dot;
    for side in [d, -d] {
        let line = ratatui::widgets::canvas::Line::new(x - d, y - side, x + d, y + side, color);
        ctx.draw(&line);
    }
}

/// How likely each course of the picked obstacle is, and where the ways straight on end.
pub fn ends(board: &mut LabelPlacer<'_>, model: &Model, view: &Projection) {
    let alone = model.map.layers.paths == Foreseen::Picked;
    for future in &model.map.foresight.futures {
        let style = Style::new()
            .fg(model.theme.text)
            .add_modifier(Modifier::BOLD);
        if let [first, .., end] = future.straight.as_slice()
            && (end - first).norm() > APART * view.dot
        {
            board.put_if_free(view.at(end), STRAIGHT, style);
        }
        if !(alone
            || model
                .picked
                .is_some_and(|id| future.who == On::Obstacle(id)))
        {
            continue;
        }
        for (weight, course) in &future.courses {
            // Its end, or where it leaves the map.
            let Some(end) = course.iter().rfind(|p| view.sees_point(p)) else {
                continue;
            };
            let Some(body) = Body::around([view.at(end)]) else {
                continue;
            };
            let cells = board.cells(&body);
            let words = format!("{:.0}%", weight * 100.0);
            let style = Style::new().fg(color(model, future.who));
            board.beside(&cells, &words, style);
        }
    }
}

fn color(model: &Model, who: On) -> Color {
    match who {
        On::Ego => model.theme.ego,
        On::Obstacle(id) if model.picked == Some(id) => model.theme.picked,
        On::Obstacle(_) => model.theme.accent,
    }
}

/// Walks along a line on the canvas: `on` metres that are handed over, `off` metres that are not, and so on.
pub fn walk(
    view: &Projection,
    line: &[Point],
    on: f64,
    off: f64,
    mut with: impl FnMut((f64, f64), (f64, f64)),
) {
    let period = on + off;
    let mut done = 0.0;
    for pair in line.windows(2) {
        let (from, to) = (view.at(&pair[0]), view.at(&pair[1]));
        let length = (to.0 - from.0).hypot(to.1 - from.1);
        // Too far away to be drawn.
        if length <= 0.0 || length.is_nan() || length > FARTHEST {
            continue;
        }
        // Only the visible part is sampled: coordinates may be of any size.
        let Some((enters, leaves)) = view.part_seen(from, to) else {
            done += length;
            continue;
        };
        let at = |s: f64| {
            let part = ((s - done) / length).clamp(0.0, 1.0);
            (
                from.0 + (to.0 - from.0) * part,
                from.1 + (to.1 - from.1) * part,
            )
        };
        // The first dash that reaches into this piece, or into what is seen of it.
        let first = ((done + enters * length - on) / period).ceil().max(0.0);
        let last = (done + leaves * length) / period;
        // Counted: a number that is large enough does not change by adding to it.
        let count = (last - first).floor().clamp(-1.0, MOST_DASHES);
        for dash in (0_u32..).map(f64::from).take_while(|dash| *dash <= count) {
            let start = (first + dash) * period;
            if start < done + length {
                with(at(start), at(start + on));
            }
        }
        done += length;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose;

    #[test]
    fn lines_of_any_length_have_as_many_dashes_as_are_seen() {
        let view = Projection::new(Pose::new(0.0, 0.0, 0.0), (50.0, 50.0), (2.0, 4.0));
        for far in [1e3, 1e9, 1e15, 1e100, f64::MAX, f64::INFINITY, f64::NAN] {
            for from in [(-far, 0.0), (0.0, 0.0), (far, far)] {
                let line = [from, (far, 0.0), (far, -far), (3.0, 4.0)];
                let line = line.map(|(x, y)| Point::new(x, y));
                let mut count = 0;
                walk(&view, &line, 5.0, 4.0, |_, _| count += 1);
                assert!(count < 200, "{count} dashes of {line:?}");
            }
        }
        let mut seen = 0;
        let line = [Point::new(-1e9, 0.0), Point::new(1e9, 0.0)];
        walk(&view, &line, 5.0, 5.0, |_, _| seen += 1);
        assert!((10..=14).contains(&seen), "{seen}");
    }

    #[test]
    fn dashes_go_on_across_corners() {
        let north = Pose::new(0.0, 0.0, std::f64::consts::FRAC_PI_2);
        let view = Projection::new(north, (50.0, 50.0), (2.0, 4.0));
        let line = [(0.0, 0.0), (4.0, 0.0), (4.0, 6.0)].map(|(x, y)| Point::new(x, y));
        let mut dashes = Vec::new();
        walk(&view, &line, 3.0, 2.0, |from, to| dashes.push((from, to)));
        let round = |(x, y): (f64, f64)| ((x * 1e6).round() / 1e6, (y * 1e6).round() / 1e6);
        let dashes: Vec<_> = dashes
            .into_iter()
            .map(|(a, b)| (round(a), round(b)))
            .collect();
        assert_eq!(dashes, [((0.0, 0.0), (3.0, 0.0)), ((4.0, 1.0), (4.0, 4.0))]);
        let mut dots = Vec::new();
        walk(&view, &line, 0.0, 4.0, |at, _| dots.push(round(at)));
        assert_eq!(dots, [(0.0, 0.0), (4.0, 0.0), (4.0, 4.0)]);
    }
}
