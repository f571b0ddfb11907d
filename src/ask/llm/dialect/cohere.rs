//! Cohere's chat, version 2.

use serde::Serialize;
use serde_json::Value;

use super::{AnswerReader, Notes, WireProtocol, count, given, names_in, string};
use crate::llm::accumulator::ResponseAccumulator;
use crate::llm::chunk::{Finish, Usage};
use crate::llm::endpoint::Endpoint;
use crate::llm::error::Error;
use crate::llm::request::{Request, Role};

/// The body of a question.
#[derive(Serialize)]
struct Question<'a> {
    model: &'a str,
    messages: Vec<Turn<'a>>,
    stream: bool,
    max_tokens: Option<u32>,
    temperature: Option<f64>,
    seed: Option<u64>,
}

#[derive(Serialize)]
struct Turn<'a> {
    role: Role,
    content: &'a str,
}

/// Cohere's chat.
pub(super) struct Protocol;

impl WireProtocol for Protocol {
    fn method(&self) -> &'static str {
        "/chat"
    }

    fn version(&self, _root: &str) -> &'static str {
        "/v2"
    }

    fn body(&self, endpoint: &Endpoint, request: &Request, notes: &mut Notes) -> Value {
        let turns = request.messages.iter().map(|message| Turn {
            role: message.role,
            content: &message.content,
        });
        given(Question {
            model: &request.model,
            messages: turns.collect(),
            stream: true,
            max_tokens: endpoint.answer_limit(&request.parameters),
            temperature: notes.temperature(endpoint, request, 1.0),
            seed: notes.seed(endpoint, request),
        })
    }

    fn reader(&self) -> Box<dyn AnswerReader> {
        Box::new(CohereReader)
    }

    fn models<'a>(&self, list: &'a Value) -> Option<Vec<&'a str>> {
        names_in(list.get("models")?, "name", |_| true)
    }
}

#[derive(Debug)]
struct CohereReader;

impl AnswerReader for CohereReader {
    fn event(&mut self, value: &Value, answer: &mut ResponseAccumulator) -> Result<(), Error> {
        match string(value, "type") {
            Some("content-delta") => {
                let text = value.pointer("/delta/message/content/text");
                answer.push_text(text.and_then(Value::as_str).unwrap_or_default());
            }
            Some("message-end") => {
                answer.usage(Usage {
                    input_tokens: count(value, "/delta/usage/tokens/input_tokens"),
                    output_tokens: count(value, "/delta/usage/tokens/output_tokens"),
                    ..Usage::default()
                });
                let reason = value.pointer("/delta/finish_reason");
                answer.finish(match reason.and_then(Value::as_str) {
                    Some("COMPLETE") => Finish::Stop,
                    Some("MAX_TOKENS") => Finish::Length,
                    other => Finish::Other(other.unwrap_or("unstated").to_owned()),
                });
                answer.complete();
            }
            _ => {}
        }
        Ok(())
    }

    fn document(&mut self, value: &Value, answer: &mut ResponseAccumulator) -> Result<(), Error> {
        let text = value.pointer("/message/content/0/text");
        answer.push_text(text.and_then(Value::as_str).unwrap_or_default());
        answer.finish(Finish::Stop);
        answer.complete();
        Ok(())
    }
}
