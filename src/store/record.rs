//! Runs as JSON, one object each: complete, and identical when read back.

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::{Consumed, Ending, Key, NewRun, Origin, Run, RunId, RunState};
use crate::verdict::Task;

/// Why a line is not a valid run.
#[derive(Debug, thiserror::Error)]
pub enum RecordError {
    /// It is not JSON of this form.
    #[error("this is no run: {0}")]
    Form(#[from] serde_json::Error),
    /// It was written by a newer program.
    #[error("this run has form {0}, this program knows {FORM}; use a newer nearmiss")]
    Newer(u32),
    /// A word that is not known.
    #[error("{field} `{word}` is not known")]
    Word {
        /// Which field.
        field: &'static str,
        /// The word.
        word: String,
    },
    /// The key is not the one of the request.
    #[error("the key does not belong to the request: the line was changed")]
    Key,
    /// The answer is still arriving in another program.
    #[error("the answer was still arriving when it was exported")]
    Running,
}

/// The form of the records.
const FORM: u32 = 2;

/// All columns of a run; `nearmiss_run` says that this is one, and in which form.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Record {
    nearmiss_run: u32,
    #[serde(default)]
    id: i64,
    key: Option<String>,
    sample: u32,
    batch: Option<String>,
    origin: String,
    source: Option<String>,
    created_ms: i64,
    updated_ms: i64,
    scenario: String,
    scenario_hash: Option<String>,
    ego: String,
    task: String,
    frame: String,
    techniques: String,
    window: Option<(i64, i64)>,
    model: String,
    model_returned: Option<String>,
    provider: String,
    dialect: Option<String>,
    endpoint: String,
    address: Option<String>,
    template: String,
    template_version: Option<String>,
    template_hash: String,
    messages: Value,
    parameters: Value,
    answer_schema: Option<Value>,
    state: String,
    answer: String,
    reasoning: String,
    finish: Option<String>,
    verdict: Option<Value>,
    reading: Option<String>,
    error: Option<String>,
    input_tokens: Option<u64>,
    output_tokens: Option<u64>,
    reasoning_tokens: Option<u64>,
    cached_tokens: Option<u64>,
    cost_usd: Option<f64>,
    price_source: Option<String>,
    first_chunk_ms: Option<u64>,
    duration_ms: Option<u64>,
    notes: String,
    pinned: bool,
    deleted_ms: Option<i64>,
}

impl Run {
    /// The run as one JSON object.
    #[must_use]
    pub fn to_record(&self) -> Value {
        let (question, ending, consumed) = (&self.question, &self.ending, &self.ending.consumed);
        // Text that is no JSON stays text, and so comes back as it was.
        let json = |text: &str| serde_json::from_str(text).unwrap_or_else(|_| Value::from(text));
        let record = Record {
            nearmiss_run: FORM,
            id: self.id.0,
            key: self.key.as_ref().map(|key| key.as_str().to_string()),
            sample: question.sample,
            batch: question.batch.clone(),
            origin: self.origin.name().into(),
            source: self.source.clone(),
            created_ms: self.created_ms,
            updated_ms: self.updated_ms,
            scenario: question.scenario.clone(),
            scenario_hash: question.scenario_hash.clone(),
            ego: question.ego.clone(),
            task: question.task.name().into(),
            frame: question.frame.clone(),
            techniques: question.techniques.clone(),
            window: question.window,
            model: question.model.clone(),
            model_returned: ending.model_returned.clone(),
            provider: question.provider.clone(),
            dialect: question.dialect.clone(),
            endpoint: question.endpoint.clone(),
            address: question.address.clone(),
            template: question.template.clone(),
            template_version: question.template_version.clone(),
            template_hash: question.template_hash.clone(),
            messages: json(&question.messages),
            parameters: json(&question.parameters),
            answer_schema: question.answer_schema.as_deref().map(json),
            state: ending.state.name().into(),
            answer: self.answer.clone(),
            reasoning: self.reasoning.clone(),
            finish: ending.finish.clone(),
            verdict: self.verdict_json.as_deref().map(json),
            reading: ending.reading.clone(),
            error: ending.error.clone(),
            input_tokens: consumed.input_tokens,
            output_tokens: consumed.output_tokens,
            reasoning_tokens: consumed.reasoning_tokens,
            cached_tokens: consumed.cached_tokens,
            cost_usd: consumed.cost_usd,
            price_source: ending.price_source.clone(),
            first_chunk_ms: consumed.first_chunk_ms,
            duration_ms: consumed.duration_ms,
            notes: self.notes.clone(),
            pinned: self.pinned,
            deleted_ms: self.deleted_ms,
        };
        serde_json::to_value(record).unwrap_or_default()
    }

    /// A run from a line that [`Run::to_record`] wrote, in this store or another. A run asked elsewhere counts as
    /// replayed here, and keeps the number of the other store.
    ///
    /// # Errors
    /// The line is not a run, or was altered.
    pub fn from_record(line: &str) -> Result<Self, RecordError> {
        #[derive(Deserialize)]
        struct Form {
            nearmiss_run: u32,
        }
        let form: Form = serde_json::from_str(line)?;
        if form.nearmiss_run > FORM {
            return Err(RecordError::Newer(form.nearmiss_run));
        }
        let record: Record = serde_json::from_str(line)?;
        let origin = match known("origin", &record.origin, Origin::parse)? {
            Origin::Asked => Origin::Replayed,
            other => other,
        };
        let state = known("state", &record.state, RunState::parse)?;
        if state == RunState::Running {
            return Err(RecordError::Running);
        }
        let text = |value: Value| match value {
            Value::String(text) => text,
            other => other.to_string(),
        };
        let question = NewRun {
            sample: record.sample,
            batch: record.batch,
            scenario: record.scenario,
            scenario_hash: record.scenario_hash,
            ego: record.ego,
            task: known("task", &record.task, Task::parse)?,
            frame: record.frame,
            techniques: record.techniques,
            window: record.window,
            model: record.model,
            provider: record.provider,
            dialect: record.dialect,
            endpoint: record.endpoint,
            address: record.address,
            template: record.template,
            template_version: record.template_version,
            template_hash: record.template_hash,
            messages: text(record.messages),
            parameters: text(record.parameters),
            answer_schema: record.answer_schema.map(text),
        };
        let key = record
            .key
            .as_deref()
            .map(|text| Key::parse(text).ok_or(RecordError::Key));
        let key = key.transpose()?;
        // The key of a recorded answer is made of more than the request, which is not known.
        let own = question.key();
        if (origin != Origin::Recorded && own != key)
            || (origin == Origin::Recorded && own.is_some())
        {
            return Err(RecordError::Key);
        }
        let verdict_json = record.verdict.map(|verdict| verdict.to_string());
        let verdict = verdict_json
            .as_deref()
            .and_then(|json| serde_json::from_str(json).ok());
        Ok(Self {
            id: RunId(record.id),
            created_ms: record.created_ms,
            updated_ms: record.updated_ms,
            key,
            origin,
            source: record.source,
            question,
            answer: record.answer,
            reasoning: record.reasoning,
            ending: Ending {
                state,
                model_returned: record.model_returned,
                finish: record.finish,
                verdict,
                reading: record.reading,
                error: record.error,
                consumed: Consumed {
                    input_tokens: record.input_tokens,
                    output_tokens: record.output_tokens,
                    reasoning_tokens: record.reasoning_tokens,
                    cached_tokens: record.cached_tokens,
                    cost_usd: record.cost_usd,
                    first_chunk_ms: record.first_chunk_ms,
                    duration_ms: record.duration_ms,
                },
                price_source: record.price_source,
            },
            verdict_json,
            notes: record.notes,
            pinned: record.pinned,
            deleted_ms: record.deleted_ms,
        })
    }
}

fn known<T>(
    field: &'static str,
    word: &str,
    parse: impl FnOnce(&str) -> Option<T>,
) -> Result<T, RecordError> {
    parse(word).ok_or_else(|| RecordError::Word {
        field,
        word: word.to_string(),
    })
}
