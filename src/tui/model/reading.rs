//! How the reasoning pane shows answers.

use super::JobId;
use super::{Column, Model};
use crate::action::Action;
use crate::widgets::long_text::ReadingMode;

/// How answers are read.
#[derive(Debug, Default)]
pub struct ReadingView {
    /// As they were sent, with all markup.
    pub raw: bool,
    /// With their JSON.
    pub unfold: bool,
    /// The question whose answer the reader scrolled while it was streamed.
    pub scrolled: Option<JobId>,
}

impl Model {
    /// How answers are shown now, with the key that unfolds JSON.
    #[must_use]
    pub fn reading_mode(&self) -> ReadingMode {
        ReadingMode {
            raw: self.reading.raw,
            unfold: self.reading.unfold,
            hint: format!(" · {} unfolds", self.look.key(Action::UnfoldJson)),
        }
    }

    /// Shows answers as they were sent, or rendered again.
    pub fn toggle_raw(&mut self) {
        self.reading.raw = !self.reading.raw;
        self.say(if self.reading.raw {
            "answers as sent"
        } else {
            "answers rendered as Markdown"
        });
    }

    /// Unfolds the JSON of answers, or folds it again.
    pub fn toggle_json(&mut self) {
        self.reading.unfold = !self.reading.unfold;
        if self.reading.raw {
            self.say("raw answers are never folded");
        }
    }

    /// Notes that the reader scrolls the shown answer.
    pub fn note_scrolled(&mut self) {
        let column = self.answers.column().filter(|c| c.is_running());
        if let Some(ask) = column.and_then(|c| c.ask) {
            self.reading.scrolled = Some(ask);
        }
    }

    /// The stream of a question ends: a reader who scrolled stays where they are, for any other the answer is shown from
    /// its beginning, where reading starts.
    pub fn end_stream(&mut self, ask: JobId) {
        let shown = self.answers.column().and_then(|c: &Column| c.ask);
        if shown != Some(ask) {
            return;
        }
        let stays = self.reading.scrolled.take_if(|id| *id == ask).is_some();
        if !stays {
            self.answers.scroll = Some(0);
        } else if self.answers.scroll.is_none() {
            let extent = self.drawn.extent(super::Pane::Reasoning);
            self.answers.scroll = Some(extent.top);
        }
    }
}
