//! The planner's view at a moment, and the recorded ego beside the planned one.
//!
//! Feasible candidates are lines, rejected ones dots, the chosen one a thick line with its seconds; predicted bodies
//! are outlines; the recorded ego's path is dashed and its body hollow.

use ratatui::style::{Modifier, Style};

use super::CellView;
use super::label_placer::LabelPlacer;
use crate::loaded::CycleShown;
use crate::model::{Model, Moment};
use nearmiss_render::scene::{LineStyle, Outline, Overlay, Role};

/// The cycle of the moment, if it is to be seen.
fn cycle<'a>(model: &Model, moment: &Moment<'a>) -> Option<&'a CycleShown> {
    moment.cycle().filter(|_| model.map.layers.planner)
}

/// The fan: candidates that can be driven, over the rejected ones where those are shown.
pub fn fan<'a>(model: &Model, moment: &Moment<'a>) -> impl Iterator<Item = Overlay> + use<'a> {
    let lines = cycle(model, moment)
        .into_iter()
        .flat_map(|cycle| cycle.fan.lines());
    let rejected = model.map.layers.rejected;
    let lines = lines.filter(move |(_, drivable)| *drivable || rejected);
    lines.map(|(line, drivable)| {
        if drivable {
            Overlay::path(Role::Feasible, LineStyle::Solid, line)
        } else {
            Overlay::path(Role::Rejected, LineStyle::Dotted, line)
        }
    })
}

/// Where the recorded ego went and where it is, predicted bodies, and above them what was chosen.
pub fn overlays(model: &Model, moment: &Moment<'_>) -> Vec<Overlay> {
    let mut found = Vec::new();
    if let Some(scene) = moment.recorded().filter(|_| model.map.layers.planner) {
        let way = scene
            .ego
            .track
            .iter()
            .map(|(_, m)| m.pose.position)
            .collect();
        found.push(Overlay::path(Role::RecordedEgo, LineStyle::Dashed, way));
        found.extend(scene.ego_at(moment.step).map(|body| {
            Overlay::Outline(Outline {
                role: Role::RecordedEgo,
                faint: false,
                rings: body.outlines(),
                name: Some("recorded".into()),
            })
        }));
    }
    if let Some(cycle) = cycle(model, moment) {
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
pub fn seconds(board: &mut LabelPlacer<'_>, model: &Model, moment: &Moment<'_>, view: &CellView) {
    let Some(cycle) = cycle(model, moment) else {
        return;
    };
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
