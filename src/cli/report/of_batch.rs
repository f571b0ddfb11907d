//! The report of a batch of `evaluate`.

use super::Made;
use crate::cli::{Failure, output};
use crate::evaluation::batch::{self, Spec};
use crate::evaluation::report::Report;
use crate::store::{BatchId, ItemState, Store};

/// A batch of `evaluate`: every question of it, also those without an answer, beside the truth that it was begun with.
pub fn made(store: &Store, id: BatchId) -> Result<Made, Failure> {
    let Some(batch) = store.batch(id).map_err(Failure::input)? else {
        return Err(Failure::input(format!(
            "there is no batch {id}; `nearmiss evaluate --list` lists them"
        )));
    };
    let spec = Spec::from_json(&batch.spec).map_err(Failure::input)?;
    let answers = batch::answers(store, id).map_err(Failure::input)?;
    let batch::Answers {
        plain: scored,
        others,
        ..
    } = answers;
    let items = store.items(id).map_err(Failure::input)?;
    // Only of those that are counted: the scenes as they are, with the first lead.
    let first = items.iter().find_map(|i| i.asked.lead.clone());
    let waiting = items
        .iter()
        .filter(|i| i.state == ItemState::Waiting && i.asked.transform.is_none())
        .filter(|i| i.asked.lead.is_none() || i.asked.lead == first)
        .count();
    let mut notes = vec![format!(
        "Batch {id}: {} questions. Truth: {}.",
        scored.len(),
        output::visible(&spec.truth.words())
    )];
    notes.push(output::visible(&spec.asked_words()));
    if others > 0 {
        notes.push(format!(
            "{others} more, about changed scenes or at other leads, are not counted here; `nearmiss evaluate --resume \
             {id}` tells about them."
        ));
    }
    if waiting > 0 {
        let unfinished = format!(
            "The batch is not finished: {waiting} of its questions were not answered yet, and count as failed here. \
             `nearmiss evaluate --resume {id}` goes on with it."
        );
        output::say(&format!("nearmiss: {unfinished}"));
        notes.push(unfinished);
    }
    if scored.iter().all(|one| one.reference.is_none()) {
        notes.push(
            "Agreement with the built-in judge is counted where reference/geometry is one of the batch's models.".into(),
        );
    }
    Ok(Made::Report(Report::of(&scored), notes))
}
