//! Decodes the events of an answer to chunks, in any dialect and without a network.

use serde_json::Value;

use super::accumulator::ResponseAccumulator;
use super::chunk::Chunk;
use super::dialect::{AnswerReader, Dialect};
use super::error::{Error, ProviderAddress};
use super::error_body::ErrorBody;
use super::json::{MOST_VALUES, is_bounded};
use super::mend::HalfCharacter;

/// Turns the events of one answer into chunks.
#[derive(Debug)]
pub(super) struct Decoder {
    reader: Box<dyn AnswerReader>,
    answer: ResponseAccumulator,
    /// Half of a character that an event ended with.
    half: HalfCharacter,
    over: bool,
}

impl Decoder {
    /// A decoder for one answer from that place.
    pub fn new(dialect: Dialect, place: ProviderAddress) -> Self {
        Self {
            reader: dialect.protocol().reader(),
            answer: ResponseAccumulator::new(place),
            half: HalfCharacter::default(),
            over: false,
        }
    }

    /// Whether the answer is complete and nothing more needs to be read.
    pub fn is_done(&self) -> bool {
        self.over || self.answer.is_complete()
    }

    /// The data of one event.
    ///
    /// # Errors
    /// [`Error::Malformed`] if it is no JSON object, [`Error::Provider`] if it reports an error.
    pub fn event(&mut self, data: &str) -> Result<Vec<Chunk>, Error> {
        let data = data.trim();
        if self.is_done() || data.is_empty() {
            return Ok(Vec::new());
        }
        // Some servers write the word as JSON.
        if data.trim_matches('"') == "[DONE]" {
            // Only one dialect ends with this word; from other servers it does not prove completeness.
            if self.reader.ends_with_word() || self.answer.has_finish() {
                self.answer.complete();
            }
            return Ok(self.answer.take());
        }
        self.bounded(data)?;
        let value =
            serde_json::from_str(data).or_else(|_| serde_json::from_str(&self.half.mend(data)));
        let value: Value =
            value.map_err(|_| self.answer.malformed(format!("the event `{data}`")))?;
        if let Some(body) = ErrorBody::in_value(&value) {
            return Err(self.answer.reported(body));
        }
        if !value.is_object() {
            self.answer.skip();
            return Ok(self.answer.take());
        }
        self.reader.event(&value, &mut self.answer)?;
        if self.answer.is_capped() {
            self.answer.cap();
        }
        Ok(self.answer.take())
    }

    /// The data of an event that the server itself named `error`.
    pub fn error_event(&mut self, data: &str) -> Error {
        self.answer.reported(ErrorBody::in_body(data))
    }

    /// A whole answer in one JSON document, from a server that does not stream.
    ///
    /// # Errors
    /// As [`Decoder::event`]; [`Error::Truncated`] if the document ends in the middle.
    pub fn document(&mut self, body: &str) -> Result<Vec<Chunk>, Error> {
        self.bounded(body)?;
        // Some servers send the end of a stream after it.
        let trimmed = body.trim();
        let body = trimmed.strip_suffix("[DONE]").map_or(trimmed, |rest| {
            rest.trim_end().trim_end_matches("data:").trim_end()
        });
        let value: Value = serde_json::from_str(body).map_err(|e| {
            if e.is_eof() {
                Error::Truncated {
                    place: self.answer.place().clone(),
                    received: 0,
                    why: "the document is incomplete".into(),
                }
            } else {
                self.answer.malformed(format!("`{body}`"))
            }
        })?;
        if let Some(body) = ErrorBody::in_value(&value) {
            return Err(self.answer.reported(body));
        }
        self.reader.document(&value, &mut self.answer)?;
        self.answer.complete();
        Ok(self.answer.take())
    }

    /// The body is over, for the reason given. It is a success all the same if the model had said that it was finished.
    pub fn ended(
        &mut self,
        cause: impl FnOnce(ProviderAddress, usize) -> Error,
    ) -> Vec<Result<Chunk, Error>> {
        if self.is_done() {
            return Vec::new();
        }
        if self.answer.has_finish() {
            self.answer.complete();
            return self.answer.take().into_iter().map(Ok).collect();
        }
        self.answer.rest();
        let error = cause(self.answer.place().clone(), self.answer.received());
        self.failed(error)
    }

    /// The answer exceeds the limit. Its text so far is kept as an answer cut off by this program.
    pub fn too_long(
        &mut self,
        error: impl FnOnce(ProviderAddress) -> Error,
    ) -> Vec<Result<Chunk, Error>> {
        if self.answer.has_begun() && !self.is_done() {
            self.answer.cap();
            return self.answer.take().into_iter().map(Ok).collect();
        }
        self.ended(|place, _| error(place))
    }

    /// The answer failed: what was held back, then the error.
    pub fn failed(&mut self, error: Error) -> Vec<Result<Chunk, Error>> {
        self.over = true;
        self.answer.rest();
        let rest = self.answer.take().into_iter().map(Ok);
        rest.chain([Err(error)]).collect()
    }

    fn bounded(&self, document: &str) -> Result<(), Error> {
        if is_bounded(document.as_bytes(), MOST_VALUES) {
            Ok(())
        } else {
            Err(self
                .answer
                .malformed(format!("a document of more than {MOST_VALUES} values")))
        }
    }
}
