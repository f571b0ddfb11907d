//! Collects a batch's results from its provider into the store, each once.

use std::collections::HashMap;
use std::sync::Arc;

use super::result::{EXPIRED, settled};
use super::{RemoteError, find};
use crate::evaluation::judges::ModelJudge;
use nearmiss_ask::llm::Error;
use nearmiss_ask::llm::batch::{BatchState, Batches, Outcome};
use nearmiss_store::{
    Ending, ProviderBatch, ProviderBatchId, ProviderBatchState, RunId, RunState, Store,
};

/// Progress of a submitted batch.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Progress {
    /// It is not yet known whether it reached the provider; ask again later.
    Unknown,
    /// It never did; its questions can be asked anew.
    NotSent,
    /// The provider works on it.
    Working {
        /// Whether it is being cancelled.
        cancelling: bool,
        /// Questions that were answered so far.
        answered: u64,
        /// Questions that failed so far.
        failed: u64,
    },
    /// Everything that there is of it is in the store.
    Over {
        /// How it ended.
        state: ProviderBatchState,
        /// Results that were taken into the store now.
        taken: usize,
        /// Questions that ended without a result now.
        without: u64,
    },
}

impl Progress {
    /// Whether asking again later may bring more.
    #[must_use]
    pub fn is_open(&self) -> bool {
        matches!(self, Self::Unknown | Self::Working { .. })
    }
}

/// Asks the provider how far a batch is, and takes its results into the store when it is over: also those of one that
/// was cancelled or expired. Doing so twice, or after being interrupted, takes no result twice.
///
/// # Errors
/// Results that were taken before the error are in the store.
pub async fn collect(
    id: ProviderBatchId,
    model: &ModelJudge,
    store: &Arc<Store>,
) -> Result<Progress, RemoteError> {
    let batch = known(id, model, store)?;
    if batch.state == ProviderBatchState::NotSent {
        return Ok(Progress::NotSent);
    }
    if !batch.state.is_open() {
        return Ok(over(batch.state, 0, 0));
    }
    let batches = Batches::new(&model.client, &model.endpoint, &model.name).await?;
    let Some(remote_id) = remote_id(&batch, &batches, store).await? else {
        return Ok(match known(id, model, store)?.state {
            ProviderBatchState::NotSent => Progress::NotSent,
            _ => Progress::Unknown,
        });
    };
    let status = batches
        .status(&remote_id)
        .await
        .map_err(|error| gone(id, error.into()))?;
    if !status.state.is_over() {
        return Ok(Progress::Working {
            cancelling: status.state == BatchState::Cancelling,
            answered: status.answered,
            failed: status.failed,
        });
    }
    let mut open: HashMap<String, RunId> = store
        .handed(id)?
        .into_iter()
        .map(|handed| (handed.custom_id, handed.run))
        .collect();
    let (mut taken, mut given) = (0, 0);
    let certain = batches
        .results(&remote_id, &status, |custom_id, outcome| {
            given += u64::from(matches!(outcome, Outcome::Answered(_) | Outcome::Failed(_)));
            // A result that is not open was collected before, or belongs to another submission.
            let Some(run) = open.remove(custom_id) else {
                return Ok(());
            };
            let Some(kept) = store.run(run)? else {
                return Ok(());
            };
            let result = settled(kept, outcome, model);
            taken += usize::from(store.settle(run, &result.pieces(), &result.ending)?);
            Ok::<_, RemoteError>(())
        })
        .await
        .map_err(|error| gone(id, error))?;
    // A file that was cut where nothing tells looks whole; what it lacks is paid for.
    if !certain && given < status.answered {
        return Err(RemoteError::Short {
            batch: id,
            said: status.answered,
            given,
        });
    }
    let (state, rest) = match status.state {
        BatchState::Cancelled => (
            ProviderBatchState::Cancelled,
            Ending::bare(RunState::Cancelled),
        ),
        BatchState::Expired => (ProviderBatchState::Expired, failed(EXPIRED)),
        BatchState::Failed => {
            let why = status.problem.as_deref().unwrap_or("without a reason");
            let why = format!("the provider rejected the batch: {why}");
            (ProviderBatchState::Failed, failed(&why))
        }
        _ if batch.state == ProviderBatchState::Cancelling => (
            ProviderBatchState::Cancelled,
            Ending::bare(RunState::Cancelled),
        ),
        _ => {
            let why = "the batch ended without a result for this question; ask again";
            (ProviderBatchState::Ended, failed(why))
        }
    };
    let without = store.close_provider_batch(id, state, status.problem.as_deref(), &rest)?;
    Ok(over(state, taken, without))
}

/// The error for a batch that the provider no longer knows.
fn gone(batch: ProviderBatchId, error: RemoteError) -> RemoteError {
    match error {
        RemoteError::Provider(
            error @ (Error::NotFound { .. } | Error::BadRequest { status: 410, .. }),
        ) => RemoteError::Gone { batch, error },
        other => other,
    }
}

fn over(state: ProviderBatchState, taken: usize, without: u64) -> Progress {
    Progress::Over {
        state,
        taken,
        without,
    }
}

fn failed(why: &str) -> Ending {
    Ending {
        error: Some(why.to_string()),
        ..Ending::bare(RunState::Failed)
    }
}

/// Asks the provider to stop working on a batch; [`collect`] takes what it had answered by then. Whether there was
/// anything to stop.
///
/// # Errors
/// It cannot be asked, or does not answer.
pub async fn cancel(
    id: ProviderBatchId,
    model: &ModelJudge,
    store: &Arc<Store>,
) -> Result<bool, RemoteError> {
    let batch = known(id, model, store)?;
    if !batch.state.is_open() {
        return Ok(false);
    }
    let batches = Batches::new(&model.client, &model.endpoint, &model.name).await?;
    let Some(remote_id) = remote_id(&batch, &batches, store).await? else {
        return Ok(false);
    };
    batches.cancel(&remote_id).await?;
    store.cancelling(id)?;
    Ok(true)
}

/// A batch of this model that the store has.
fn known(
    id: ProviderBatchId,
    model: &ModelJudge,
    store: &Store,
) -> Result<ProviderBatch, RemoteError> {
    let batch = store.provider_batch(id)?.ok_or(RemoteError::NoBatch(id))?;
    let now = model.endpoint.place().url;
    if batch.state.is_open() && batch.address != now {
        return Err(RemoteError::Elsewhere {
            batch: id,
            sent: batch.address,
            model: batch.model,
            now,
        });
    }
    Ok(batch)
}

/// The provider's id of a batch, looked for where it did not arrive.
async fn remote_id(
    batch: &ProviderBatch,
    batches: &Batches,
    store: &Store,
) -> Result<Option<String>, RemoteError> {
    match &batch.remote_id {
        Some(id) => Ok(Some(id.clone())),
        None => find(batch, batches, store).await,
    }
}
