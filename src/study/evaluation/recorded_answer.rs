//! Answers of recorded models, which were imported: whether the store has one to a question.

use super::judges::Judge;
use super::question::Question;
use super::request::record;
use super::run_case::RunOptions;
use nearmiss_store::{Key, Store, StoreError};

/// Whether the store has the answer of `judge` to a question, whose request has this key; of a recorded model that has
/// none, why it cannot be asked.
///
/// # Errors
/// The store cannot be read.
pub fn has_answer(
    question: &Question,
    (judge, key): (&Judge, Option<&Key>),
    sample: u32,
    store: &Store,
) -> Result<Result<bool, String>, StoreError> {
    if let Some(key) = key {
        return Ok(Ok(store.has_answer(key, sample)?));
    }
    if !matches!(judge, Judge::Recorded(_)) {
        return Ok(Ok(false));
    }
    let wanted = RunOptions {
        sample,
        ..RunOptions::default()
    };
    let found = store.recorded_answer(&record(question, judge, &wanted)?)?;
    Ok(match found {
        Some(_) => Ok(true),
        None => Err(not_recorded(question)),
    })
}

/// Why a recorded model has no answer to a question.
pub fn not_recorded(question: &Question) -> String {
    let case = &question.case;
    format!(
        "no recorded answer ({}, {} frame, {}); see `nearmiss runs import` and --protocol paper",
        case.task.name(),
        case.frame.name(),
        case.techniques,
    )
}
