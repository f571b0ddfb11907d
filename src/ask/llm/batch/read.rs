//! Reads one batch result: a complete answer in the dialect, or an error.

use serde_json::Value;

use super::super::chunk::{Chunk, Finish};
use super::super::decoder::Decoder;
use super::super::error::Error;
use super::super::error_body::{ErrorBody, LONGEST_QUOTE, tidy};
use super::call::Calls;
use super::{Outcome, WholeAnswer};

/// The answer in a document that was not streamed, with secrets taken out of what the server said.
pub fn answer(calls: &Calls, document: &Value) -> Outcome {
    let (endpoint, secrets) = (calls.endpoint(), calls.secrets());
    let clear = |text: String| secrets.redact(&text);
    let mut decoder = Decoder::new(endpoint.dialect, endpoint.place());
    let chunks = match decoder.document(&document.to_string()) {
        Ok(chunks) => chunks,
        Err(error) => return Outcome::Failed(error.cleared_of(secrets).to_string()),
    };
    let mut answer = WholeAnswer {
        text: String::new(),
        reasoning: String::new(),
        usage: None,
        tokens: Vec::new(),
        model: None,
        finish: Finish::Other("unstated".into()),
    };
    for chunk in chunks {
        match chunk {
            Chunk::Started { model } => answer.model = model.map(clear),
            Chunk::Reasoning(text) => answer.reasoning.push_str(&text),
            Chunk::Text(text) => answer.text.push_str(&text),
            Chunk::Usage(usage) => answer.usage = Some(usage),
            Chunk::LogProbabilities(tokens) => answer.tokens = tokens,
            Chunk::Finished(finish) => {
                answer.finish = match finish {
                    Finish::Refusal(text) => Finish::Refusal(clear(text)),
                    Finish::Blocked(text) => Finish::Blocked(clear(text)),
                    Finish::Other(text) => Finish::Other(clear(text)),
                    other => other,
                };
            }
            Chunk::Note(_) | Chunk::Retrying { .. } | Chunk::ToolCalls(_) => {}
        }
    }
    answer.text = secrets.redact_cut(&answer.text);
    answer.reasoning = secrets.redact_cut(&answer.reasoning);
    Outcome::Answered(Box::new(answer))
}

/// A failure in the provider's words: one line without secrets.
pub fn failed(calls: &Calls, document: &Value, status: Option<u64>) -> Outcome {
    let body = ErrorBody::in_body(&calls.secrets().redact(&document.to_string()));
    let status = status.map(|s| format!("{s}: ")).unwrap_or_default();
    let code = body
        .code
        .or(body.kind)
        .map(|c| format!(" ({c})"))
        .unwrap_or_default();
    let words = format!("{status}{}{code}", body.message);
    Outcome::Failed(line(calls, &words))
}

/// The id of a question that an entry of results names.
pub fn custom_id<'a>(calls: &Calls, entry: &'a Value) -> Result<&'a str, Error> {
    let id = entry.get("custom_id").and_then(Value::as_str);
    id.ok_or_else(|| calls.malformed(&format!("no custom_id: {entry}")))
}

/// Words of the provider's on one line, without secrets.
pub fn line(calls: &Calls, words: &str) -> String {
    tidy(&calls.secrets().redact_cut(words), LONGEST_QUOTE)
}
