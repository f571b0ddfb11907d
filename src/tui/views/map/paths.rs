//! Predicted paths, each with its own line style.

use ratatui::style::{Modifier, Style};

use super::label_placer::{Body, LabelPlacer};
use crate::model::{Foreseen, Model, Moment, On};
use nearmiss_base::geometry::Point;
use nearmiss_render::cells::{CROSSES, CellView};
use nearmiss_render::scene::{LineStyle, Overlay, Role};

/// Marks the end of a constant-velocity path.
const STRAIGHT: &str = "x";

/// Predicted courses dashed, the way straight on as crosses: recorded futures are dots.
pub fn predictions(model: &Model, moment: &Moment<'_>) -> Vec<Overlay> {
    let mut found = Vec::new();
    for future in &moment.foresight.futures {
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
pub fn ends(board: &mut LabelPlacer<'_>, model: &Model, moment: &Moment<'_>, view: &CellView) {
    let alone = model.map.layers.paths == Foreseen::Picked;
    for future in &moment.foresight.futures {
        let style = Style::new()
            .fg(super::look(model).color(Role::ConstantVelocity))
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
        let style = Style::new().fg(super::look(model).color(role(model, future.who)));
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
