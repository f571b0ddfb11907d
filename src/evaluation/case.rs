//! Running one case: ask, keep every piece before it is shown, read the verdict, keep the end.

use std::sync::Arc;
use std::time::Duration;

use futures_util::StreamExt;
use tokio::time::Instant;

use super::answer::{Answer, Judged, Missing};
use super::judges::{Judge, ModelJudge};
use super::keeper::Keeper;
use super::price_words::stated;
use super::question::Question;
use super::request::{most_usd, record, request};
use crate::judge;
use crate::llm::{self, Barrier, Chunk, Finish};
use crate::store::{Claim, Consumed, NewRun, Run, RunId, Store, StoreError};
use crate::verdict::{self, How, Parsed, Task};

/// What happens while a case runs.
#[derive(Debug, Clone, PartialEq)]
pub enum Event {
    /// The run has a number in the store.
    Kept(RunId),
    /// Another program, or another task of this one, is asking the same under this number; its answer is waited for.
    Awaiting(RunId),
    /// Something about the request that people should know.
    Note(String),
    /// The server begins to answer, as this model.
    Answering(Option<String>),
    /// A piece of the reasoning.
    Reasoning(String),
    /// A piece of the answer.
    Text(String),
    /// A try failed; the next one follows.
    Retrying {
        /// Number of the next try.
        attempt: u32,
        /// How long until then.
        wait: Duration,
        /// What went wrong.
        why: String,
    },
    /// It failed in a way in which every other question to the model would most likely fail.
    Barred(Barrier),
}

/// Which answer is wanted.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Wanted {
    /// Which of several answers to the same request, from 0.
    pub sample: u32,
    /// Ask in any case, even where the store has the answer.
    pub fresh: bool,
    /// The batch it is for.
    pub batch: Option<String>,
}

/// Asks `judge` the question, unless the store has a whole answer to the same request and sample: then that is the
/// answer, nothing is sent, and [`Answer::past`] says whence it is. `on_event` hears of everything that arrives,
/// after the store has it.
///
/// Dropping the future cancels the request and writes that down.
///
/// # Errors
/// The question is refused before anything is sent, and the store keeps no run of it. Or the store cannot keep what
/// arrives; nothing is asked of a model then, or no longer: an answer that cannot be kept is not paid for.
pub async fn run(
    question: &Question,
    judge: &Judge,
    store: Option<Arc<Store>>,
    wanted: &Wanted,
    mut on_event: impl FnMut(Event),
) -> Result<Answer, AskError> {
    let mut kept = None;
    match store {
        None => ready(question, judge).await?,
        Some(store) => {
            let run = record(question, judge, wanted).map_err(StoreError::from)?;
            // What is there needs neither key nor budget, and what cannot be asked leaves no run.
            let there = match wanted.fresh {
                true => None,
                false => store.answer_to(&run)?,
            };
            if let Some(found) = there {
                return Ok(replay(found, &mut on_event));
            }
            ready(question, judge).await?;
            match claim(&store, &run, wanted, &mut on_event).await? {
                Ok(run) => {
                    if let Judge::Model(model) = judge {
                        store.bound(run, most_usd(question, model))?;
                    }
                    on_event(Event::Kept(run));
                    kept = Some((store, run));
                }
                Err(found) => return Ok(replay(*found, &mut on_event)),
            }
        }
    }
    let place = kept.clone();
    let mut asking = Asking {
        answer: unanswered(question, judge, kept.as_ref().map(|(_, run)| *run)),
        keeper: Keeper::new(kept),
        started: Instant::now(),
    };
    match judge {
        Judge::Reference => asking.reference(question)?,
        Judge::Model(model) => asking.model(question, model, &mut on_event).await?,
    }
    asking.answer.consumed.duration_ms = Some(asking.elapsed());
    asking
        .keeper
        .finish(&asking.answer.ending(), &mut on_event)?;
    if let (Judged::Missing(Missing::NotSent(_)), Some((store, run))) =
        (&asking.answer.judged, place)
    {
        store.bound(run, Some(0.0))?;
    }
    Ok(asking.answer)
}

/// The whole answer that the store has to a question, as [`run`] would find it; nothing is asked.
///
/// # Errors
/// The store cannot be read.
pub fn stored(
    question: &Question,
    judge: &Judge,
    store: &Store,
    wanted: &Wanted,
) -> Result<Option<Answer>, StoreError> {
    let run = record(question, judge, wanted).map_err(StoreError::from)?;
    Ok(store.answer_to(&run)?.map(Answer::from))
}

/// Whether a question can be asked as things stand; nothing is sent. A command that prints the key is run.
///
/// # Errors
/// Why it would be refused.
pub async fn can_ask(question: &Question, judge: &Judge) -> Result<(), AskError> {
    ready(question, judge).await
}

/// Why nothing was asked, or an answer is not kept.
#[derive(Debug, thiserror::Error)]
pub enum AskError {
    /// It can be known without asking that there will be no answer.
    #[error("nothing was sent: {0}")]
    Refused(String),
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
        Judge::Reference => Err(AskError::Refused(
            "the built-in judge answers collision and safety only; choose a model".into(),
        )),
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

/// How often it is looked whether somebody else's answer is there.
const LOOK: Duration = Duration::from_millis(100);

/// A number to ask under, or the answer that is there; waits for whoever is asking the same.
async fn claim(
    store: &Store,
    run: &NewRun,
    wanted: &Wanted,
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
    for (text, event) in [
        (&run.reasoning, Event::Reasoning as fn(String) -> Event),
        (&run.answer, Event::Text),
    ] {
        if !text.is_empty() {
            on_event(event(text.clone()));
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
        how: question.how(),
        model_returned: None,
        judged: Judged::Missing(Missing::Cancelled),
        text: String::new(),
        reasoning: String::new(),
        consumed: Consumed::default(),
        price_source: None,
        finish: None,
    }
}

/// A question on its way.
struct Asking {
    keeper: Keeper,
    started: Instant,
    answer: Answer,
}

impl Asking {
    fn elapsed(&self) -> u64 {
        u64::try_from(self.started.elapsed().as_millis()).unwrap_or(u64::MAX)
    }

    /// Takes a piece; it is shown when it is kept.
    fn piece(&mut self, event: Event) {
        match &event {
            Event::Reasoning(text) => self.answer.reasoning.push_str(text),
            Event::Text(text) => self.answer.text.push_str(text),
            _ => {}
        }
        if self.answer.consumed.first_chunk_ms.is_none() {
            self.answer.consumed.first_chunk_ms = Some(self.elapsed());
        }
        self.keeper.take(event);
    }

    fn reference(&mut self, question: &Question) -> Result<(), StoreError> {
        let case = &question.case;
        let judgement = judge::judge_under(&case.scene, case.task, &case.window, &case.thresholds);
        let text = serde_json::to_string(&judgement.verdict)?;
        self.piece(Event::Reasoning(judgement.reasoning));
        self.piece(Event::Text(text));
        self.answer.judged = Judged::Verdict(Parsed {
            verdict: judgement.verdict,
            how: How::Strict,
        });
        Ok(())
    }

    async fn model(
        &mut self,
        question: &Question,
        model: &ModelJudge,
        on_event: &mut impl FnMut(Event),
    ) -> Result<(), StoreError> {
        let task = question.case.task;
        let request = request(question, model);
        let mut chunks = llm::stream(&model.client, model.endpoint.clone(), request);
        let (mut failure, mut retried, mut begun) = (None, false, false);
        loop {
            let due = tokio::time::sleep_until(self.keeper.due());
            let chunk = tokio::select! {
                // What is there is taken before it is written, so that much is written at once.
                biased;
                chunk = chunks.next() => chunk,
                () = due => {
                    self.keeper.tend(on_event)?;
                    continue;
                }
            };
            let Some(chunk) = chunk else { break };
            match chunk {
                Ok(Chunk::Note(note)) => on_event(Event::Note(note)),
                Ok(Chunk::Started { model }) => {
                    begun = true;
                    self.answer.model_returned.clone_from(&model);
                    on_event(Event::Answering(model));
                }
                Ok(Chunk::Reasoning(text)) => self.piece(Event::Reasoning(text)),
                Ok(Chunk::Text(text)) => self.piece(Event::Text(text)),
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
                Ok(Chunk::Retrying { attempt, wait, why }) => {
                    retried = true;
                    on_event(Event::Retrying { attempt, wait, why });
                }
                Ok(Chunk::Finished(finish)) => {
                    failure = stopped_short(&finish);
                    self.answer.finish = Some(word(&finish));
                    // Nothing follows, and the end is written at once, together with what waits.
                    break;
                }
                Err(error) => {
                    if let Some(barrier) = error.barrier().filter(|_| !begun) {
                        on_event(Event::Barred(barrier));
                    }
                    failure = Some(match error.before_sending() && !retried {
                        true => Missing::NotSent(error.to_string()),
                        false => Missing::NoAnswer(error.to_string()),
                    });
                }
            }
            self.keeper.tend(on_event)?;
        }
        self.answer.judged = read(task, &self.answer, failure);
        Ok(())
    }
}

/// What an answer says whose text is whole, or stopped short, or is missing.
pub(super) fn read(task: Task, answer: &Answer, failure: Option<Missing>) -> Judged {
    // A model that puts everything into its reasoning has still answered.
    let whole = if answer.text.trim().is_empty() {
        &answer.reasoning
    } else {
        &answer.text
    };
    match failure {
        Some(missing @ (Missing::NoAnswer(_) | Missing::NotSent(_))) => Judged::Missing(missing),
        stopped => match (verdict::read(task, whole), stopped) {
            (Ok(reading), _) => Judged::from(reading),
            (Err(_), Some(stopped)) => Judged::Missing(stopped),
            (Err(why), None) => Judged::Missing(Missing::NotInAnswer(why.to_string())),
        },
    }
}

/// Why an answer that ended this way may hold no verdict.
pub(super) fn stopped_short(finish: &Finish) -> Option<Missing> {
    let why = match finish {
        Finish::Length => "the answer ran into the token limit; raise max_tokens".to_string(),
        Finish::ContentFilter => "the server's content filter stopped the answer".to_string(),
        Finish::Blocked(why) => format!("the server's filter blocked the question ({why})"),
        Finish::Blank => {
            "the answer is blank, as some servers make one that is not the JSON asked for; ask again".into()
        }
        Finish::Refusal(text) if text.is_empty() => "the model declined".into(),
        Finish::Refusal(text) => format!("the model declined: {text}"),
        Finish::Stop | Finish::Other(_) => return None,
    };
    Some(Missing::NotInAnswer(why))
}

pub(super) fn word(finish: &Finish) -> String {
    match finish {
        Finish::Stop => "stop".into(),
        Finish::Length => "length".into(),
        Finish::ContentFilter => "content_filter".into(),
        Finish::Blocked(_) => "blocked".into(),
        Finish::Blank => "blank".into(),
        Finish::Refusal(_) => "refusal".into(),
        Finish::Other(word) => word.clone(),
    }
}
