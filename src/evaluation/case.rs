//! Running one case: ask, keep every piece before it is shown, read the verdict, keep the end.

use std::sync::Arc;
use std::time::{Duration, Instant};

use futures_util::StreamExt;

use super::answer::{Answer, Judged, Missing};
use super::judges::{Judge, ModelJudge};
use super::question::Question;
use crate::judge;
use crate::llm::{self, Chunk, Finish, Parameters, Request, Schema};
use crate::store::{Consumed, Ending, NewRun, Piece, RunId, RunState, Store, StoreError};
use crate::verdict::{self, How, Parsed, Task};

/// What happens while a case runs.
#[derive(Debug, Clone, PartialEq)]
pub enum Event {
    /// The run has a number in the store.
    Kept(RunId),
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
}

/// Asks `judge` the question; `on_event` hears of everything that arrives, after the store has it.
///
/// Dropping the future cancels the request and writes that down.
///
/// # Errors
/// The store cannot keep what arrives. Nothing is asked of a model then, or no longer: an answer that
/// cannot be kept is not paid for.
pub async fn run(
    question: &Question,
    judge: &Judge,
    store: Option<Arc<Store>>,
    mut on_event: impl FnMut(Event),
) -> Result<Answer, StoreError> {
    let keeper = match store {
        Some(store) => Some(Keeper::begin(store, &record(question, judge))?),
        None => None,
    };
    let mut asking = Asking {
        keeper,
        started: Instant::now(),
        answer: Answer {
            run: None,
            model: judge.id().to_string(),
            window: (question.case.window.first(), question.case.window.last()),
            how: format!(
                "{} · {}",
                question.case.frame.name(),
                question.case.techniques
            ),
            model_returned: None,
            judged: Judged::Missing(Missing::Cancelled),
            text: String::new(),
            reasoning: String::new(),
            consumed: Consumed::default(),
            finish: None,
        },
    };
    if let Some(keeper) = &asking.keeper {
        asking.answer.run = Some(keeper.run);
        on_event(Event::Kept(keeper.run));
    }
    match judge {
        Judge::Reference => asking.reference(question, &mut on_event)?,
        Judge::Model(model) => asking.model(question, model, &mut on_event).await?,
    }
    let elapsed = asking.elapsed();
    asking.answer.consumed.duration_ms = Some(elapsed);
    if let Some(keeper) = asking.keeper.take() {
        keeper.finish(&asking.answer.ending())?;
    }
    Ok(asking.answer)
}

/// A question on its way.
struct Asking {
    keeper: Option<Keeper>,
    started: Instant,
    answer: Answer,
}

impl Asking {
    fn elapsed(&self) -> u64 {
        u64::try_from(self.started.elapsed().as_millis()).unwrap_or(u64::MAX)
    }

    /// Keeps a piece, then shows it.
    fn piece(&mut self, event: Event, on_event: &mut impl FnMut(Event)) -> Result<(), StoreError> {
        let (piece, into) = match &event {
            Event::Reasoning(text) => (Piece::Reasoning(text), &mut self.answer.reasoning),
            Event::Text(text) => (Piece::Answer(text), &mut self.answer.text),
            _ => return Ok(()),
        };
        if let Some(keeper) = &self.keeper {
            keeper.store.append(keeper.run, piece)?;
        }
        match piece {
            Piece::Reasoning(text) | Piece::Answer(text) => into.push_str(text),
        }
        let first = self.answer.consumed.first_chunk_ms.is_none();
        if first {
            self.answer.consumed.first_chunk_ms = Some(self.elapsed());
        }
        on_event(event);
        Ok(())
    }

    fn reference(
        &mut self,
        question: &Question,
        on_event: &mut impl FnMut(Event),
    ) -> Result<(), StoreError> {
        let case = &question.case;
        if !Task::VERDICTS.contains(&case.task) {
            let why = "the built-in judge answers collision and safety only; choose a model";
            self.answer.judged = Judged::Missing(Missing::NoAnswer(why.into()));
            return Ok(());
        }
        let judgement = judge::judge_under(&case.scene, case.task, &case.window, &case.thresholds);
        self.piece(Event::Reasoning(judgement.reasoning), on_event)?;
        let text = serde_json::to_string(&judgement.verdict)?;
        self.piece(Event::Text(text), on_event)?;
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
        let request = Request {
            model: model.name.clone(),
            messages: question.messages(),
            parameters: parameters(question, model),
            schema: Some(Schema {
                name: format!("{}_verdict", task.name()),
                schema: verdict::schema(task),
            }),
        };
        let mut chunks = llm::stream(&model.client, model.endpoint.clone(), request);
        let mut failure = None;
        while let Some(chunk) = chunks.next().await {
            match chunk {
                Ok(Chunk::Started { model }) => {
                    self.answer.model_returned.clone_from(&model);
                    on_event(Event::Answering(model));
                }
                Ok(Chunk::Reasoning(text)) => self.piece(Event::Reasoning(text), on_event)?,
                Ok(Chunk::Text(text)) => self.piece(Event::Text(text), on_event)?,
                Ok(Chunk::Usage(usage)) => {
                    let consumed = &mut self.answer.consumed;
                    consumed.input_tokens = usage.input_tokens;
                    consumed.output_tokens = usage.output_tokens;
                    consumed.reasoning_tokens = usage.reasoning_tokens;
                    consumed.cached_tokens = usage.cached_tokens;
                    consumed.cost_usd = usage.cost;
                }
                Ok(Chunk::Retrying { attempt, wait, why }) => {
                    on_event(Event::Retrying { attempt, wait, why });
                }
                Ok(Chunk::Finished(finish)) => {
                    failure = stopped_short(&finish);
                    self.answer.finish = Some(word(&finish));
                }
                Err(error) => failure = Some(Missing::NoAnswer(error.to_string())),
            }
        }
        // A model that puts everything into its reasoning has still answered.
        let whole = if self.answer.text.trim().is_empty() {
            &self.answer.reasoning
        } else {
            &self.answer.text
        };
        self.answer.judged = match failure {
            Some(missing @ Missing::NoAnswer(_)) => Judged::Missing(missing),
            stopped => match (verdict::read(task, whole), stopped) {
                (Ok(reading), _) => Judged::from(reading),
                (Err(_), Some(stopped)) => Judged::Missing(stopped),
                (Err(why), None) => Judged::Missing(Missing::NotInAnswer(why.to_string())),
            },
        };
        Ok(())
    }
}

/// Why an answer that ended this way may hold no verdict.
fn stopped_short(finish: &Finish) -> Option<Missing> {
    let why = match finish {
        Finish::Length => "the answer ran into the token limit; raise max_tokens".to_string(),
        Finish::ContentFilter => "the server's content filter stopped the answer".to_string(),
        Finish::Refusal(text) => format!("the model declined: {text}"),
        Finish::Stop | Finish::Other(_) => return None,
    };
    Some(Missing::NotInAnswer(why))
}

fn word(finish: &Finish) -> String {
    match finish {
        Finish::Stop => "stop".into(),
        Finish::Length => "length".into(),
        Finish::ContentFilter => "content_filter".into(),
        Finish::Refusal(_) => "refusal".into(),
        Finish::Other(word) => word.clone(),
    }
}

/// The parameters that are sent: a temperature that the user does not say may be the template's.
fn parameters(question: &Question, model: &ModelJudge) -> Parameters {
    Parameters {
        temperature: model.parameters.temperature.or(question.temperature),
        ..model.parameters
    }
}

fn record(question: &Question, judge: &Judge) -> NewRun {
    let case = &question.case;
    let json = |value: serde_json::Result<String>| value.unwrap_or_default();
    let (endpoint, parameters, messages) = match judge {
        Judge::Reference => {
            let changes = case.thresholds.changes();
            let words: Vec<_> = changes.iter().map(ToString::to_string).collect();
            let parameters = match words.as_slice() {
                [] => serde_json::json!({}),
                words => serde_json::json!({ "thresholds": words }),
            };
            let built_in = "built in".to_string();
            (built_in, parameters.to_string(), "[]".to_string())
        }
        Judge::Model(model) => (
            model.endpoint.place().to_string(),
            json(serde_json::to_string(&parameters(question, model))),
            json(serde_json::to_string(&question.messages())),
        ),
    };
    NewRun {
        scenario: case.name.clone(),
        scenario_hash: case.scene.scenario.hash.to_string(),
        ego: case.scene.ego.to_string(),
        task: case.task,
        frame: case.frame.name().to_string(),
        techniques: case.techniques.to_string(),
        window: (case.window.first(), case.window.last()),
        model: judge.id().to_string(),
        endpoint,
        template: question.template.clone(),
        template_hash: question.template_hash.clone(),
        messages,
        parameters,
    }
}

/// A run in the store; dropped before its end, it is written down as cancelled.
struct Keeper {
    store: Arc<Store>,
    run: RunId,
    ended: bool,
}

impl Keeper {
    fn begin(store: Arc<Store>, run: &NewRun) -> Result<Self, StoreError> {
        let run = store.begin(run)?;
        Ok(Self {
            store,
            run,
            ended: false,
        })
    }

    fn finish(mut self, ending: &Ending) -> Result<(), StoreError> {
        self.ended = true;
        self.store.finish(self.run, ending)
    }
}

impl Drop for Keeper {
    fn drop(&mut self) {
        if !self.ended {
            // Nobody is left to hear of an error here; the pieces are in the store in any case.
            let _ = self
                .store
                .finish(self.run, &Ending::bare(RunState::Cancelled));
        }
    }
}
