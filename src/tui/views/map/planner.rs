//! The planner's view at the cursor, and the recorded ego beside the planned one.
//!
//! Feasible candidates are lines, rejected ones dots, the chosen one a thick line with its seconds; predicted bodies
//! are outlines; the recorded ego's path is dashed and its body hollow.

use ratatui::style::{Modifier, Style};

use super::CellView;
use super::label_placer::LabelPlacer;
use crate::render::scene::{LineStyle, Outline, Overlay, Role};
use crate::tui::loaded::CycleShown;
use crate::tui::model::Model;

/// The cycle at the cursor, if it is to be seen.
fn cycle(model: &Model) -> Option<&CycleShown> {
    model.cycle().filter(|_| model.map.layers.planner)
}

/// The fan: rejected candidates under those that can be driven.
pub fn fan(model: &Model) -> impl Iterator<Item = Overlay> + '_ {
    let lines = cycle(model).into_iter().flat_map(|cycle| cycle.fan.lines());
    lines.map(|(line, drivable)| match drivable {
        true => Overlay::path(Role::Feasible, LineStyle::Solid, line),
        false => Overlay::path(Role::Rejected, LineStyle::Dotted, line),
    })
}

/// Where the recorded ego went and where it is, predicted bodies, and above them what was chosen.
pub fn overlays(model: &Model, step: i64) -> Vec<Overlay> {
    let mut found = Vec::new();
    if let Some(scene) = model.recorded_beside() {
        let way = scene.ego.track.iter();
        let way = way.map(|(_, m)| m.pose.position).collect();
        found.push(Overlay::path(Role::RecordedEgo, LineStyle::Dashed, way));
        found.extend(scene.ego_at(step).map(|body| {
            Overlay::Outline(Outline {
                role: Role::RecordedEgo,
                faint: false,
                rings: body.outlines(),
                name: Some("recorded".into()),
            })
        }));
    }
    if let Some(cycle) = cycle(model) {
        found.extend(cycle.foreseen.iter().map(|body| {
            Overlay::Outline(Outline {
                role: Role::PredictedBody,
                faint: !body.avoided,
                rings: vec![body.corners.to_vec()],
                name: None,
            })
        }));
        let chosen = cycle.chosen.clone();
        found.push(Overlay::path(Role::Ego, LineStyle::Thick, chosen));
    }
    found
}

/// The full seconds on what was chosen.
pub fn seconds(board: &mut LabelPlacer<'_>, model: &Model, view: &CellView) {
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
