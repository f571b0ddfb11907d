//! Decodes the events of an answer to chunks, in any dialect, and splits leading thinking such as `<think>…</think>` off.

use serde_json::Value;

use super::accumulator::ResponseAccumulator;
use super::body_text::{MAX_VALUES, is_bounded};
use super::chunk::Chunk;
use super::dialect::{AnswerReader, Dialect};
use super::error::{Error, ProviderAddress};
use super::error_body::ErrorBody;
use super::events::HalfCharacter;

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
        if is_bounded(document.as_bytes(), MAX_VALUES) {
            Ok(())
        } else {
            Err(self
                .answer
                .malformed(format!("a document of more than {MAX_VALUES} values")))
        }
    }
}

/// Tags between which models think, in any case, as chat templates and prompts have them: Qwen and DeepSeek,
/// Claude-like, Gemma, Seed, Mistral, Kimi, Cohere, and gpt-oss, whose answer begins where its channel does.
pub const THINKING_TAGS: [(&str, &str); 11] = [
    ("<think>", "</think>"),
    ("<thinking>", "</thinking>"),
    ("<thought>", "</thought>"),
    ("<reasoning>", "</reasoning>"),
    ("<reflection>", "</reflection>"),
    ("<scratchpad>", "</scratchpad>"),
    ("<seed:think>", "</seed:think>"),
    ("[THINK]", "[/THINK]"),
    ("\u{25c1}think\u{25b7}", "\u{25c1}/think\u{25b7}"),
    ("<|START_THINKING|>", "<|END_THINKING|>"),
    ("<|channel|>analysis<|message|>", FINAL_CHANNEL),
];

const FINAL_CHANNEL: &str = "<|channel|>final<|message|>";

/// White space before a tag, in bytes; who sends more is not about to think.
const MAX_SPACE: usize = 1024;

/// Kind of a piece of content.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum ContentPart {
    /// Between the tags.
    Thought(String),
    /// Everything else.
    Said(String),
}

/// The splitter's state; one per answer.
#[derive(Debug, Default)]
pub(super) struct Splitter {
    place: Place,
    /// Text that cannot be attributed yet: perhaps the beginning of a tag, or white space around one.
    held: String,
}

#[derive(Debug, Default, Clone, Copy)]
enum Place {
    #[default]
    Before,
    /// Until this tag.
    Inside(&'static str),
    /// After the closing tag, where white space is only a separator.
    Gap,
    Open,
}

impl Splitter {
    /// Takes the next piece and gives what is certain.
    pub fn push(&mut self, piece: &str) -> Vec<ContentPart> {
        let mut parts = Vec::new();
        self.held.push_str(piece);
        loop {
            let text = std::mem::take(&mut self.held);
            match self.place {
                Place::Before => {
                    let trimmed = text.trim_start();
                    let mut tags = THINKING_TAGS.iter();
                    let opened = tags.find_map(|(open, close)| {
                        let tag = trimmed.get(..open.len())?;
                        tag.eq_ignore_ascii_case(open)
                            .then(|| (&trimmed[open.len()..], *close))
                    });
                    let mut tags = THINKING_TAGS.iter();
                    if let Some((rest, close)) = opened {
                        self.place = Place::Inside(close);
                        self.held = rest.to_owned();
                    } else if tags.any(|(open, _)| begins(open, trimmed)) && text.len() <= MAX_SPACE
                    {
                        self.held = text;
                        return parts;
                    } else {
                        self.place = Place::Open;
                        self.held = text;
                    }
                }
                Place::Inside(close) => {
                    let Some((thought, rest)) = split_once(&text, close) else {
                        let certain = text.len() - tag_begun(&text, close);
                        self.held = text[certain..].to_owned();
                        add(&mut parts, ContentPart::Thought, &text[..certain]);
                        return parts;
                    };
                    add(&mut parts, ContentPart::Thought, thought);
                    self.place = Place::Gap;
                    self.held = rest.to_owned();
                }
                Place::Gap => {
                    let rest = text.trim_start();
                    if rest.is_empty() {
                        return parts;
                    }
                    self.place = Place::Open;
                    self.held = rest.to_owned();
                }
                Place::Open => {
                    add(&mut parts, ContentPart::Said, &text);
                    return parts;
                }
            }
        }
    }

    /// Whether thinking has ended, and nothing was said after it.
    pub fn is_closed(&self) -> bool {
        match self.place {
            Place::Gap => true,
            // What gpt-oss says on its channel of analysis is never the answer.
            Place::Inside(close) => close == FINAL_CHANNEL,
            Place::Before | Place::Open => false,
        }
    }

    /// The text is over: gives what was held back.
    pub fn end(&mut self) -> Vec<ContentPart> {
        let mut parts = Vec::new();
        let kind = if matches!(self.place, Place::Inside(_)) {
            ContentPart::Thought
        } else {
            ContentPart::Said
        };
        add(&mut parts, kind, &std::mem::take(&mut self.held));
        parts
    }
}

fn add(parts: &mut Vec<ContentPart>, kind: fn(String) -> ContentPart, text: &str) {
    if !text.is_empty() {
        parts.push(kind(text.to_owned()));
    }
}

/// Whether a tag begins with this, in any case.
fn begins(tag: &str, text: &str) -> bool {
    let begin = tag.get(..text.len());
    begin.is_some_and(|begin| begin.eq_ignore_ascii_case(text))
}

/// The text before and after a tag in any case.
fn split_once<'a>(text: &'a str, tag: &str) -> Option<(&'a str, &'a str)> {
    let at = text.to_ascii_lowercase().find(&tag.to_ascii_lowercase())?;
    Some((&text[..at], &text[at + tag.len()..]))
}

/// Length of the longest end of the text that could be the beginning of the closing tag.
fn tag_begun(text: &str, close: &str) -> usize {
    (1..close.len())
        .rev()
        .filter(|n| close.is_char_boundary(*n))
        .find(|&n| {
            let end = text.len().checked_sub(n).and_then(|at| text.get(at..));
            end.is_some_and(|end| end.eq_ignore_ascii_case(&close[..n]))
        })
        .unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Thought and said text, joined, of a text given in pieces of `size` characters.
    fn split(text: &str, size: usize) -> (String, String) {
        let (mut thought, mut said) = (String::new(), String::new());
        let mut splitter = Splitter::default();
        let letters: Vec<char> = text.chars().collect();
        let mut parts: Vec<ContentPart> = letters
            .chunks(size)
            .flat_map(|c| splitter.push(&c.iter().collect::<String>()))
            .collect();
        parts.extend(splitter.end());
        for part in parts {
            match part {
                ContentPart::Thought(t) => thought.push_str(&t),
                ContentPart::Said(t) => said.push_str(&t),
            }
        }
        (thought, said)
    }

    #[test]
    fn whatever_the_pieces_the_split_is_the_same() {
        for (text, thought, said) in [
            ("<think>a < b</think>\n\n{\"x\":1}", "a < b", "{\"x\":1}"),
            ("\n <think>\nö</thin</think>yes", "\nö</thin", "yes"),
            ("<think></think>yes", "", "yes"),
            ("<think>never closed </th", "never closed </th", ""),
            ("<thinking>a</think></thinking>yes", "a</think>", "yes"),
            ("[THINK]a[/THINK] yes", "a", "yes"),
            ("<Think>a</THINK> yes", "a", "yes"),
            ("<scratchpad>a</Scratchpad>yes", "a", "yes"),
            ("◁think▷ä◁/think▷yes", "ä", "yes"),
            ("◁thin air", "", "◁thin air"),
            (
                "<|channel|>analysis<|message|>a<|end|><|start|>assistant<|channel|>final<|message|>yes",
                "a<|end|><|start|>assistant",
                "yes",
            ),
            ("<thin air", "", "<thin air"),
            ("  <thi", "", "  <thi"),
            (
                "  plain <think>not leading</think>",
                "",
                "  plain <think>not leading</think>",
            ),
            ("   ", "", "   "),
            ("<think>a</think>b</think> c", "a", "b</think> c"),
            ("", "", ""),
        ] {
            for size in 1..=12 {
                assert_eq!(
                    split(text, size),
                    (thought.to_owned(), said.to_owned()),
                    "{text:?} in pieces of {size}"
                );
            }
        }
    }

    #[test]
    fn plain_text_is_not_held_back() {
        let mut splitter = Splitter::default();
        assert_eq!(splitter.push("Hello"), [ContentPart::Said("Hello".into())]);
        assert_eq!(splitter.push(" <"), [ContentPart::Said(" <".into())]);
    }
}
