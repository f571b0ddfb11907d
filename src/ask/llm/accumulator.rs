//! Assembles an answer from what a dialect's decoder passes on, and the calls of a turn while they arrive in fragments.

use serde_json::Value;

use super::chunk::{Chunk, Finish, MAX_ANSWER_BYTES, Token, Usage};
use super::decoder::{ContentPart, Splitter};
use super::error::{Error, ProviderAddress};
use super::error_body::ErrorBody;
use super::request::{ToolCall, ToolTurn};

/// The answer so far, and the chunks not yet taken.
#[derive(Debug, Default)]
pub(super) struct ResponseAccumulator {
    place: ProviderAddress,
    chunks: Vec<Chunk>,
    model: Option<String>,
    started: bool,
    complete: bool,
    finish: Option<Finish>,
    refusal: String,
    usage: Option<Usage>,
    tokens: Vec<Token>,
    /// Calls of tools so far.
    turn: TurnDraft,
    /// What was said and thought, which the server sees again after calls.
    said: String,
    thought: String,
    content: Splitter,
    /// Reasoning came through a separate channel.
    reasoned: bool,
    /// Text other than white space has come.
    spoke: bool,
    received: usize,
    /// Bytes of reasoning, text and refusal so far.
    bytes: usize,
    /// More came than is read of an answer.
    capped: bool,
    /// Events that said nothing.
    skipped: u32,
}

/// Most characters of the words that servers have for models and for the end of an answer.
const MAX_WORD_LENGTH: usize = 300;

/// Most tokens whose log probabilities are kept; of more, the last ones: answers decide at the end.
const MOST_TOKENS: usize = 20_000;

impl ResponseAccumulator {
    /// An answer from that place, of which nothing has come yet.
    pub fn new(place: ProviderAddress) -> Self {
        Self {
            place,
            ..Self::default()
        }
    }

    /// An event came that says nothing.
    pub fn skip(&mut self) {
        self.skipped += 1;
    }

    /// Where the answer comes from.
    pub fn place(&self) -> &ProviderAddress {
        &self.place
    }

    /// The response does not follow this protocol.
    pub fn malformed(&self, what: String) -> Error {
        Error::Malformed {
            place: self.place.clone(),
            what,
        }
    }

    /// A whole document came that holds no answer.
    pub fn no_answer(&self, document: &Value) -> Error {
        self.malformed(format!("no answer in `{document}`"))
    }

    /// The server reports an error inside the answer.
    pub fn reported(&self, body: ErrorBody) -> Error {
        Error::Provider {
            place: self.place.clone(),
            code: body.code.or(body.kind),
            message: body.message,
        }
    }

    /// The model that the server says it uses; the first name holds.
    pub fn model(&mut self, name: Option<&str>) {
        if self.model.is_none() {
            self.model = name.filter(|n| !n.is_empty()).map(shortened);
        }
    }

    /// A piece of reasoning from a separate channel.
    pub fn reason(&mut self, text: &str) {
        if !text.is_empty() {
            self.reasoned = true;
            self.push(Chunk::Reasoning, text.to_owned());
        }
    }

    /// A piece of the answer; reasoning in leading tags is split off.
    pub fn push_text(&mut self, text: &str) {
        let parts = self.content.push(text);
        self.sort(parts);
    }

    /// Names the tool of a call, by its number in the turn.
    pub fn call(&mut self, number: u64, id: &str, name: &str) {
        let (id, name) = (shortened(id), shortened(name));
        self.turn.name_call(number, &id, &name);
    }

    /// The number of the call that a server means by this number and id: another one than the call of that number if
    /// that has another id.
    pub fn call_number(&self, number: u64, id: &str) -> u64 {
        self.turn.call_number(number, &shortened(id))
    }

    /// A fragment of the arguments of a call.
    pub fn call_arguments(&mut self, number: u64, fragment: &str) {
        let fitting = self.fitting(fragment);
        self.received += fitting.chars().count();
        self.turn.arguments(number, fitting);
    }

    /// All arguments of a call, in the place of fragments.
    pub fn complete_call(&mut self, number: u64, arguments: &str) {
        let fitting = self.fitting(arguments);
        self.received += fitting.chars().count();
        self.turn.complete_call(number, fitting);
    }

    /// How many tools are called so far.
    pub fn calls(&self) -> u64 {
        self.turn.len()
    }

    /// A part of the turn that the server has to see again as it is, should it call tools.
    pub fn echo(&mut self, part: Value) {
        let text = part.to_string();
        if self.fitting(&text).len() == text.len() {
            self.turn.echo(part);
        }
    }

    /// A piece of a refusal.
    pub fn refuse(&mut self, text: &str) {
        let text = self.fitting(text);
        self.received += text.chars().count();
        self.refusal.push_str(text);
    }

    /// The usage so far: servers repeat it, always counting from the beginning, so the last one holds.
    pub fn usage(&mut self, usage: Usage) {
        self.usage = Some(usage);
    }

    /// Tokens with their log probabilities, in their order.
    pub fn tokens(&mut self, tokens: Vec<Token>) {
        self.tokens.extend(tokens);
        if self.tokens.len() > 2 * MOST_TOKENS {
            self.tokens.drain(..self.tokens.len() - MOST_TOKENS);
        }
    }

    /// Why the model stopped.
    pub fn finish(&mut self, finish: Finish) {
        self.finish = Some(match finish {
            Finish::Blocked(text) => Finish::Blocked(shortened(&text)),
            Finish::Refusal(text) => Finish::Refusal(shortened(&text)),
            Finish::Other(text) => Finish::Other(shortened(&text)),
            other => other,
        });
    }

    /// Whether the model said why it stopped.
    pub fn has_finish(&self) -> bool {
        self.finish.is_some()
    }

    /// Whether more came than is read of an answer.
    pub fn is_capped(&self) -> bool {
        self.capped
    }

    /// Whether anything was said.
    pub fn has_begun(&self) -> bool {
        self.received > 0
    }

    /// No more of the answer is read.
    pub fn cap(&mut self) {
        self.capped = true;
        self.complete();
    }

    /// The server says that nothing more comes.
    pub fn complete(&mut self) {
        if self.complete {
            return;
        }
        self.rest();
        self.complete = true;
        let finish = match self.finish.take() {
            _ if self.capped => Finish::TooLong,
            Some(Finish::Stop) | None if !self.refusal.is_empty() => {
                Finish::Refusal(std::mem::take(&mut self.refusal))
            }
            Some(Finish::Refusal(words)) if words.is_empty() => {
                Finish::Refusal(std::mem::take(&mut self.refusal))
            }
            Some(Finish::Stop | Finish::ToolCalls) | None if !self.turn.is_empty() => {
                Finish::ToolCalls
            }
            // So servers end turns that are to have calls.
            Some(Finish::ToolCalls) => Finish::Other("tool_calls".into()),
            Some(Finish::Stop) | None if !self.spoke && self.content.is_closed() => {
                Finish::Thinking
            }
            Some(Finish::Stop) if !self.spoke => Finish::Blank,
            Some(finish) => finish,
            None => Finish::Other("unstated".into()),
        };
        self.start();
        if self.skipped > 0 {
            let events = match self.skipped {
                1 => "1 event of the answer says nothing and is skipped".to_string(),
                n => format!("{n} events of the answer say nothing and are skipped"),
            };
            self.chunks.push(Chunk::Note(events));
        }
        if !self.tokens.is_empty() {
            let tokens = std::mem::take(&mut self.tokens);
            self.chunks.push(Chunk::LogProbabilities(tokens));
        }
        if finish == Finish::ToolCalls {
            let turn = std::mem::take(&mut self.turn);
            let (said, thought) = (&mut self.said, &mut self.thought);
            let turn = turn.turn(std::mem::take(said), std::mem::take(thought));
            self.chunks.push(Chunk::ToolCalls(turn));
        }
        self.chunks.push(Chunk::Finished(finish));
    }

    /// Whether [`ResponseAccumulator::complete`] was called.
    pub fn is_complete(&self) -> bool {
        self.complete
    }

    /// Releases held-back content: text that might have become a tag, and the usage.
    pub fn rest(&mut self) {
        let parts = self.content.end();
        self.sort(parts);
        if let Some(usage) = self.usage.take() {
            self.start();
            let (usage, dropped) = usage.plausible();
            if !dropped.is_empty() {
                self.chunks.push(Chunk::Note(format!(
                    "the server reports implausible {}; not counted",
                    dropped.join(", ")
                )));
            }
            self.chunks.push(Chunk::Usage(usage));
        }
    }

    /// Characters of reasoning, text and refusal so far.
    pub fn received(&self) -> usize {
        self.received
    }

    /// The chunks since the last call.
    pub fn take(&mut self) -> Vec<Chunk> {
        // The first event may not name the model yet, so the start waits for a name or a chunk.
        if self.model.is_some() {
            self.start();
        }
        std::mem::take(&mut self.chunks)
    }

    fn sort(&mut self, parts: Vec<ContentPart>) {
        for part in parts {
            match part {
                // Already received through a separate channel.
                ContentPart::Thought(_) if self.reasoned => {}
                ContentPart::Thought(text) => self.push(Chunk::Reasoning, text),
                ContentPart::Said(text) => {
                    self.spoke |= !text.trim().is_empty();
                    self.push(Chunk::Text, text);
                }
            }
        }
    }

    fn push(&mut self, kind: fn(String) -> Chunk, mut text: String) {
        text.truncate(self.fitting(&text).len());
        if text.is_empty() {
            return;
        }
        self.received += text.chars().count();
        self.start();
        let piece = kind(text);
        match &piece {
            Chunk::Reasoning(text) => self.thought.push_str(text),
            Chunk::Text(text) => self.said.push_str(text),
            _ => {}
        }
        self.chunks.push(piece);
    }

    /// As much of a text as still belongs to the answer.
    fn fitting<'a>(&mut self, text: &'a str) -> &'a str {
        let fitting = &text[..text.floor_char_boundary(MAX_ANSWER_BYTES - self.bytes)];
        self.bytes += fitting.len();
        self.capped |= fitting.len() < text.len();
        fitting
    }

    fn start(&mut self) {
        if !self.started {
            self.started = true;
            let model = self.model.clone();
            self.chunks.push(Chunk::Started { model });
        }
    }
}

/// A word of the server's, no longer than words are.
fn shortened(text: &str) -> String {
    text.chars().take(MAX_WORD_LENGTH).collect()
}

/// Most calls of one turn that are read.
pub const MAX_CALLS: usize = 64;

/// Numbers of calls whose server gave them the number of another one.
const REUSED_NUMBERS: u64 = 1 << 32;

/// Calls so far, in the order in which they began.
#[derive(Debug, Default)]
pub(super) struct TurnDraft {
    /// Under the server's number, or one of [`REUSED_NUMBERS`] and more where that number had been taken by another call.
    calls: Vec<(u64, ToolCall)>,
    echo: Vec<Value>,
}

impl TurnDraft {
    /// The call with this number; the first mention begins it. `None` if there are too many.
    fn call(&mut self, number: u64) -> Option<&mut ToolCall> {
        let place = self.calls.iter().position(|(known, _)| *known == number);
        let place = match place {
            Some(place) => place,
            None if self.calls.len() == MAX_CALLS => return None,
            None => {
                let call = ToolCall {
                    id: String::new(),
                    name: String::new(),
                    arguments: String::new(),
                };
                self.calls.push((number, call));
                self.calls.len() - 1
            }
        };
        Some(&mut self.calls[place].1)
    }

    /// Under which number the call is that a server names by a number and an id: calls with the same number but another id
    /// are another one, and fragments without an id belong to the newest of them.
    pub fn call_number(&self, number: u64, id: &str) -> u64 {
        let same = |known: u64| {
            known == number || known >= REUSED_NUMBERS && known % REUSED_NUMBERS == number
        };
        let mut calls = self.calls.iter().filter(|(known, _)| same(*known));
        let named = |call: &ToolCall| id.is_empty() || call.id.is_empty() || call.id == id;
        match calls.clone().rev().find(|(_, call)| named(call)) {
            Some((known, _)) => *known,
            None if calls.next().is_none() => number,
            None => REUSED_NUMBERS * (1 + self.calls.len() as u64) + number,
        }
    }

    /// Names a call. Servers say a name once or, some, with every fragment.
    pub fn name_call(&mut self, number: u64, id: &str, name: &str) {
        if let Some(call) = self.call(number) {
            if !id.is_empty() {
                id.clone_into(&mut call.id);
            }
            if !name.is_empty() {
                name.clone_into(&mut call.name);
            }
        }
    }

    /// A fragment of a call's arguments.
    pub fn arguments(&mut self, number: u64, fragment: &str) {
        if let Some(call) = self.call(number) {
            call.arguments.push_str(fragment);
        }
    }

    /// The whole arguments of a call, whatever fragments said.
    pub fn complete_call(&mut self, number: u64, arguments: &str) {
        if let Some(call) = self.call(number) {
            arguments.clone_into(&mut call.arguments);
        }
    }

    /// A part that the server has to see again.
    pub fn echo(&mut self, part: Value) {
        self.echo.push(part);
    }

    /// Whether a tool is called.
    pub fn is_empty(&self) -> bool {
        self.calls.is_empty()
    }

    /// How many calls there are.
    pub fn len(&self) -> u64 {
        self.calls.len() as u64
    }

    /// The turn; calls without an id get one, by which their results are found.
    pub fn turn(self, text: String, thought: String) -> ToolTurn {
        let calls = self
            .calls
            .into_iter()
            .enumerate()
            .map(|(place, (_, mut call))| {
                if call.id.is_empty() {
                    call.id = format!("call_{place}");
                }
                call
            });
        ToolTurn {
            text,
            thought,
            calls: calls.collect(),
            echo: self.echo,
        }
    }
}
