//! Questions submitted to a provider as a batch and collected once answered, at half the price.
//!
//! The store records a batch before the provider receives it, and stores the provider's id before anything else
//! happens. If the program ended between the two, the batch is looked up at the provider; it is not submitted again.

mod collect;

use std::sync::Arc;

use jiff::Timestamp;

use super::ask_model::{record, request};
use super::judges::{Judge, ModelJudge};
use super::question::Question;
use super::run_case::RunOptions;
pub use collect::{GivenUp, Progress, cancel, collect, give_up, give_up_unasked};
use nearmiss_ask::llm::batch::{Batches, Item, Lookup, SubmissionMark, split, surely_not_created};
use nearmiss_ask::llm::{self, Error, Request};
use nearmiss_store::{
    Ending, NewProviderBatch, NewRun, ProviderBatch, ProviderBatchId, ProviderBatchState,
    ReadyBatch, RunState, Store, StoreError,
};

/// How long after it was sent a batch that is not found at the provider counts as on its way: longer than a server is
/// waited for.
const GRACE_MS: i64 = 5 * 60 * 1000;

/// Outcome of a submission.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SubmissionOutcome {
    /// The batches that the provider has now.
    pub batches: Vec<ProviderBatchId>,
    /// Questions in them.
    pub handed: usize,
    /// Questions whose answers the store had.
    pub stored: usize,
    /// Questions that another run asks now, or that are with the provider already.
    pub taken: usize,
    /// Notes for the user about the requests.
    pub notes: Vec<String>,
}

/// Why a batch was not submitted, or not collected.
#[derive(Debug, thiserror::Error)]
pub enum RemoteError {
    /// It can be known without asking that there will be no answer.
    #[error("nothing was sent: {0}")]
    Refused(String),
    /// The provider, or the way to it, failed.
    #[error(transparent)]
    Provider(#[from] Error),
    /// A batch was sent, and it is unknown whether it arrived.
    #[error(
        "batch {batch} may not have reached the provider: {error}; `nearmiss runs batches collect {batch}` finds out, and nothing is sent twice until then"
    )]
    Unknown {
        /// Its number.
        batch: ProviderBatchId,
        /// The error.
        error: Error,
    },
    /// The store cannot be read or written.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// Not all results arrived.
    #[error(
        "batch {batch}: the provider reports {said} answers but returned {given}; these are kept, collect the others later"
    )]
    Short {
        /// Its number.
        batch: ProviderBatchId,
        /// Answers that there are, as the provider counts.
        said: u64,
        /// Answers that it gave.
        given: u64,
    },
    /// The provider has no such batch any more, or not its results.
    #[error(
        "the provider no longer has it or its results ({error}); if so, `nearmiss runs batches give-up {batch}` frees its questions"
    )]
    Gone {
        /// Its number.
        batch: ProviderBatchId,
        /// The provider's error.
        error: Error,
    },
    /// A batch shall be given up that may still bring answers.
    #[error(
        "batch {0} may still be answered; run `nearmiss runs batches cancel {0}`, then collect it, or give it up with --force"
    )]
    Kept(ProviderBatchId),
    /// There is no such batch.
    #[error("no batch {0}; `nearmiss runs batches` lists all")]
    NoBatch(ProviderBatchId),
    /// The model is served elsewhere than when the batch was sent.
    #[error(
        "batch {batch} was sent to {sent}, but {model} is now at {now}; restore the provider's base_url"
    )]
    Elsewhere {
        /// Its number.
        batch: ProviderBatchId,
        /// The address it was sent to.
        sent: String,
        /// The model.
        model: String,
        /// The address that is configured.
        now: String,
    },
}

/// Submits questions to a model's provider, in as many batches as its limits require; skips those answered in the store
/// or in progress. Submissions that may or may not have arrived are looked up first.
///
/// # Errors
/// What was submitted before the error is in the store, and `collect` fetches its answers.
pub async fn submit(
    questions: &[(Question, RunOptions)],
    model: &ModelJudge,
    store: &Arc<Store>,
) -> Result<SubmissionOutcome, RemoteError> {
    let mut done = SubmissionOutcome::default();
    let judge = Judge::Model(Box::new(model.clone()));
    let mut asked: Vec<(NewRun, Request)> = Vec::new();
    for (question, wanted) in questions {
        let run = record(question, &judge, wanted).map_err(StoreError::from)?;
        if store.answer_to(&run)?.is_some() {
            done.stored += 1;
            continue;
        }
        let request = request(question, model);
        let checked = llm::check(&model.client, &model.endpoint, &request).await;
        checked.map_err(|why| RemoteError::Refused(why.to_string()))?;
        asked.push((run, request));
    }
    if asked.is_empty() {
        return Ok(done);
    }
    let (endpoint, place) = (&model.endpoint, model.endpoint.place());
    let batches = Batches::new(&model.client, endpoint, &model.name).await?;
    for batch in store.provider_batches()? {
        let ours = batch.address == place.url && batch.model == model.id;
        if ours && batch.state == ProviderBatchState::Submitting {
            find(&batch, &batches, store).await?;
        }
    }
    done.notes = llm::notes(endpoint, &asked[0].1);
    let new = NewProviderBatch {
        model: model.id.clone(),
        address: place.url,
    };
    let requests: Vec<Request> = asked.iter().map(|(_, request)| request.clone()).collect();
    for part in split(endpoint, &requests) {
        let runs: Vec<NewRun> = asked[part.clone()].iter().map(|(r, _)| r.clone()).collect();
        let Some(opened) = store.open_provider_batch(&new, &runs)? else {
            done.taken += part.len();
            continue;
        };
        let granted = opened.requests.iter().zip(&requests[part.clone()]);
        let items: Vec<Item> = granted
            .filter_map(|(granted, request)| {
                let (_, id) = granted.as_ref()?;
                Some(Item {
                    id: id.clone(),
                    request: request.clone(),
                })
            })
            .collect();
        done.taken += part.len() - items.len();
        send(&opened, &items, &batches, store).await?;
        done.handed += items.len();
        done.batches.push(opened.id);
    }
    Ok(done)
}

/// Sends one batch that the store knows of.
async fn send(
    opened: &ReadyBatch,
    items: &[Item],
    batches: &Batches,
    store: &Store,
) -> Result<(), RemoteError> {
    let mut most = Some(0.0);
    for (item, (run, _)) in items.iter().zip(opened.requests.iter().flatten()) {
        let usd = batches.at_most(&item.request);
        store.bound(*run, usd)?;
        most = most.zip(usd).map(|(sum, usd)| sum + usd);
    }
    let money = match batches.set_aside(most) {
        Ok(money) => money,
        Err(error) => return Err(not_sent(opened.id, error, store)?),
    };
    let prepared = match batches.prepare(&opened.tag, items).await {
        Ok(prepared) => prepared,
        Err(error) => return Err(not_sent(opened.id, error, store)?),
    };
    if !store.about_to_submit(opened.id)? {
        return Err(RemoteError::Refused(
            "another program gave up the batch during the upload; submit it again".into(),
        ));
    }
    match batches.create(&prepared).await {
        // Before anything else.
        Ok(id) => {
            store.submitted(opened.id, &id)?;
            money.spent();
            Ok(())
        }
        Err(error) if surely_not_created(&error) => Err(not_sent(opened.id, error, store)?),
        Err(error) => {
            money.spent();
            Err(RemoteError::Unknown {
                batch: opened.id,
                error,
            })
        }
    }
}

/// Records that a batch was not sent, so that its questions can be asked again.
fn not_sent(
    batch: ProviderBatchId,
    error: Error,
    store: &Store,
) -> Result<RemoteError, StoreError> {
    never_sent(batch, &error.to_string(), store)?;
    Ok(error.into())
}

fn never_sent(batch: ProviderBatchId, why: &str, store: &Store) -> Result<(), StoreError> {
    for handed in store.handed(batch)? {
        store.bound(handed.run, Some(0.0))?;
    }
    let rest = Ending {
        error: Some(format!("nothing was sent: {why}")),
        ..Ending::bare(RunState::Failed)
    };
    store.close_provider_batch(batch, ProviderBatchState::NotSent, Some(why), &rest)?;
    Ok(())
}

/// Looks at the provider for a batch whose id did not arrive; the id, if it is there.
async fn find(
    batch: &ProviderBatch,
    batches: &Batches,
    store: &Store,
) -> Result<Option<String>, RemoteError> {
    let ids: Vec<String> = store
        .handed(batch.id)?
        .into_iter()
        .map(|h| h.custom_id)
        .collect();
    // Two servers may give the same id.
    let known = store
        .provider_batches()?
        .into_iter()
        .filter(|other| other.address == batch.address);
    let others: Vec<String> = known.filter_map(|other| other.remote_id).collect();
    let since = Timestamp::from_millisecond(batch.submitted_ms).unwrap_or(Timestamp::UNIX_EPOCH);
    let mark = SubmissionMark {
        tag: &batch.tag,
        since,
        ids: &ids,
        others: &others,
    };
    match batches.look_up(mark).await? {
        Lookup::Batch(id) => {
            store.submitted(batch.id, &id)?;
            Ok(Some(id))
        }
        Lookup::Nothing
            if since.as_millisecond() + GRACE_MS < Timestamp::now().as_millisecond() =>
        {
            let why = "the program ended before the batch had reached the provider";
            never_sent(batch.id, why, store)?;
            Ok(None)
        }
        Lookup::Nothing | Lookup::Perhaps(_) => Ok(None),
    }
}
