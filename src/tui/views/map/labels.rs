//! Names beside the vehicles that matter now: few, and never overlapping.

use ratatui::style::{Modifier, Style};

use super::Projection;
use super::label_placer::{Area, Body, LabelPlacer};
use crate::geometry::Placed;
use crate::tui::loaded::Opened;
use crate::tui::model::{Model, On};

/// Obstacles named at once, beside the picked one.
const MOST: usize = 7;

struct Label {
    text: String,
    style: Style,
    /// Around the vehicle.
    body: Area,
    whose: On,
}

pub fn draw(
    board: &mut LabelPlacer<'_>,
    model: &Model,
    opened: &Opened,
    view: &Projection,
    step: i64,
) {
    let theme = &model.theme;
    let bold = |color| Style::new().fg(color).add_modifier(Modifier::BOLD);
    let mut labels = Vec::new();
    if let Some(body) = opened.body_of(On::Ego, step).and_then(|b| around(view, &b)) {
        labels.push(Label {
            text: match model.planned() {
                Some(_) => "ego planned".into(),
                None => "ego".into(),
            },
            style: bold(theme.ego),
            body: board.cells(&body),
            whose: On::Ego,
        });
    }
    let attacker = model.variant().map(|shown| shown.made.effect.attacker);
    let wanted = if model.map.layers.labels {
        wanted(model, opened, view, step)
    } else {
        model.picked.into_iter().collect()
    };
    for id in wanted {
        let placed = opened.body_of(On::Obstacle(id), step);
        let placed = placed.filter(|p| view.sees_point(&p.pose.position));
        let Some(body) = placed.and_then(|placed| around(view, &placed)) else {
            continue;
        };
        let value = |measure| {
            opened
                .series
                .as_ref()
                .and_then(|s| s.at(measure, id, step).value())
        };
        let (text, style) = match (value("distance"), value("risk")) {
            (Some(0.0), _) => (format!("X {id} contact"), bold(theme.danger)),
            (_, Some(risk)) if risk <= 1.0 => (format!("! {id}"), bold(theme.danger)),
            _ if model.picked == Some(id) => (id.to_string(), bold(theme.picked)),
            (_, Some(risk)) if risk <= 2.0 => (id.to_string(), Style::new().fg(theme.warning)),
            _ => (id.to_string(), Style::new().fg(theme.dim)),
        };
        let (text, style) = match model.variant() {
            Some(shown) if shown.made.effect.attacker == id => match shown.changed {
                true => (format!("{text} attacker"), bold(theme.attacker)),
                false => (format!("{text} recorded"), style),
            },
            _ => (text, style),
        };
        let body = board.cells(&body);
        labels.push(Label {
            text,
            style,
            body,
            whose: On::Obstacle(id),
        });
    }
    let first = labels
        .iter()
        .position(|label| Some(label.whose) == attacker.map(On::Obstacle));
    if let Some(first) = first {
        let attackers = labels.remove(first);
        most_telling(board, &attackers, &labels);
    }
    for label in &labels {
        board.reserve(label.body);
    }
    for label in labels {
        board.beside(&label.body, &label.text, label.style);
    }
}

/// The attacker's label has its place before all others. Where there is little room it loses words, and if nothing else
/// helps, it covers others, but never the ego.
fn most_telling(board: &mut LabelPlacer<'_>, label: &Label, others: &[Label]) {
    board.reserve(label.body);
    let ego = others.iter().filter(|other| other.whose == On::Ego);
    ego.for_each(|ego| board.reserve(ego.body));
    let bodies: Vec<Area> = others.iter().map(|other| other.body).collect();
    let shorter = label.text.replace(" contact ", " ");
    let shortest = shorter.rsplit_once(' ').map_or("", |(start, _)| start);
    let texts = [&label.text, &shorter, shortest];
    for clear_of in [&bodies[..], &[]] {
        let mut texts = texts.iter().filter(|text| !text.is_empty());
        if texts.any(|text| board.beside_clear_of(clear_of, &label.body, text, label.style)) {
            return;
        }
    }
}

/// The attacker of a variant and the picked obstacle, then those nearest to the ego at this step, or without an ego to the middle of the map.
fn wanted(model: &Model, opened: &Opened, view: &Projection, step: i64) -> Vec<i64> {
    let mut near: Vec<(f64, i64)> = match &opened.series {
        Some(series) => series
            .obstacles()
            .iter()
            .filter_map(|&id| Some((series.at("distance", id, step).value()?, id)))
            .collect(),
        None => opened
            .scenario
            .obstacles
            .iter()
            .filter_map(|o| {
                let (x, y) = view.at(&o.motion_at(step)?.pose.position);
                Some((x.hypot(y), o.id))
            })
            .collect(),
    };
    near.sort_by(|a, b| a.0.total_cmp(&b.0));
    let attacker = model.variant().map(|shown| shown.made.effect.attacker);
    let attacker = attacker.filter(|id| Some(*id) != model.picked);
    let others = near
        .into_iter()
        .map(|(_, id)| id)
        .filter(|id| Some(*id) != model.picked && Some(*id) != attacker);
    let first = model.picked.into_iter().chain(attacker);
    first.chain(others.take(MOST)).collect()
}

/// Around a body, on the canvas.
fn around(view: &Projection, body: &Placed<'_>) -> Option<Body> {
    Body::around(body.outlines().iter().flatten().map(|p| view.at(p)))
}
