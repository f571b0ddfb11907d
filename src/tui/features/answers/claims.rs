//! Claims: extracted once an answer is complete, and stepped through one by one.

use crate::features::answers::claims_state::TextClaims;
use crate::features::timeline;
use crate::model::{Column, Document, Model, Pane, ShownAnswer};
use crate::request::Computation;
use crate::update::opening;
use nearmiss_scene::scenario::Scene;
use nearmiss_study::evaluation::claims::{Subject, checked, not_understood};
use std::sync::Arc;

/// Requests the claims of the complete answers on the screen, once for each.
pub fn request(model: &mut Model) -> Vec<CheckClaims> {
    let mut missing = Vec::new();
    let seen = if model.compare.open {
        model.compare.shown.clone()
    } else {
        vec![model.answers.shown]
    };
    for shown in seen {
        // A streaming answer is not parsed again for every chunk.
        let column = match shown {
            ShownAnswer::Reference => None,
            ShownAnswer::Column(place) => model.answers.columns.get(place),
        };
        if column.is_some_and(Column::is_running) {
            continue;
        }
        let Some(document) = model.document(shown) else {
            continue;
        };
        if !document.complete {
            continue;
        }
        let scene = model.opened.as_ref().and_then(|o| o.scene.clone());
        let Some(scene) = scene else { continue };
        if model.claims.request(document.key) {
            missing.push(CheckClaims(document, scene));
        }
    }
    missing
}

/// Picks the next claim of the reasoning, or the one before, and scrolls to it.
pub fn read_on(model: &mut Model, forward: bool) {
    let unfolded = model.reading.unfold || model.reading.raw;
    let Some(place) = go(model, model.answers.shown, forward) else {
        return;
    };
    let Some(row) = model.drawn.claim(place) else {
        return;
    };
    let lines = || folded_line(model, model.answers.shown, place);
    let folded = if unfolded { None } else { lines() }.unwrap_or(0);
    // JSON that was folded when it was last drawn is unfolded now.
    let row = row + folded;
    let extent = model.drawn.extent(Pane::Reasoning);
    if row < extent.top || row + BELOW >= extent.top + extent.rows {
        model.answers.scroll = Some(row.saturating_sub(extent.rows / 3));
    }
}

/// Rows that the words on the picked claim may take below the text, and a line that is wrapped.
const BELOW: usize = 4;

/// How many lines into JSON that folds a claim is.
fn folded_line(model: &Model, shown: ShownAnswer, place: usize) -> Option<usize> {
    let document = model.document(shown)?;
    let claims = model.claims.get(document.key);
    let at = claims.get(place)?.claim.span.start;
    document.folded_line(at)
}

/// Picks the next claim of an answer, the wrong ones first, or the one before: its obstacle is picked on the map, and the
/// clock goes to its step. Gives its place.
pub fn go(model: &mut Model, shown: ShownAnswer, forward: bool) -> Option<usize> {
    let document = model.document(shown)?;
    let claims = model.claims.get(document.key);
    if claims.is_empty() {
        model.say(if !document.complete {
            "the answer is still streaming"
        } else if model.claims.is_known(document.key) {
            "no claims about obstacles were found in this answer"
        } else {
            "checking the claims of this answer…"
        });
        return None;
    }
    let listed = model.claims.listed(document.key);
    let count = listed.len();
    let times = usize::try_from(model.look.times()).unwrap_or(1);
    let (first, more) = ((times - 1) % count, times % count);
    let picked = model.claims.picked_of(document.key);
    let now = picked.and_then(|place| listed.iter().position(|(listed, _)| *listed == place));
    let next = match now {
        None if forward => first,
        None => count - 1 - first,
        Some(now) if forward => (now + more) % count,
        Some(now) => (now + count - more) % count,
    };
    let (place, _) = listed[next];
    let claim = &claims[place];
    let (obstacle, step) = (claim.claim.obstacle, claim.step);
    opening::leave_place(model);
    model.picked = Some(obstacle);
    model.clock.playing = false;
    if model.clock.step() != step {
        model.clock.go(step);
        timeline::stepped(model);
    }
    if folded_line(model, shown, place).is_some() {
        model.reading.unfold = true;
    }
    // The built-in judge's text may be another one at another step.
    let key = model.document(shown).map_or(document.key, |d| d.key);
    model.claims.picked = Some((key, place));
    Some(place)
}

/// Claims of an answer, checked against the scene.
#[derive(Debug)]
pub struct CheckClaims(pub Arc<Document>, pub Arc<Scene>);

impl Computation for CheckClaims {
    /// The key of the document, and its claims.
    type Value = (u64, TextClaims);

    fn compute(self) -> Self::Value {
        let Self(document, scene) = self;
        let subject = Subject {
            scene: &scene,
            times: document.times,
            window: document.window,
        };
        let checked = checked(&document.text, &subject);
        let unread = not_understood(&document.text, &checked, &subject);
        (document.key, TextClaims::new(checked, unread))
    }

    fn take(model: &mut Model, (key, claims): Self::Value) {
        model.claims.take(key, claims);
    }
}
