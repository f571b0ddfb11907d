//! Past, recorded and predicted paths, each with its own line style.

use ratatui::style::{Modifier, Style};
use ratatui::widgets::canvas::{Context, Points};

use super::label_placer::{Body, LabelPlacer};
use super::lines::{CROSSES, stroke};
use super::{CellView, Theme, color};
use crate::geometry::Point;
use crate::render::scene::{LineStyle, MapScene, Overlay, Owner, Role};
use crate::tui::model::{Foreseen, Model, On};

/// Marks the end of a constant-velocity path.
const STRAIGHT: &str = "x";

/// Lines behind everyone, dots ahead of them as far as they are recorded: a dot for every other step.
pub fn trails(ctx: &mut Context<'_>, theme: &Theme, scene: &MapScene<'_>, view: &CellView) {
    for trail in &scene.trails {
        let (past, future) = match (trail.owner, trail.highlighted) {
            (Owner::Ego, _) => (theme.ego_trail, theme.ego_trail),
            (_, Some(_)) => (theme.trail, theme.picked),
            (_, None) => (theme.trail, theme.trail),
        };
        for pair in trail.past.windows(2) {
            let ends = [pair[0].1.pose.position, pair[1].1.pose.position];
            stroke(ctx, view, &ends, past);
        }
        let ahead = trail.future.iter().step_by(2);
        let coords: Vec<(f64, f64)> = ahead.map(|(_, m)| view.at(&m.pose.position)).collect();
        ctx.draw(&Points {
            coords: &coords,
            color: future,
        });
    }
}

/// Predicted courses dashed, the way straight on as crosses: recorded futures are dots.
pub fn predictions(model: &Model) -> Vec<Overlay> {
    let mut found = Vec::new();
    for future in &model.map.foresight.futures {
        let role = role(model, future.who);
        let courses = future.courses.iter().map(|(_, course)| course);
        found.extend(courses.map(|c| Overlay::path(role, LineStyle::Dashed, c.clone())));
        let straight = future.straight.clone();
        found.push(Overlay::path(
            Role::ConstantVelocity,
            LineStyle::Crossed,
            straight,
        ));
    }
    found
}

/// How likely each course of the picked obstacle is, and where the ways straight on end.
pub fn ends(board: &mut LabelPlacer<'_>, model: &Model, view: &CellView) {
    let alone = model.map.layers.paths == Foreseen::Picked;
    for future in &model.map.foresight.futures {
        let style = Style::new()
            .fg(color(&model.theme, Role::ConstantVelocity))
            .add_modifier(Modifier::BOLD);
        if let [first, .., end] = future.straight.as_slice()
            && (end - first).norm() > CROSSES * view.dot
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
        let style = Style::new().fg(color(&model.theme, role(model, future.who)));
        for (weight, course) in &future.courses {
            // Its end, or where it leaves the map.
            let end: Option<&Point> = course.iter().rfind(|p| view.sees_point(p));
            if let Some(body) = Body::around(end.map(|end| view.at(end))) {
                let cells = board.cells(&body);
                board.beside(&cells, &format!("{:.0}%", weight * 100.0), style);
            }
        }
    }
}

fn role(model: &Model, who: On) -> Role {
    match who {
        On::Ego => Role::Ego,
        On::Obstacle(id) if model.picked == Some(id) => Role::Highlighted(0),
        On::Obstacle(_) => Role::Prediction,
    }
}
