//! The batches of an export.

use crate::Failure;
use crate::locked::LockedAnswers;
use nearmiss_store::{Batch, Filter, Item, ItemState, RunId, Store};

/// The batches that are exported with these runs, the oldest first: all without a filter, the one that is chosen where
/// nothing else is. With other filters there are none, as their answers would be missing.
pub fn chosen(store: &Store, filter: &Filter) -> Result<Vec<Batch>, Failure> {
    let alone = Filter {
        batch: filter.batch.clone(),
        ..Filter::default()
    };
    if *filter != alone {
        return Ok(Vec::new());
    }
    let wanted = |batch: &Batch| match &filter.batch {
        None => true,
        Some(name) => *name == batch.id.to_string(),
    };
    let all = store.batches().map_err(Failure::input)?;
    let batches = all.into_iter().rev().map(|(batch, _)| batch);
    Ok(batches.filter(wanted).collect())
}

/// Adds the answers to questions of these batches that were asked for elsewhere, so that each question has its own.
pub fn add_answers(
    store: &Store,
    batches: &[Batch],
    numbers: &mut Vec<RunId>,
) -> Result<(), Failure> {
    for batch in batches {
        let runs = store
            .question_runs(batch.id, 0, None)
            .map_err(Failure::input)?
            .into_values()
            .flatten();
        numbers.extend(runs.map(|run| run.run));
    }
    if !batches.is_empty() {
        numbers.sort_unstable();
        numbers.dedup();
    }
    Ok(())
}

/// A question whose answer is left out is open where it is imported.
pub fn without(item: Item, locked: &LockedAnswers) -> Item {
    match item.run {
        Some(run) if locked.has(run) => Item {
            run: None,
            state: ItemState::Waiting,
            error: None,
            ..item
        },
        _ => item,
    }
}
