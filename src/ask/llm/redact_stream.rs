//! Redacts secrets in the two streamed texts of an answer.

use super::chunk::Chunk;
use super::redaction::{Redactor, Secrets};

/// Takes secrets out of the two texts of an answer.
#[derive(Debug, Default)]
pub(super) struct Redactors {
    reasoning: Redactor,
    text: Redactor,
}

impl Redactors {
    pub fn new(secrets: &Secrets) -> Self {
        Self {
            reasoning: Redactor::new(secrets),
            text: Redactor::new(secrets),
        }
    }

    /// A piece of one of the texts, without secrets; nothing if all of it is held back. Other chunks are left alone.
    pub fn piece(&mut self, chunk: Chunk) -> Option<Chunk> {
        match chunk {
            Chunk::Reasoning(text) => some(self.reasoning.push(&text)).map(Chunk::Reasoning),
            Chunk::Text(text) => some(self.text.push(&text)).map(Chunk::Text),
            other => Some(other),
        }
    }

    /// Returns text held back at the end of a stream; call until it returns `None`.
    pub fn held(&mut self) -> Option<Chunk> {
        let reasoning = some(self.reasoning.cut()).map(Chunk::Reasoning);
        reasoning.or_else(|| some(self.text.cut()).map(Chunk::Text))
    }
}

fn some(text: String) -> Option<String> {
    (!text.is_empty()).then_some(text)
}
