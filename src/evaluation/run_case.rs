//! Runs one case: ask, store every chunk before it is shown, parse the verdict, store the end.

use std::sync::Arc;
use std::time::Duration;

use futures_util::StreamExt;
use tokio::time::Instant;

use super::answer::{Answer, JudgeOutcome, MissingVerdict, times};
use super::answer_outcome::{read, stopped_short, too_long, weighed, word};
use super::judges::{Judge, ModelJudge};
use super::price_words::stated;
use super::question::Question;
use super::recorded_answer::not_recorded;
use super::request::{most_usd, record, request};
use super::stream_recorder::StreamRecorder;
use crate::llm::{self, Chunk, Finish, ProviderOutage, Secrets};
use crate::store::{Claim, Consumed, NewRun, Run, RunId, Store, StoreError};
use crate::verdict::{ParseQuality, Parsed, Task};

/// Events while a case runs.
#[derive(Debug, Clone, PartialEq)]
pub enum Event {
    /// The run has a number in the store.
    Kept(RunId),
    /// Another program, or another task of this one, is asking the same under this number; its answer is waited for.
    Awaiting(RunId),
    /// A chunk of the answer or its metadata arrived; [`Chunk::Usage`], [`Chunk::LogProbabilities`] and
    /// [`Chunk::Finished`] go into the [`Answer`] instead.
    Chunk(Chunk),
    /// The answer is not in the store; why, and where it is instead.
    NotStored(String),
    /// It failed in a way in which every other question to the model would most likely fail.
    Barred(ProviderOutage),
}

/// Options that select an answer.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct RunOptions {
    /// Which of several answers to the same request, from 0.
    pub sample: u32,
    /// Ask in any case, even where the store has the answer.
    pub fresh: bool,
    /// The batch it is for.
    pub batch: Option<String>,
}

/// Asks `judge` the question, unless the store has a complete answer to the same request and sample: then that is the
/// answer, nothing is sent, and [`Answer::past`] is its origin. `on_event` receives everything that arrives, after it
/// is stored.
///
/// Dropping the future cancels the request and records that.
///
/// # Errors
/// The question is refused before anything is sent, and the store keeps no run of it. Or the store cannot be written
/// beforehand; nothing is asked of a model then. Where it fails later, the answer comes all the same, after an
/// [`Event::NotStored`].
pub async fn run(
    question: &Question,
    judge: &Judge,
    store: Option<Arc<Store>>,
    wanted: &RunOptions,
    mut on_event: impl FnMut(Event),
) -> Result<Answer, AskError> {
    let mut kept = None;
    let mut recorded = None;
    match store {
        None => ready(question, judge).await?,
        Some(store) => {
            let run = record(question, judge, wanted).map_err(StoreError::from)?;
            // A stored answer needs neither key nor budget, and an unaskable question leaves no run.
            let there = match judge {
                _ if wanted.fresh => None,
                // Nothing is sent, so there is no request to know its answer by; each batch keeps runs of its own.
                Judge::Reference if wanted.batch.is_none() => {
                    let (reasoning, text) = reference_texts(question)?;
                    store.same_answer(&run, (&reasoning, &text))?
                }
                Judge::Recorded(_) => store.recorded_answer(&run)?,
                _ => store.answer_to(&run)?,
            };
            if let Some(found) = there {
                return Ok(replay(found, &mut on_event));
            }
            ready(question, judge).await?;
            match claim(&store, &run, wanted, &mut on_event).await? {
                Ok(id) => {
                    if let Judge::Model(model) = judge {
                        store.bound(id, most_usd(question, model))?;
                    }
                    on_event(Event::Kept(id));
                    kept = Some((store, id));
                    recorded = Some(run);
                }
                Err(found) => return Ok(replay(*found, &mut on_event)),
            }
        }
    }
    let place = kept.clone();
    let mut asking = Asking {
        answer: unanswered(question, judge, kept.as_ref().map(|(_, run)| *run)),
        recorder: StreamRecorder::new(kept),
        started: Instant::now(),
    };
    let over_budget = match judge {
        Judge::Reference => asking.reference(question).map(|()| None)?,
        Judge::Model(model) => asking.model(question, model, &mut on_event).await,
        Judge::Recorded(_) => return Err(AskError::NotRecorded(not_recorded(question))),
    };
    asking.answer.consumed.duration_ms = Some(asking.elapsed());
    let mut ending = asking.answer.ending();
    if asking.answer.arrived() {
        ending.claims = asking.answer.claims(&question.case.scene);
    }
    let texts = (
        asking.answer.reasoning.as_str(),
        asking.answer.text.as_str(),
    );
    if let Err(why) = asking.recorder.finish(&ending, texts, &mut on_event) {
        let (Some((store, id)), Some(run)) = (&place, &recorded) else {
            return Err(why.into());
        };
        if texts == ("", "") {
            // There is nothing to lose.
            return Err(why.into());
        }
        let unstored = store.set_aside(*id, run, texts, &ending, why);
        on_event(Event::NotStored(unstored.to_string()));
        asking.answer.run = None;
        return Ok(asking.answer);
    }
    if let (JudgeOutcome::Missing(MissingVerdict::NotSent(_)), Some((store, run))) =
        (&asking.answer.judged, place)
    {
        store.bound(run, Some(0.0))?;
        if let Some(why) = over_budget {
            // Others that were asked meanwhile took the money. It is no run, as where it was known before.
            store.delete(run, true)?;
            return Err(AskError::OverBudget(why));
        }
    }
    Ok(asking.answer)
}

/// Whether a question can be asked as things stand; nothing is sent. A command that prints the key is run.
///
/// # Errors
/// Why it would be refused.
pub async fn can_ask(question: &Question, judge: &Judge) -> Result<(), AskError> {
    ready(question, judge).await
}

/// Why nothing was asked, or why an answer is not stored.
#[derive(Debug, thiserror::Error)]
pub enum AskError {
    /// It can be known without asking that there will be no answer.
    #[error("nothing was sent: {0}")]
    Refused(String),
    /// The answer is to be a recorded one, and there is none.
    #[error("{0}")]
    NotRecorded(String),
    /// The same, because of money: it may cost more than the budget allows, or what it may cost is not known.
    #[error("nothing was sent: {0}")]
    OverBudget(String),
    /// The store cannot keep it.
    #[error(transparent)]
    Store(#[from] StoreError),
}

/// Whether the judge can be asked as things stand.
async fn ready(question: &Question, judge: &Judge) -> Result<(), AskError> {
    match judge {
        Judge::Reference if Task::VERDICTS.contains(&question.case.task) => Ok(()),
        Judge::Reference => Err(AskError::Refused(format!(
            "the built-in judge answers {} only; choose a model",
            Task::names(&Task::VERDICTS)
        ))),
        // Each question has its answer or not.
        Judge::Recorded(_) => Ok(()),
        Judge::Model(model) => {
            let request = request(question, model);
            let checked = llm::check(&model.client, &model.endpoint, &request).await;
            checked.map_err(|why| match why {
                llm::Error::Budget { .. } => AskError::OverBudget(why.to_string()),
                _ => AskError::Refused(why.to_string()),
            })
        }
    }
}

/// How often to look for the answer of a concurrent run.
const LOOK: Duration = Duration::from_millis(100);

/// A run id to ask under, or the stored answer; waits while another run asks the same question.
async fn claim(
    store: &Store,
    run: &NewRun,
    wanted: &RunOptions,
    on_event: &mut impl FnMut(Event),
) -> Result<Result<RunId, Box<Run>>, StoreError> {
    let mut awaited = None;
    loop {
        match store.claim(run, wanted.fresh)? {
            Claim::Granted(run) => return Ok(Ok(run)),
            Claim::Stored(found) => return Ok(Err(found)),
            Claim::Taken(run) => {
                if awaited.replace(run) != Some(run) {
                    on_event(Event::Awaiting(run));
                }
                tokio::time::sleep(LOOK).await;
            }
        }
    }
}

/// The answer of a run that is in the store.
fn replay(run: Run, on_event: &mut impl FnMut(Event)) -> Answer {
    on_event(Event::Kept(run.id));
    for (text, piece) in [
        (&run.reasoning, Chunk::Reasoning as fn(String) -> Chunk),
        (&run.answer, Chunk::Text),
    ] {
        if !text.is_empty() {
            on_event(Event::Chunk(piece(text.clone())));
        }
    }
    Answer::from(run)
}

fn unanswered(question: &Question, judge: &Judge, run: Option<RunId>) -> Answer {
    let case = &question.case;
    Answer {
        run,
        past: None,
        model: judge.id().to_string(),
        window: Some((case.window.first(), case.window.last())),
        times: times(judge.id(), &question.description),
        how: question.how(),
        model_returned: None,
        judged: JudgeOutcome::Missing(MissingVerdict::Cancelled),
        text: String::new(),
        reasoning: String::new(),
        consumed: Consumed::default(),
        price_source: None,
        finish: None,
    }
}

/// Reasoning and answer of the built-in judge, as the store has them.
fn reference_texts(question: &Question) -> Result<(String, String), StoreError> {
    let judgement = question.case.judgement();
    let text = serde_json::to_string(&judgement.verdict)?;
    Ok((judgement.reasoning, text))
}

/// A question on its way.
struct Asking {
    recorder: StreamRecorder,
    started: Instant,
    answer: Answer,
}

impl Asking {
    fn elapsed(&self) -> u64 {
        u64::try_from(self.started.elapsed().as_millis()).unwrap_or(u64::MAX)
    }

    /// Takes a piece; it is shown when it is kept.
    fn piece(&mut self, piece: Chunk) {
        match &piece {
            Chunk::Reasoning(text) => self.answer.reasoning.push_str(text),
            Chunk::Text(text) => self.answer.text.push_str(text),
            _ => {}
        }
        if self.answer.consumed.first_chunk_ms.is_none() {
            self.answer.consumed.first_chunk_ms = Some(self.elapsed());
        }
        self.recorder.take(piece);
    }

    fn reference(&mut self, question: &Question) -> Result<(), StoreError> {
        let judgement = question.case.judgement();
        let text = serde_json::to_string(&judgement.verdict)?;
        self.piece(Chunk::Reasoning(judgement.reasoning));
        self.piece(Chunk::Text(text));
        self.answer.judged = JudgeOutcome::Verdict(Parsed {
            verdict: judgement.verdict,
            how: ParseQuality::Strict,
        });
        Ok(())
    }

    /// Why the budget allowed nothing to be sent, where that is so.
    async fn model(
        &mut self,
        question: &Question,
        model: &ModelJudge,
        on_event: &mut impl FnMut(Event),
    ) -> Option<String> {
        let task = question.case.task;
        let request = request(question, model);
        let weigh = llm::gives_log_probabilities(&model.endpoint, &request);
        let mut tokens = Vec::new();
        let mut chunks = llm::stream(&model.client, model.endpoint.clone(), request);
        let (mut failure, mut retried, mut begun) = (None, false, false);
        let mut over_budget = None;
        loop {
            let due = tokio::time::sleep_until(self.recorder.due());
            let chunk = tokio::select! {
                // What is there is taken before it is written, so that much is written at once.
                biased;
                chunk = chunks.next() => chunk,
                () = due => {
                    self.recorder.flush_due(on_event);
                    continue;
                }
            };
            let Some(chunk) = chunk else { break };
            match chunk {
                Ok(note @ Chunk::Note(_)) => on_event(Event::Chunk(note)),
                Ok(Chunk::Started { model }) => {
                    begun = true;
                    self.answer.model_returned.clone_from(&model);
                    on_event(Event::Chunk(Chunk::Started { model }));
                }
                Ok(piece @ (Chunk::Reasoning(_) | Chunk::Text(_))) => self.piece(piece),
                Ok(Chunk::LogProbabilities(given)) => tokens = given,
                Ok(Chunk::Usage(usage)) => {
                    let consumed = &mut self.answer.consumed;
                    consumed.input_tokens = usage.input_tokens;
                    consumed.output_tokens = usage.output_tokens;
                    consumed.reasoning_tokens = usage.reasoning_tokens;
                    consumed.cached_tokens = usage.cached_tokens;
                    consumed.cost_usd = usage.cost.map(|cost| cost.usd);
                    let returned = self.answer.model_returned.as_deref();
                    let source = usage.cost.map(|cost| stated(cost.source, model, returned));
                    self.answer.price_source = source;
                }
                Ok(retrying @ Chunk::Retrying { .. }) => {
                    retried = true;
                    on_event(Event::Chunk(retrying));
                }
                Ok(Chunk::Finished(finish)) => {
                    failure = stopped_short(&finish);
                    if finish == Finish::TooLong {
                        on_event(Event::Chunk(Chunk::Note(too_long())));
                    }
                    self.answer.finish = Some(word(&finish));
                    // Nothing follows, and the end is written at once, together with what waits.
                    break;
                }
                Err(error) => {
                    if let Some(barrier) = error.barrier().filter(|_| !begun) {
                        on_event(Event::Barred(barrier));
                    }
                    if matches!(error, llm::Error::Budget { .. }) && !retried && !begun {
                        over_budget = Some(error.to_string());
                    }
                    failure = Some(match error.before_sending() && !retried {
                        true => MissingVerdict::NotSent(error.to_string()),
                        false => MissingVerdict::NoAnswer(error.to_string()),
                    });
                }
            }
            self.recorder.flush_due(on_event);
        }
        let secrets = Secrets::sent(&model.client, &model.endpoint);
        self.answer.judged = read(task, &self.answer, failure).without(&secrets);
        if weigh && !weighed(task, &tokens, &mut self.answer.judged) {
            let note = match tokens.is_empty() {
                true => "the server sent no log probabilities",
                false => "the log probabilities do not show the token of the verdict",
            };
            on_event(Event::Chunk(Chunk::Note(note.into())));
        }
        over_budget
    }
}
