//! Collects a batch's results from its provider into the store, each once, or abandons a batch that cannot be fetched.

use std::collections::{BTreeSet, HashMap};
use std::sync::Arc;

use jiff::Timestamp;
use jiff::tz::TimeZone;
use nearmiss_ask::llm::batch::{BatchState, Batches, Outcome, WholeAnswer};
use nearmiss_ask::llm::{Error, Message, Secrets};
use nearmiss_ask::prompts::estimate_tokens;
use nearmiss_store::{
    AnswerPiece, Consumed, Ending, ProviderBatch, ProviderBatchId, ProviderBatchState, Run, RunId,
    RunState, Store,
};

use super::{RemoteError, find};
use crate::evaluation::answer::{
    Answer, JudgeOutcome, MissingVerdict, finish_name, read, stopped_short, unless_cut, weighed,
};
use crate::evaluation::judges::ModelJudge;

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

/// Why a question has no answer whose batch the provider did not finish in time.
pub const EXPIRED: &str = "the batch expired before the provider answered; ask again";

/// The texts of a result and the end of its run.
pub struct FinishedRun {
    pub reasoning: String,
    pub text: String,
    pub ending: Ending,
}

impl FinishedRun {
    pub fn pieces(&self) -> Vec<AnswerPiece<'_>> {
        let pieces = [
            AnswerPiece::Reasoning(&self.reasoning),
            AnswerPiece::Answer(&self.text),
        ];
        let some = |piece: &AnswerPiece<'_>| match piece {
            AnswerPiece::Reasoning(text) | AnswerPiece::Answer(text) => !text.is_empty(),
        };
        pieces.into_iter().filter(some).collect()
    }
}

/// The end of a question's run with this outcome.
pub fn settled(run: Run, outcome: Outcome, model: &ModelJudge) -> FinishedRun {
    match outcome {
        Outcome::Answered(answered) => answer(run, *answered, model),
        Outcome::Failed(why) => bare(RunState::Failed, Some(&why)),
        Outcome::Expired => bare(RunState::Failed, Some(EXPIRED)),
        Outcome::Cancelled => bare(RunState::Cancelled, None),
    }
}

fn bare(state: RunState, error: Option<&str>) -> FinishedRun {
    FinishedRun {
        reasoning: String::new(),
        text: String::new(),
        ending: Ending {
            error: error.map(str::to_string),
            ..Ending::bare(state)
        },
    }
}

fn answer(run: Run, answered: WholeAnswer, model: &ModelJudge) -> FinishedRun {
    let task = run.question.task;
    let sent = tokens_sent(&run.question.messages);
    let asked = Timestamp::from_millisecond(run.created_ms).unwrap_or(Timestamp::UNIX_EPOCH);
    let returned = answered.model.as_deref();
    let (cost_usd, price_source) = match cost(&answered, asked, returned, model) {
        Some((usd, source)) => (Some(usd), Some(source)),
        None => (None, None),
    };
    let usage = answered.usage.unwrap_or_default();
    let mut answer = Answer {
        text: answered.text,
        reasoning: answered.reasoning,
        model_returned: answered.model,
        finish: Some(finish_name(&answered.finish)),
        consumed: Consumed {
            input_tokens: usage.input_tokens,
            output_tokens: usage.output_tokens,
            reasoning_tokens: usage.reasoning_tokens,
            cached_tokens: usage.cached_tokens,
            cost_usd,
            // Its time is the provider's queue, not the model's.
            first_chunk_ms: None,
            duration_ms: None,
        },
        price_source,
        judged: JudgeOutcome::Missing(MissingVerdict::Cancelled),
        ..Answer::from(run)
    };
    let secrets = Secrets::sent(&model.client, &model.endpoint);
    let read = read(task, &answer, stopped_short(&answered.finish)).without(&secrets);
    answer.judged = unless_cut(read, usage.input_tokens, sent);
    weighed(task, &answered.tokens, &mut answer.judged);
    let ending = answer.ending();
    FinishedRun {
        reasoning: answer.reasoning,
        text: answer.text,
        ending,
    }
}

/// Roughly how many tokens messages in words alone are; `None` of those with pictures.
fn tokens_sent(messages: &str) -> Option<usize> {
    let messages: Vec<Message> = serde_json::from_str(messages).ok()?;
    let in_words = messages.iter().all(|message| message.images.is_empty());
    let tokens = messages
        .iter()
        .map(|message| estimate_tokens(&message.content));
    in_words.then(|| tokens.sum())
}

/// Cost of an answer, US dollars, and its source.
fn cost(
    answered: &WholeAnswer,
    asked: Timestamp,
    returned: Option<&str>,
    model: &ModelJudge,
) -> Option<(f64, String)> {
    let usage = answered.usage.as_ref()?;
    if let Some(cost) = usage.cost {
        return Some((cost.usd, "stated by the server".into()));
    }
    let day = asked.to_zoned(TimeZone::UTC).date();
    let prices = &model.endpoint.prices;
    let pricing = prices.of_answer(&model.name, returned, day)?;
    let usd = pricing.batch_cost(usage, asked)?;
    let factor = pricing.batch_factor?;
    let origin = pricing
        .origin()
        .map(|o| format!(", {o}"))
        .unwrap_or_default();
    Some((
        usd,
        format!("tokens times {factor} of listed prices, as part of a batch{origin}"),
    ))
}

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
