//! Claims: extracted once an answer is complete, and stepped through one by one.

use crate::features::answers::claims_state::TextClaims;
use crate::features::timeline;
use crate::model::{Column, Document, Model, Pane, ShownAnswer};
use crate::request::Computation;
use crate::update::opening;
use nearmiss_scene::scenario::Scene;
use nearmiss_study::evaluation::claims::{Claim, Subject, sentences};
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
    let shown = model.answers.shown;
    let document = model.document(shown);
    let has_line = document.is_some_and(|d| model.claims.picked_of(d.key).is_some());
    let picked = go(model, shown, forward);
    let Some(row) = picked.and_then(|picked| picked.row) else {
        return;
    };
    let row = model.drawn.before_text() + row;
    let extent = model.drawn.extent(Pane::Reasoning);
    if row <= extent.top || row + BELOW >= extent.top + extent.rows {
        // The words on the row above it are in sight, too; in a low pane the line on the claim takes a row of the text.
        let rows = extent.rows.saturating_sub(usize::from(!has_line));
        let above = (rows / 3).max(1).min(rows.saturating_sub(1));
        model.answers.scroll = Some(row.saturating_sub(above));
    }
}

/// Rows that the words on the picked claim may take below the text, and a line that is wrapped.
const BELOW: usize = 4;

/// A claim that was picked.
pub struct PickedClaim {
    pub claim: Claim,
    /// The row of the answer's text in which it ends; `None` where that was not drawn.
    pub row: Option<usize>,
}

/// Picks the next claim of an answer, the wrong ones first, or the one before: its obstacle is picked on the map, and the
/// clock goes to its step.
pub fn go(model: &mut Model, shown: ShownAnswer, forward: bool) -> Option<PickedClaim> {
    let document = model.document(shown)?;
    let claims = model.claims.get(document.key);
    if claims.is_empty() {
        model.say(if !document.complete {
            "the answer is still streaming"
        } else if model.claims.is_known(document.key) {
            "this answer has no claims"
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
    let (claim, step) = (claims[place].claim.clone(), claims[place].step);
    if document.folds_at(claim.span.start) {
        model.reading.unfold = true;
    }
    let row = row(model, shown, &document, claim.span.end);
    opening::leave_place(model);
    if !claim.is_of_ego {
        model.picked = Some(claim.obstacle);
    }
    model.clock.playing = false;
    if model.clock.step() != step {
        model.clock.go(step);
        timeline::stepped(model);
    }
    // The built-in judge's text may be another one at another step.
    let key = model.document(shown).map_or(document.key, |d| d.key);
    model.claims.picked = Some((key, place));
    Some(PickedClaim { claim, row })
}

/// The row of an answer's text, in the columns it was drawn in last, in which what ends at a byte ends.
pub fn row(model: &Model, shown: ShownAnswer, document: &Document, end: usize) -> Option<usize> {
    let marks = model.claims.marks(document.key);
    let mut readings = model.drawn.readings.borrow_mut();
    let reading = readings.answer(shown);
    reading.show_as(model.reading_mode());
    reading.row_of(end, &marks, &model.theme)
}

/// Claims of an answer, checked against the scene.
#[derive(Debug)]
pub struct CheckClaims(pub Arc<Document>, pub Arc<Scene>);

impl Computation for CheckClaims {
    /// The key of the document, and its claims.
    type Value = (u64, TextClaims);

    fn compute(self) -> Self::Value {
        let Self(document, scene) = self;
        let subject = Subject::new(&scene, document.times, document.window);
        let found = sentences(&document.text, &subject);
        (document.key, TextClaims::new(found))
    }

    fn take(model: &mut Model, (key, claims): Self::Value) {
        model.claims.take(key, claims);
    }
}
