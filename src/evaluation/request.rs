//! From a question and a judge to the request that is sent, and to what the store keeps of it.

use super::case::Wanted;
use super::judges::{Judge, ModelJudge};
use super::question::Question;
use crate::llm::{Request, ResponseFormat, Schema};
use crate::store::NewRun;
use crate::verdict;

/// The protocol that all servers are spoken to in.
const DIALECT: &str = "openai_chat";

/// What is sent.
pub fn request(question: &Question, model: &ModelJudge) -> Request {
    let task = question.case.task;
    Request {
        model: model.name.clone(),
        messages: question.messages(),
        parameters: model.parameters,
        schema: Some(Schema {
            name: format!("{}_verdict", task.name()),
            schema: verdict::schema(task),
        }),
    }
}

/// What the store keeps before anything is sent.
///
/// # Errors
/// Something cannot be written as JSON.
pub fn record(
    question: &Question,
    judge: &Judge,
    wanted: &Wanted,
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
        parameters: "{}".to_string(),
        answer_schema: None,
    };
    if let Judge::Model(model) = judge {
        let request = request(question, model);
        let place = model.endpoint.place();
        run.dialect = Some(DIALECT.to_string());
        run.endpoint = place.to_string();
        run.address = Some(place.url);
        run.messages = serde_json::to_string(&request.messages)?;
        run.parameters = serde_json::to_string(&request.parameters)?;
        run.answer_schema = shape(model.endpoint.response_format, request.schema.as_ref())
            .map(|shape| serde_json::to_string(&shape))
            .transpose()?;
    }
    Ok(run)
}

/// As much of the wanted shape as the server is told.
fn shape(format: ResponseFormat, schema: Option<&Schema>) -> Option<serde_json::Value> {
    match format {
        ResponseFormat::Off => None,
        ResponseFormat::JsonObject => Some(serde_json::json!({ "type": "json_object" })),
        ResponseFormat::JsonSchema => schema.map(|schema| schema.schema.clone()),
    }
}
