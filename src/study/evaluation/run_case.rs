//! Runs one case: asks, stores every chunk before it is shown, parses the verdict, stores the end in any case.

use std::sync::Arc;
use std::time::Duration;

use nearmiss_ask::llm::{self, Chunk, ProviderOutage, ToolRound};
use nearmiss_scene::verdict::{ParseQuality, Parsed, Task};
use nearmiss_store::{
    AnswerPiece, Claim, Consumed, Ending, NewRun, RENEWAL, Run, RunId, RunState, Store, StoreError,
};
use tokio::time::Instant;

use super::answer::{Answer, JudgeOutcome, MissingVerdict, times};
use super::ask_model::{most_usd, record, request};
use super::judges::{Judge, not_recorded};
use super::question::Question;
use super::tool_rounds;

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
    /// The model called tools, and they answered.
    Tools(Box<ToolRound>),
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
    let mut continued = Vec::new();
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
                    if let Judge::Model(model) = judge
                        && model.parameters.tools.is_some()
                        && !wanted.fresh
                    {
                        continued = continued_rounds(&store, &run, id, &mut on_event)?;
                    }
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
        store: place.clone(),
        turn: [0, 0],
    };
    asking.answer.tool_rounds = continued;
    let over_budget = match judge {
        Judge::Reference => asking.reference(question).map(|()| None)?,
        Judge::Model(model) => asking.model(question, model, &mut on_event).await,
        Judge::Recorded(_) => return Err(AskError::NotRecorded(not_recorded(question))),
    };
    asking.answer.consumed.duration_ms = Some(asking.elapsed());
    let scene = &question.case.scene;
    asking.answer.note_unknown(&scene.scenario);
    let mut ending = asking.answer.ending();
    if asking.answer.arrived() {
        ending.claims = asking.answer.claims(scene, &question.messages());
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
        let rounds = &asking.answer.tool_rounds;
        let rounds = if rounds.is_empty() {
            None
        } else {
            Some(serde_json::to_string(rounds).map_err(StoreError::from)?)
        };
        let unstored = store.set_aside(*id, run, texts, &ending, rounds, why);
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
    for round in tool_rounds::stored(run.tool_rounds.as_deref()) {
        on_event(Event::Tools(Box::new(round)));
    }
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
        how: question.label(judge.calls_tools()),
        model_returned: None,
        judged: JudgeOutcome::Missing(MissingVerdict::Cancelled),
        text: String::new(),
        reasoning: String::new(),
        tool_rounds: Vec::new(),
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

/// The rounds of tool calls of an earlier run of the same question that broke off: they are paid, and the question
/// goes on after them.
fn continued_rounds(
    store: &Store,
    run: &NewRun,
    id: RunId,
    on_event: &mut impl FnMut(Event),
) -> Result<Vec<ToolRound>, StoreError> {
    let Some((earlier, json)) = store.unfinished_rounds(run, id)? else {
        return Ok(Vec::new());
    };
    // They are paid: unreadable ones must not be asked again without a word.
    let rounds: Vec<ToolRound> = serde_json::from_str(&json)?;
    if !rounds.is_empty() {
        store.keep_rounds(id, &json)?;
        on_event(Event::Chunk(Chunk::Note(format!(
            "continuing after {} of tool calls of run {earlier}; they are not asked again",
            match rounds.len() {
                1 => "1 round".to_string(),
                all => format!("{all} rounds"),
            }
        ))));
        for round in &rounds {
            on_event(Event::Tools(Box::new(round.clone())));
        }
    }
    Ok(rounds)
}

/// A question on its way.
pub(super) struct Asking {
    pub(super) recorder: StreamRecorder,
    started: Instant,
    pub(super) answer: Answer,
    /// Where the rounds of tool calls are kept.
    pub(super) store: Option<(Arc<Store>, RunId)>,
    /// Where in text and reasoning the last turn begins: turns before it end in calls.
    pub(super) turn: [usize; 2],
}

impl Asking {
    fn elapsed(&self) -> u64 {
        u64::try_from(self.started.elapsed().as_millis()).unwrap_or(u64::MAX)
    }

    /// Takes a piece; it is shown when it is kept.
    pub(super) fn piece(&mut self, piece: Chunk) {
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
}

/// The longest that a piece waits for others before all are written, and shown.
const INTERVAL: Duration = Duration::from_millis(50);

/// Bytes that are written at once, however short the wait.
const BATCH: usize = 4096;

/// Stores the chunks of one answer, and releases them for display once stored.
///
/// A lone chunk is written at once; of chunks in quick succession, those of [`INTERVAL`] are written in one
/// transaction. Dropped before its end, the run is recorded as cancelled.
///
/// If the store fails, the answer is already paid for: it is still received and shown, and its end is written with the
/// whole text if the store is writable again by then.
pub struct StreamRecorder {
    kept: Option<(Arc<Store>, RunId)>,
    waiting: Vec<Chunk>,
    bytes: usize,
    flushed: Option<Instant>,
    renewed: Instant,
    /// Why the store does not have all pieces so far.
    failed: Option<StoreError>,
}

impl StreamRecorder {
    /// For a run that was granted, or one that is not kept.
    pub fn new(kept: Option<(Arc<Store>, RunId)>) -> Self {
        Self {
            kept,
            waiting: Vec::new(),
            bytes: 0,
            flushed: None,
            renewed: Instant::now(),
            failed: None,
        }
    }

    /// Takes a piece, a [`Chunk::Reasoning`] or [`Chunk::Text`].
    pub fn take(&mut self, piece: Chunk) {
        if let Chunk::Reasoning(text) | Chunk::Text(text) = &piece {
            self.bytes += text.len();
        }
        self.waiting.push(piece);
    }

    /// When [`StreamRecorder::flush_due`] is due.
    pub fn due(&self) -> Instant {
        let renewal = self.renewed + RENEWAL;
        match self.flushed {
            _ if self.waiting.is_empty() => renewal,
            Some(flushed) if self.bytes < BATCH => renewal.min(flushed + INTERVAL),
            _ => Instant::now(),
        }
    }

    /// Writes the waiting pieces if they are due, then shows them; renews the claim if that is due.
    pub fn flush_due(&mut self, on_event: &mut impl FnMut(Event)) {
        if self.due() > Instant::now() {
            return;
        }
        let written = match (&self.kept, &self.failed) {
            (Some((store, run)), None) if self.waiting.is_empty() => store.renew(*run),
            (Some((store, run)), None) => store.append(*run, &pieces(&joined(&self.waiting))),
            // Each try may wait for a lock; the next one is the end.
            _ => Ok(()),
        };
        self.failed = self.failed.take().or(written.err());
        self.renewed = Instant::now();
        if !self.waiting.is_empty() {
            self.waiting
                .drain(..)
                .map(Event::Chunk)
                .for_each(&mut *on_event);
            self.bytes = 0;
            self.flushed = Some(Instant::now());
        }
    }

    /// Writes down the waiting pieces and how it ended, in one transaction, then shows the pieces. `whole` are
    /// reasoning and text, which are written anew where pieces of them are missing.
    pub fn finish(
        mut self,
        ending: &Ending,
        (reasoning, text): (&str, &str),
        on_event: &mut impl FnMut(Event),
    ) -> Result<(), StoreError> {
        let kept = match (self.kept.take(), self.failed.take()) {
            (None, _) => Ok(()),
            (Some((store, run)), None) => {
                store.conclude(run, &pieces(&joined(&self.waiting)), ending)
            }
            (Some((store, run)), Some(first)) => store
                .conclude_whole(run, reasoning, text, ending)
                .map_err(|_| first),
        };
        self.waiting.drain(..).map(Event::Chunk).for_each(on_event);
        kept
    }
}

fn pieces(joined: &[(bool, String)]) -> Vec<AnswerPiece<'_>> {
    joined
        .iter()
        .map(|(reasoning, text)| {
            if *reasoning {
                AnswerPiece::Reasoning(text)
            } else {
                AnswerPiece::Answer(text)
            }
        })
        .collect()
}

/// The texts, those that follow each other and are of one kind put together.
fn joined(chunks: &[Chunk]) -> Vec<(bool, String)> {
    let mut joined: Vec<(bool, String)> = Vec::new();
    for chunk in chunks {
        let (reasoning, text) = match chunk {
            Chunk::Reasoning(text) => (true, text),
            Chunk::Text(text) => (false, text),
            _ => continue,
        };
        match joined.last_mut() {
            Some((kind, all)) if *kind == reasoning => all.push_str(text),
            _ => joined.push((reasoning, text.clone())),
        }
    }
    joined
}

impl Drop for StreamRecorder {
    fn drop(&mut self) {
        if let Some((store, run)) = self.kept.take() {
            // An error has no receiver here.
            let joined = joined(&self.waiting);
            let _ = store.conclude(run, &pieces(&joined), &Ending::bare(RunState::Cancelled));
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use nearmiss_scene::verdict::Task;
    use nearmiss_store::{Claim, NewRun};

    #[test]
    fn the_last_piece_is_shown_when_the_answer_is_kept_as_whole() {
        let store = Arc::new(Store::in_memory().unwrap());
        let text = |s: &str| s.to_string();
        let question = NewRun {
            sample: 0,
            batch: None,
            scenario: text("ZAM_A-1"),
            scenario_hash: None,
            ego: text("1"),
            task: Task::Collision,
            frame: text("ego"),
            techniques: text("base"),
            window: None,
            model: text("local/x"),
            provider: text("local"),
            dialect: None,
            endpoint: text("local"),
            address: None,
            template: text("t.md"),
            template_version: None,
            template_hash: text("th"),
            messages: text("[]"),
            parameters: text("{}"),
            answer_schema: None,
            images: Vec::new(),
        };
        let Claim::Granted(run) = store.claim(&question, true).unwrap() else {
            panic!("no other program asks");
        };
        let mut recorder = StreamRecorder::new(Some((store.clone(), run)));
        recorder.take(Chunk::Reasoning("because".into()));
        recorder.take(Chunk::Text("yes".into()));
        let mut shown = Vec::new();
        let ending = Ending::bare(RunState::Answered);
        recorder
            .finish(&ending, ("because", "yes"), &mut |event| {
                let kept = store.run(run).unwrap().unwrap();
                shown.push((event, kept.ending.state, kept.answer));
            })
            .unwrap();
        let whole = |event| (event, RunState::Answered, "yes".to_string());
        let pieces = [
            Event::Chunk(Chunk::Reasoning("because".into())),
            Event::Chunk(Chunk::Text("yes".into())),
        ];
        assert_eq!(shown, pieces.map(whole));
    }
}
