//! Streams an answer to standard error.

use std::io::{IsTerminal, Write};

use crate::output;
use nearmiss_ask::llm::Chunk;
use nearmiss_study::evaluation::{Event, tool_rounds};

/// Streams the words of an answer to standard error, where a person is watching.
pub(super) struct AnswerPrinter {
    on: bool,
    /// Whether what was written last does not end its line.
    open: bool,
    part: Option<Part>,
}

/// The text that a piece belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Part {
    Reasoning,
    Answer,
}

impl AnswerPrinter {
    /// Nothing is streamed unless that is wanted.
    pub(super) fn new(wanted: bool) -> Self {
        Self {
            on: wanted && std::io::stderr().is_terminal(),
            open: false,
            part: None,
        }
    }

    /// Ends the line, so that what follows has its own.
    pub(super) fn end(&mut self) {
        if std::mem::take(&mut self.open) {
            output::say("");
        }
    }

    /// Says what happens; what people must know is said in any case.
    pub(super) fn hear(&mut self, event: Event) {
        match event {
            Event::Chunk(Chunk::Note(note)) => {
                self.say(&format!("nearmiss: {}", output::visible(&note)))
            }
            Event::Awaiting(run) => self.say(&format!(
                "nearmiss: another program is asking the same question (run {run}); waiting for its answer"
            )),
            Event::Chunk(Chunk::Retrying { attempt, wait, why }) if self.on => {
                let why = output::visible(&why);
                self.say(&format!(
                    "{why}; try {attempt} in {:.0} s",
                    wait.as_secs_f64()
                ));
            }
            Event::Tools(round) if self.on => {
                for line in tool_rounds::lines(&round) {
                    self.say(&format!("▸ {}", output::visible(&line)));
                }
            }
            Event::Chunk(Chunk::Reasoning(text)) if self.on => self.piece(&text, Part::Reasoning),
            Event::Chunk(Chunk::Text(text)) if self.on => self.piece(&text, Part::Answer),
            _ => {}
        }
    }

    /// Writes a separate line.
    fn say(&mut self, words: &str) {
        self.end();
        output::say(words);
    }

    /// A piece as it is; the terminal breaks the lines.
    fn piece(&mut self, text: &str, part: Part) {
        if part == Part::Answer && self.part == Some(Part::Reasoning) {
            self.say("── answer ──");
        }
        self.part = Some(part);
        self.open = !text.ends_with('\n');
        let mut err = std::io::stderr().lock();
        // Errors of a closed standard error are ignored.
        let _ = write!(err, "{}", output::visible(text)).and_then(|()| err.flush());
    }
}
