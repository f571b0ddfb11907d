//! One result of a batch: a whole answer as the dialect has it, or why there is none.

use serde_json::Value;

use super::super::chunk::{Chunk, Finish};
use super::super::decoder::Decoder;
use super::super::endpoint::Endpoint;
use super::super::error::without_key;
use super::super::problem::{Problem, tidy};
use super::{Answered, Outcome};

/// The answer in a document that was not streamed, with the key taken out of what the server said.
pub fn answer(endpoint: &Endpoint, document: &Value) -> Outcome {
    let key = endpoint.usable_key();
    let mut decoder = Decoder::new(endpoint.dialect, endpoint.place());
    let chunks = match decoder.document(&document.to_string()) {
        Ok(chunks) => chunks,
        Err(error) => return Outcome::Failed(error.cleared_of(key).to_string()),
    };
    let mut answer = Answered {
        text: String::new(),
        reasoning: String::new(),
        usage: None,
        model: None,
        finish: Finish::Other("unstated".into()),
    };
    for chunk in chunks {
        match chunk {
            Chunk::Started { model } => answer.model = model.map(|m| without_key(&m, key)),
            Chunk::Reasoning(text) => answer.reasoning.push_str(&text),
            Chunk::Text(text) => answer.text.push_str(&text),
            Chunk::Usage(usage) => answer.usage = Some(usage),
            Chunk::Finished(finish) => {
                answer.finish = match finish {
                    Finish::Refusal(text) => Finish::Refusal(without_key(&text, key)),
                    Finish::Blocked(text) => Finish::Blocked(without_key(&text, key)),
                    Finish::Other(text) => Finish::Other(without_key(&text, key)),
                    other => other,
                };
            }
            Chunk::Note(_) | Chunk::Retrying { .. } => {}
        }
    }
    answer.text = without_key(&answer.text, key);
    answer.reasoning = without_key(&answer.reasoning, key);
    Outcome::Answered(Box::new(answer))
}

/// A failure in the provider's words: one line without the key.
pub fn failed(endpoint: &Endpoint, document: &Value, status: Option<u64>) -> Outcome {
    let problem = Problem::in_body(&document.to_string());
    let status = status.map(|s| format!("{s}: ")).unwrap_or_default();
    let code = problem.code.or(problem.kind);
    let code = code.map(|c| format!(" ({c})")).unwrap_or_default();
    let words = format!("{status}{}{code}", problem.message);
    Outcome::Failed(line(endpoint, &words))
}

/// Words of the provider's on one line, without the key.
pub fn line(endpoint: &Endpoint, words: &str) -> String {
    tidy(&without_key(words, endpoint.usable_key()), 1000)
}
