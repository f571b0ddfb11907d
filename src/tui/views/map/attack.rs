//! The attacker's two motions over each other: the recorded one dashed, the changed one a thick line; the body not
//! driven in the shown scene is hollow.

use ratatui::style::{Modifier, Style};
use ratatui::widgets::canvas::{Context, Line};

use super::label_placer::{Body, LabelPlacer};
use super::paths::{DASH, walk};
use super::planner::thick;
use super::{Projection, stroke};
use crate::geometry::{Placed, Point};
use crate::tui::loaded::VariantShown;
use crate::tui::model::Model;

/// The variant, if its motions are to be seen.
fn shown(model: &Model) -> Option<&VariantShown> {
    model.variant().filter(|_| model.map.layers.variant)
}

/// The attacker's body in the scenario that is not shown, at a step.
fn other(shown: &VariantShown, step: i64) -> Option<Placed<'_>> {
    let made = &shown.made;
    let scenario = match shown.changed {
        true => made.closed.scenario(),
        false => &made.effect.scenario,
    };
    scenario.obstacle(made.effect.attacker)?.placed_at(step)
}

/// Both ways from where they part, and the body that would be elsewhere.
pub fn motions(ctx: &mut Context<'_>, model: &Model, view: &Projection, step: i64) {
    let Some(shown) = shown(model) else { return };
    let (made, theme) = (&shown.made, &model.theme);
    let (id, from) = (made.effect.attacker, made.effect.from);
    if let Some(obstacle) = made.closed.scenario().obstacle(id) {
        let after = obstacle.track().during(&(from..=i64::MAX));
        let way: Vec<Point> = after.iter().map(|(_, m)| m.pose.position).collect();
        let (on, off) = DASH;
        walk(view, &way, on * view.dot, off * view.dot, |a, b| {
            ctx.draw(&Line::new(a.0, a.1, b.0, b.1, theme.dim));
        });
    }
    ctx.layer();
    let changed = made.change.motions.iter();
    let way: Vec<Point> = changed.map(|(_, m)| m.pose.position).collect();
    thick(ctx, view, &way, theme.attacker);
    let color = match shown.changed {
        true => theme.dim,
        false => theme.attacker,
    };
    let body = other(shown, step);
    for mut ring in body.iter().flat_map(Placed::outlines) {
        ring.extend(ring.first().copied());
        stroke(ctx, view, &ring, color);
    }
}

/// Names the hollow body, if the two are apart.
pub fn name(board: &mut LabelPlacer<'_>, model: &Model, view: &Projection, step: i64) {
    let Some(shown) = shown(model).filter(|shown| step > shown.made.effect.from) else {
        return;
    };
    let (word, color) = match shown.changed {
        true => ("recorded", model.theme.dim),
        false => ("changed", model.theme.attacker),
    };
    let id = shown.made.effect.attacker;
    let corners = other(shown, step).map(|body| body.outlines().concat());
    if let Some(body) = Body::around(corners.iter().flatten().map(|p| view.at(p))) {
        let cells = board.cells(&body);
        let style = Style::new().fg(color).add_modifier(Modifier::BOLD);
        board.beside(&cells, &format!("{id} {word}"), style);
    }
}
