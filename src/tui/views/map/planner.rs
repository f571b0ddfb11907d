//! The planner's view at the cursor, and the recorded ego beside the planned one.
//!
//! Feasible candidates are lines, rejected ones dots, the chosen one a thick line with its seconds; predicted bodies
//! are outlines; the recorded ego's path is dashed and its body hollow.

use ratatui::style::{Color, Modifier, Style};
use ratatui::widgets::canvas::{Context, Points};

use super::label_placer::{Body, LabelPlacer};
use super::paths::{DASH, walk};
use super::{Projection, stroke};
use crate::geometry::{Bounds, Point};
use crate::tui::loaded::CycleShown;
use crate::tui::model::Model;

/// Dots from one dot to the next of what was rejected.
const SPARSE: f64 = 5.0;

/// The cycle at the cursor, if it is to be seen.
fn cycle(model: &Model) -> Option<&CycleShown> {
    model.cycle().filter(|_| model.map.layers.planner)
}

/// The fan: rejected candidates under those that can be driven.
pub fn fan(ctx: &mut Context<'_>, model: &Model, view: &Projection) {
    let Some(cycle) = cycle(model) else { return };
    let theme = &model.theme;
    let mut dots = Vec::new();
    for (line, drivable) in cycle.fan.lines() {
        if !Bounds::from_points(&line).is_some_and(|bounds| view.sees(&bounds)) {
            continue;
        }
        if drivable {
            stroke(ctx, view, &line, theme.safe);
        } else {
            walk(view, &line, 0.0, SPARSE * view.dot, |at, _| dots.push(at));
        }
    }
    ctx.draw(&Points {
        coords: &dots,
        color: theme.dim,
    });
}

/// Predicted bodies, and above them what was chosen.
pub fn chosen(ctx: &mut Context<'_>, model: &Model, view: &Projection) {
    let Some(cycle) = cycle(model) else { return };
    let theme = &model.theme;
    for body in &cycle.foreseen {
        let [a, b, c, d] = body.corners;
        if !view.sees_around(&a, (c - a).norm()) {
            continue;
        }
        if body.avoided {
            stroke(ctx, view, &[a, b, c, d, a], theme.predicted);
        } else {
            let coords = body.corners.map(|corner| view.at(&corner));
            ctx.draw(&Points {
                coords: &coords,
                color: theme.predicted,
            });
        }
    }
    ctx.layer();
    thick(ctx, view, &cycle.chosen, theme.ego);
}

/// A line of two dots across.
pub fn thick(ctx: &mut Context<'_>, view: &Projection, line: &[Point], color: Color) {
    stroke(ctx, view, line, color);
    let beside: Vec<Point> = line
        .windows(2)
        .filter_map(|pair| {
            let along = pair[1] - pair[0];
            let length = along.norm();
            let across = crate::geometry::Vector::new(-along.y, along.x) * (view.dot / length);
            (length > 0.0).then(|| pair[0] + across)
        })
        .collect();
    stroke(ctx, view, &beside, color);
}

/// The full seconds on what was chosen.
pub fn seconds(board: &mut LabelPlacer<'_>, model: &Model, view: &Projection) {
    let Some(cycle) = cycle(model) else { return };
    let style = Style::new()
        .fg(model.theme.ego)
        .add_modifier(Modifier::BOLD);
    let places = cycle.chosen.iter().step_by(cycle.second).skip(1);
    let mut last = cycle.chosen.first().copied();
    for (place, second) in places.zip(1..10) {
        // For a standing vehicle, all would fall into one cell.
        if last.is_some_and(|last| (place - last).norm() < 2.0 * view.cell.0) {
            continue;
        }
        if board.put_if_free(view.at(place), &second.to_string(), style) {
            last = Some(*place);
        }
    }
}

/// Where the recorded ego went, and where it is.
pub fn recorded(ctx: &mut Context<'_>, model: &Model, view: &Projection, step: i64) {
    let Some(scene) = model.recorded_beside() else {
        return;
    };
    let color = model.theme.text;
    let way: Vec<Point> = scene
        .ego
        .track
        .iter()
        .map(|(_, m)| m.pose.position)
        .collect();
    let (on, off) = DASH;
    walk(view, &way, on * view.dot, off * view.dot, |from, to| {
        let line = ratatui::widgets::canvas::Line::new(from.0, from.1, to.0, to.1, color);
        ctx.draw(&line);
    });
    let body = scene.ego_at(step);
    for mut ring in body.iter().flat_map(|body| body.outlines()) {
        ring.extend(ring.first().copied());
        stroke(ctx, view, &ring, color);
    }
}

/// The name of the recorded ego.
pub fn name(board: &mut LabelPlacer<'_>, model: &Model, view: &Projection, step: i64) {
    let placed = model.recorded_beside().and_then(|scene| scene.ego_at(step));
    let corners = placed.map(|body| body.outlines().concat());
    let corners = corners.iter().flatten().map(|p| view.at(p));
    if let Some(body) = Body::around(corners) {
        let cells = board.cells(&body);
        board.beside(&cells, "recorded", Style::new().fg(model.theme.text));
    }
}
