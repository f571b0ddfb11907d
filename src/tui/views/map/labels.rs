//! Names beside the vehicles that matter now: few, and never overlapping.

use ratatui::style::{Modifier, Style};

use super::CellView;
use super::label_placer::{Area, Body, LabelPlacer};
use crate::model::{Model, Moment};
use nearmiss_render::cells::attacker_color;
use nearmiss_render::scene::{Importance, MAX_NAMED, MapScene, Owner, Role};

struct Label {
    text: String,
    style: Style,
    /// Around the vehicle.
    body: Area,
    owner: Owner,
}

pub fn draw(
    board: &mut LabelPlacer<'_>,
    model: &Model,
    moment: &Moment<'_>,
    scene: &MapScene<'_>,
    view: &CellView,
) {
    let theme = &model.theme;
    let bold = |color| Style::new().fg(color).add_modifier(Modifier::BOLD);
    let touches = |id| scene.contacts.iter().any(|contact| contact.obstacle == id);
    let mut labels = Vec::new();
    for named in scene.named(MAX_NAMED) {
        let outside = !view.sees_point(&named.motion.pose.position);
        let corners = named.rings.iter().flatten().map(|p| view.at(p));
        let Some(body) = Body::around(corners) else {
            continue;
        };
        let (text, style) = match named.owner {
            Owner::Ego => match moment.opened.planned {
                Some(_) => ("ego planned".into(), bold(theme.ego)),
                None => ("ego".into(), bold(theme.ego)),
            },
            _ if outside || !(model.map.layers.labels || named.highlighted.is_some()) => continue,
            Owner::Obstacle(id) => match (touches(id), named.importance) {
                (true, _) => (format!("X {id} contact"), bold(theme.danger)),
                (_, Importance::Danger) => (format!("! {id}"), bold(theme.danger)),
                (_, Importance::Highlighted) => (id.to_string(), bold(theme.picked)),
                (_, Importance::Risky) => (id.to_string(), Style::new().fg(theme.warning)),
                _ => (id.to_string(), Style::new().fg(theme.dim)),
            },
        };
        let place = scene.attacker_place(named.owner);
        let (text, style) = match (named.role, place) {
            (_, None) => (text, style),
            (Role::Attacker(place), _) => (
                format!("{text} attacker"),
                bold(attacker_color(theme, place)),
            ),
            _ => (format!("{text} recorded"), style),
        };
        let body = board.cells(&body);
        labels.push(Label {
            text,
            style,
            body,
            owner: named.owner,
        });
    }
    let first = labels
        .iter()
        .position(|label| scene.is_attacker(label.owner));
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
    let ego = others.iter().filter(|other| other.owner == Owner::Ego);
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
