//! Asks a language model: builds the request and the store's record; with tools, rounds of calls until it answers.

use std::collections::HashSet;

use futures_util::StreamExt;
use nearmiss_ask::llm::{
    self, Chunk, Finish, Image, Parameters, Request, ResponseFormat, Schema, Secrets, Token,
    ToolTurn, Usage, sends_form,
};
use nearmiss_ask::prompts::Pack;
use nearmiss_scene::verdict::{self, Task};
use nearmiss_store::{NewRun, StoreError, StoredImage};
use serde::Serialize;

use super::answer::{
    MissingVerdict, finish_name, read_from, stopped_short, too_long, unless_cut, weighed,
};
use super::consumption::stated;
use super::judges::{Judge, ModelJudge};
use super::question::{Case, Question};
use super::run_case::{Asking, Event, RunOptions};
use super::tool_rounds;

/// How one request ended.
#[derive(Default)]
struct TurnEnd {
    /// Why there may be no answer.
    failure: Option<MissingVerdict>,
    /// The budget did not allow it to be sent.
    over_budget: Option<String>,
    /// The calls that it ended in.
    turn: Option<ToolTurn>,
    /// The tokens of the answer, where they were asked for.
    tokens: Vec<Token>,
    /// Its usage, where the server told it.
    usage: Option<Usage>,
    /// Whether the server may want money for it.
    sent: bool,
    /// The server did not take the request as it was.
    refused: bool,
}

impl Asking {
    /// Why the budget allowed nothing to be sent, where that is so.
    pub(super) async fn model(
        &mut self,
        question: &Question,
        model: &ModelJudge,
        on_event: &mut impl FnMut(Event),
    ) -> Option<String> {
        let mut request = request(question, model);
        let weigh = llm::gives_log_probabilities(&model.endpoint, &request);
        let mut paid = false;
        let (failure, over_budget, tokens) = loop {
            self.turn = [self.answer.text.len(), self.answer.reasoning.len()];
            if let (Some(tools), Some(limits)) = (&mut request.tools, model.parameters.tools) {
                tools.rounds.clone_from(&self.answer.tool_rounds);
                tools.may_call = tool_rounds::may_call(&tools.rounds, &limits);
            }
            let mut end = self.turn(&request, model, on_event).await;
            self.consume(&end, paid);
            if end.refused && !paid && !self.answer.tool_rounds.is_empty() {
                match self.begin_anew(on_event) {
                    None => continue,
                    Some(why) => break (Some(MissingVerdict::NoAnswer(why)), None, Vec::new()),
                }
            }
            let round = self.answer.tool_rounds.len() + 1;
            if let Some(failure) = end.failure.take_if(|_| paid) {
                // Rounds before this one were paid, so that something was sent.
                end.failure = Some(match failure {
                    MissingVerdict::NotSent(why) | MissingVerdict::NoAnswer(why) => {
                        MissingVerdict::NoAnswer(format!("in tool round {round}: {why}"))
                    }
                    other => other,
                });
                end.over_budget = None;
            }
            paid |= end.sent;
            let (Some(turn), Some(limits)) = (end.turn.take(), model.parameters.tools) else {
                break (end.failure, end.over_budget, end.tokens);
            };
            if !request.tools.as_ref().is_some_and(|tools| tools.may_call) {
                let why = MissingVerdict::NotInAnswer(tool_rounds::beyond(&limits));
                break (Some(why), None, Vec::new());
            }
            if let Some(why) = self.round(question, turn, &limits, on_event) {
                break (Some(MissingVerdict::NoAnswer(why)), None, Vec::new());
            }
        };
        let task = question.case.task;
        let secrets = Secrets::sent(&model.client, &model.endpoint);
        let read = read_from(task, &self.answer, self.turn, failure);
        let in_words = question.picture.is_none() && self.answer.tool_rounds.is_empty();
        self.answer.judged = unless_cut(
            read.without(&secrets),
            self.answer.consumed.input_tokens,
            in_words.then(|| question.tokens()),
        );
        if weigh && !weighed(task, &tokens, &mut self.answer.judged) {
            let note = if tokens.is_empty() {
                "the server sent no log probabilities"
            } else {
                "the log probabilities do not show the token of the verdict"
            };
            on_event(Event::Chunk(Chunk::Note(note.into())));
        }
        over_budget
    }

    /// Leaves out the rounds of an earlier run, with which the server takes no request: each later run would fail as this
    /// one did. Why that failed, where it did.
    fn begin_anew(&mut self, on_event: &mut impl FnMut(Event)) -> Option<String> {
        self.answer.tool_rounds.clear();
        if let Some((store, run)) = &self.store
            && let Err(why) = store.keep_rounds(*run, "[]")
        {
            return Some(format!("the tool calls cannot be stored: {why}"));
        }
        let note =
            "the server does not take the tool calls of the earlier run; asking from the beginning";
        on_event(Event::Chunk(Chunk::Note(note.into())));
        None
    }

    /// Answers the calls of a turn and keeps both before anything else is paid. Why that failed, where it did.
    fn round(
        &mut self,
        question: &Question,
        turn: ToolTurn,
        limits: &llm::ToolLimits,
        on_event: &mut impl FnMut(Event),
    ) -> Option<String> {
        let made = tool_rounds::calls(&self.answer.tool_rounds);
        let round = tool_rounds::answered(question, turn, made, limits);
        self.answer.tool_rounds.push(round.clone());
        if self.answer.text.len() > self.turn[0] {
            self.piece(Chunk::Text("\n\n".into()));
        }
        if let Some((store, run)) = &self.store {
            // What the run can cost at most covers all rounds already.
            let json = serde_json::to_string(&self.answer.tool_rounds);
            let kept = json
                .map_err(StoreError::from)
                .and_then(|json| store.keep_rounds(*run, &json));
            if let Err(why) = kept {
                return Some(format!("the tool calls cannot be stored: {why}"));
            }
        }
        on_event(Event::Tools(Box::new(round)));
        if !tool_rounds::may_call(&self.answer.tool_rounds, limits) {
            let note = format!(
                "{}, the most allowed; the model answers without tools",
                tool_rounds::rounds_summary(&self.answer.tool_rounds, "tool call"),
            );
            on_event(Event::Chunk(Chunk::Note(note)));
        }
        None
    }

    /// Adds what a request consumed to what those before it did; unknown costs stay unknown.
    fn consume(&mut self, end: &TurnEnd, paid: bool) {
        let all = &mut self.answer.consumed;
        let usage = end.usage.unwrap_or_default();
        let add = |sum: &mut Option<u64>, more: Option<u64>| {
            *sum = match (paid, end.sent, more) {
                (false, _, more) => more,
                // A request that never left uses nothing.
                (true, false, None) => *sum,
                // What one of them did not tell is not known of all.
                (true, _, more) => sum.zip(more).map(|(a, b)| a.saturating_add(b)),
            };
        };
        add(&mut all.input_tokens, usage.input_tokens);
        add(&mut all.output_tokens, usage.output_tokens);
        add(&mut all.reasoning_tokens, usage.reasoning_tokens);
        add(&mut all.cached_tokens, usage.cached_tokens);
        let usd = usage.cost.map(|cost| cost.usd);
        all.cost_usd = match (paid, end.sent, usd) {
            (false, _, usd) => usd,
            // A request that never left costs nothing.
            (true, false, None) => all.cost_usd,
            (true, _, usd) => all.cost_usd.zip(usd).map(|(a, b)| a + b),
        };
    }

    /// One request, and its answer as it arrives.
    async fn turn(
        &mut self,
        request: &Request,
        model: &ModelJudge,
        on_event: &mut impl FnMut(Event),
    ) -> TurnEnd {
        let mut end = TurnEnd::default();
        let mut chunks = llm::stream(&model.client, model.endpoint.clone(), request.clone());
        let (mut retried, mut begun) = (false, false);
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
                    (begun, end.sent) = (true, true);
                    // Of several turns the first name that is another one than was asked for counts.
                    let returned = &mut self.answer.model_returned;
                    let asked = Some(request.model.as_str());
                    if returned.is_none() || returned.as_deref() == asked {
                        *returned = model.clone().or(returned.take());
                    }
                    on_event(Event::Chunk(Chunk::Started { model }));
                }
                Ok(piece @ (Chunk::Reasoning(_) | Chunk::Text(_))) => self.piece(piece),
                Ok(Chunk::ToolCalls(turn)) => end.turn = Some(turn),
                Ok(Chunk::LogProbabilities(given)) => end.tokens = given,
                Ok(Chunk::Usage(usage)) => {
                    end.usage = Some(usage);
                    let returned = self.answer.model_returned.as_deref();
                    let source = usage.cost.map(|cost| stated(cost.source, model, returned));
                    self.answer.price_source = source;
                }
                Ok(retrying @ Chunk::Retrying { .. }) => {
                    retried = true;
                    on_event(Event::Chunk(retrying));
                }
                Ok(Chunk::Finished(finish)) => {
                    let called = finish == Finish::ToolCalls && request.tools.is_some();
                    end.failure = stopped_short(&finish).filter(|_| !called);
                    if finish == Finish::TooLong {
                        on_event(Event::Chunk(Chunk::Note(too_long())));
                    }
                    self.answer.finish = Some(finish_name(&finish));
                    // Nothing follows, and the end is written at once, together with what waits.
                    break;
                }
                Err(error) => {
                    end.refused = matches!(error, llm::Error::BadRequest { .. });
                    if let Some(barrier) = error.barrier().filter(|_| !begun) {
                        on_event(Event::Barred(barrier));
                    }
                    if matches!(error, llm::Error::Budget { .. }) && !retried && !begun {
                        end.over_budget = Some(error.to_string());
                    }
                    end.failure = Some(if error.before_sending() && !retried {
                        MissingVerdict::NotSent(error.to_string())
                    } else {
                        end.sent = true;
                        MissingVerdict::NoAnswer(error.to_string())
                    });
                }
            }
            self.recorder.flush_due(on_event);
        }
        if request.tools.is_none() {
            end.turn = None;
        }
        end
    }
}

/// Builds the request.
pub fn request(question: &Question, model: &ModelJudge) -> Request {
    let task = question.case.task;
    Request {
        model: model.name.clone(),
        messages: question.messages(),
        parameters: Parameters {
            // A temperature that the user does not say may be the template's.
            temperature: model.parameters.temperature.or(question.temperature),
            // They are about the yes or no of a verdict.
            log_probabilities: model.parameters.log_probabilities && Task::VERDICTS.contains(&task),
            ..model.parameters
        },
        tools: model.parameters.tools.map(|_| tool_rounds::toolbox()),
        // The same form in all techniques: a chain of thought has its place in the justification, the first key. The
        // paper's answers are reasoning and then JSON with keys of its own, which no schema can ask for.
        schema: (question.pack == Pack::Standard).then(|| Schema {
            is_bounded: false,
            name: format!("{}_verdict", task.name()),
            schema: verdict::schema_with_ids(task, &described_ids(question)),
        }),
    }
}

/// The obstacles that an answer may name: those of the window that the description speaks of, all where it has no words.
fn described_ids(question: &Question) -> Vec<i64> {
    let Case { scene, window, .. } = &question.case;
    let words = question
        .description
        .split(|c: char| !c.is_ascii_digit() && c != '-');
    let words: HashSet<&str> = words.collect();
    let there = scene
        .participants()
        .filter(|other| window.steps().any(|step| other.at(step).is_some()));
    let ids = there.map(|other| other.obstacle.id);
    let known =
        ids.filter(|id| question.description.is_empty() || words.contains(id.to_string().as_str()));
    known.collect()
}

/// The most that asking can cost, US dollars, where price and limit of the answer are known: with tools, that of every
/// round and of the answer after them.
pub fn most_usd(question: &Question, model: &ModelJudge) -> Option<f64> {
    let request = request(question, model);
    let Some(limits) = model.parameters.tools else {
        return model.endpoint.at_most(&request);
    };
    let answer = model
        .endpoint
        .answer_limit(&request.parameters)
        .unwrap_or(0);
    let rounds = 0..=limits.rounds.min(MAX_ROUNDS);
    let costs = rounds.map(|round| {
        let added = tool_rounds::most_added(round, &limits, answer);
        model.endpoint.at_most_with(&request, added)
    });
    costs.sum()
}

/// Rounds that a bound is worked out for: no option allows more.
const MAX_ROUNDS: u32 = 100;

/// What the store keeps before anything is sent.
///
/// # Errors
/// Something cannot be written as JSON.
pub fn record(
    question: &Question,
    judge: &Judge,
    wanted: &RunOptions,
) -> Result<NewRun, serde_json::Error> {
    let case = &question.case;
    let provider = judge.id().split('/').next().unwrap_or_default();
    let mut run = NewRun {
        sample: wanted.sample,
        batch: wanted.batch.clone(),
        scenario: case.name.clone(),
        scenario_hash: Some(case.scene.scenario.hash.to_string()),
        ego: case.scene.ego.to_string(),
        task: case.task,
        frame: case.frame.name().to_string(),
        techniques: case.techniques.to_string(),
        window: Some((case.window.first(), case.window.last())),
        model: judge.id().to_string(),
        provider: provider.to_string(),
        dialect: None,
        endpoint: "built in".to_string(),
        address: None,
        template: question.template.clone(),
        template_version: question.template_version.clone(),
        template_hash: question.template_hash.clone(),
        messages: "[]".to_string(),
        parameters: thresholds(case)?,
        answer_schema: None,
        images: Vec::new(),
    };
    if let Judge::Model(model) = judge {
        let request = request(question, model);
        let endpoint = model.endpoint.for_request(&request);
        let place = endpoint.place();
        run.dialect = Some(endpoint.dialect.name().to_string());
        run.endpoint = place.to_string();
        run.address = Some(place.url);
        run.messages = serde_json::to_string(&request.messages)?;
        run.images = request.images().map(stored).collect();
        // The limit that is sent may be that of the configuration.
        let parameters = Parameters {
            max_tokens: model.endpoint.answer_limit(&request.parameters),
            ..request.parameters
        };
        let form = shape(model.endpoint.response_format, request.schema.as_ref());
        let calls = parameters.tools.is_some();
        let is_later = calls && form.is_some() && !sends_form(&model.endpoint, &request);
        run.parameters = serde_json::to_string(&Sent {
            parameters,
            tool_table: calls.then(tool_rounds::table_hash),
            answer_form: is_later.then_some(AT_THE_LIMIT),
        })?;
        run.answer_schema = form.as_ref().map(serde_json::to_string).transpose()?;
    }
    Ok(run)
}

/// What is sent beside the messages, as the store keeps it.
#[derive(Serialize)]
struct Sent {
    #[serde(flatten)]
    parameters: Parameters,
    /// Changed tools are another question.
    #[serde(skip_serializing_if = "Option::is_none")]
    tool_table: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    answer_form: Option<&'static str>,
}

/// When the form of the answer is sent where a server takes none beside tools: a model that answers before the limit was
/// not shown one.
const AT_THE_LIMIT: &str = "once tools may not be called";

/// An image as the store keeps it.
fn stored(image: &Image) -> StoredImage {
    StoredImage {
        sha256: image.sha256.clone(),
        media_type: image.media_type.clone(),
        width: image.width,
        height: image.height,
        bytes: image.bytes.clone(),
    }
}

/// The part of the schema that is sent to the server.
fn shape(format: ResponseFormat, schema: Option<&Schema>) -> Option<serde_json::Value> {
    match format {
        ResponseFormat::Off => None,
        ResponseFormat::JsonObject => schema.map(|_| serde_json::json!({ "type": "json_object" })),
        ResponseFormat::JsonSchema => schema.map(|schema| schema.schema.clone()),
    }
}

/// The changes to the thresholds that the built-in judge grades with.
fn thresholds(case: &Case) -> Result<String, serde_json::Error> {
    serde_json::to_string(&Judging {
        thresholds: case.thresholds.change_words(),
    })
}

#[derive(Serialize)]
struct Judging {
    #[serde(skip_serializing_if = "Vec::is_empty")]
    thresholds: Vec<String>,
}
