//! A request body under construction, with notes on what it cannot carry.

use serde_json::{Map, Value, json};

use crate::llm::effort::Effort;
use crate::llm::endpoint::Endpoint;
use crate::llm::quirks::{LogProbabilities, Temperature};
use crate::llm::request::Request;

/// A JSON object being written, with what people should know about it.
#[derive(Debug, Default)]
pub(in crate::llm) struct Body {
    pub fields: Map<String, Value>,
    pub notes: Vec<String>,
}

impl Body {
    pub fn put(&mut self, name: &str, value: Value) {
        self.fields.insert(name.to_owned(), value);
    }

    /// Puts an object into this one, unless it is empty, and takes over its notes.
    pub fn put_inner(&mut self, name: &str, inner: Self) {
        if !inner.fields.is_empty() {
            self.put(name, Value::Object(inner.fields));
        }
        self.notes.extend(inner.notes);
    }

    pub fn note(&mut self, text: &str) {
        self.notes.push(text.to_owned());
    }

    /// Something that was asked for and cannot be sent.
    pub fn untaken(&mut self, what: &str, why: &str) {
        self.notes.push(format!("{what} is not sent: {why}"));
    }

    /// The temperature, if one is asked for and the model takes it; `most` is the highest the API takes.
    pub fn temperature(
        &mut self,
        endpoint: &Endpoint,
        request: &Request,
        most: f64,
        put: fn(&mut Self, Value),
    ) {
        let Some(temperature) = request.parameters.temperature else {
            return;
        };
        let thinks = request.parameters.effort != Some(Effort::Off);
        match endpoint.quirks.temperature {
            Temperature::Fixed if temperature != 1.0 => {
                self.untaken("temperature", "this model accepts only 1");
            }
            Temperature::NotThinking if thinks => self.untaken(
                "temperature",
                "no effect while this model thinks, which it does unless effort is off",
            ),
            _ if temperature > most => {
                self.untaken("temperature", &format!("this API accepts 0 to {most}"));
            }
            _ => put(self, json!(temperature)),
        }
    }

    /// The log probabilities, if they are asked for and the model gives them.
    pub fn log_probabilities(
        &mut self,
        endpoint: &Endpoint,
        request: &Request,
        put: fn(&mut Self),
    ) {
        let thinks = request.parameters.effort != Some(Effort::Off);
        match endpoint.quirks.log_probabilities {
            _ if !request.parameters.log_probabilities => {}
            LogProbabilities::Given => put(self),
            LogProbabilities::NotThinking if !thinks => put(self),
            LogProbabilities::NotThinking => self.untaken(
                "log_probabilities",
                "this model gives them only with effort off",
            ),
            LogProbabilities::Withheld => {
                self.untaken("log_probabilities", "this model gives none");
            }
        }
    }

    /// The seed, if one is asked for and the model takes it.
    pub fn seed(&mut self, endpoint: &Endpoint, request: &Request, put: fn(&mut Self, Value)) {
        match request.parameters.seed {
            Some(seed) if endpoint.quirks.seed => put(self, json!(seed)),
            Some(_) => self.untaken("seed", "not documented by this provider"),
            None => {}
        }
    }
}
