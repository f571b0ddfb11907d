//! Builds the request and the store's record from a question and a judge.

use std::collections::HashSet;

use super::judges::{Judge, ModelJudge};
use super::question::{Case, Question};
use super::run_case::RunOptions;
use super::tool_rounds;
use nearmiss_ask::llm::{Image, Parameters, Request, ResponseFormat, Schema, sends_form};
use nearmiss_ask::prompts::Pack;
use nearmiss_scene::verdict::{self, Task};
use nearmiss_store::{NewRun, StoredImage};

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
    let rounds = 0..=limits.rounds.min(MOST_ROUNDS);
    let costs = rounds.map(|round| {
        let added = tool_rounds::most_added(round, &limits, answer);
        model.endpoint.at_most_with(&request, added)
    });
    costs.sum()
}

/// Rounds that a bound is worked out for: no option allows more.
const MOST_ROUNDS: u32 = 100;

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
        let mut sent = serde_json::to_value(parameters)?;
        if parameters.tools.is_some() {
            // The tools are part of what is sent, so changed ones are another question.
            sent["tool_table"] = tool_rounds::table_hash().into();
            let form = shape(model.endpoint.response_format, request.schema.as_ref());
            if form.is_some() && !sends_form(&model.endpoint, &request) {
                sent["answer_form"] = AT_THE_LIMIT.into();
            }
        }
        run.parameters = sent.to_string();
        run.answer_schema = shape(model.endpoint.response_format, request.schema.as_ref())
            .map(|shape| serde_json::to_string(&shape))
            .transpose()?;
    }
    Ok(run)
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
    let changes = case.thresholds.changes();
    let words: Vec<_> = changes.iter().map(ToString::to_string).collect();
    serde_json::to_string(&match words.as_slice() {
        [] => serde_json::json!({}),
        words => serde_json::json!({ "thresholds": words }),
    })
}
