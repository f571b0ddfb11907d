//! Abandons a batch whose results can no longer be fetched, so that its questions can be asked again.

use std::collections::BTreeSet;
use std::sync::Arc;

use super::{Progress, RemoteError, collect};
use crate::evaluation::judges::ModelJudge;
use nearmiss_store::{Ending, ProviderBatchId, ProviderBatchState, RunState, Store};

/// Why a question has no answer whose batch was given up.
const GIVEN_UP: &str =
    "its batch was given up; the provider may still have answered and charged for it";

/// Outcome of abandoning a batch.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum GivenUp {
    /// These questions of it are free now.
    Freed {
        /// How many.
        questions: u64,
        /// The batches of `evaluate` that they are of.
        batches: Vec<String>,
    },
    /// There was nothing to give up: this is what collecting it came to.
    Collected(Progress),
}

/// Gives a batch up that the provider does not have any more. It is collected first, so that no answer that can be had
/// is given up.
///
/// # Errors
/// The provider still works on it, or cannot be asked.
pub async fn give_up(
    id: ProviderBatchId,
    model: &ModelJudge,
    store: &Arc<Store>,
) -> Result<GivenUp, RemoteError> {
    match collect(id, model, store).await {
        Ok(progress) if progress.is_open() => Err(RemoteError::Kept(id)),
        Ok(progress) => Ok(GivenUp::Collected(progress)),
        Err(RemoteError::Gone { error, .. }) => {
            give_up_unasked(id, &format!("given up: {error}"), store)
        }
        Err(error) => Err(error),
    }
}

/// The same without asking the provider; `why` is kept with the batch.
///
/// # Errors
/// There is no such batch, or the store cannot be written.
pub fn give_up_unasked(
    id: ProviderBatchId,
    why: &str,
    store: &Store,
) -> Result<GivenUp, RemoteError> {
    let batch = store.provider_batch(id)?.ok_or(RemoteError::NoBatch(id))?;
    let mut batches = BTreeSet::new();
    for handed in store.handed(id)? {
        let run = store.run(handed.run)?;
        batches.extend(run.and_then(|run| run.question.batch));
    }
    let questions = if batch.state.is_open() {
        let rest = Ending {
            error: Some(GIVEN_UP.into()),
            ..Ending::bare(RunState::Failed)
        };
        store.close_provider_batch(id, ProviderBatchState::Failed, Some(why), &rest)?
    } else {
        0
    };
    Ok(GivenUp::Freed {
        questions,
        batches: batches.into_iter().collect(),
    })
}
