//! Which questions of a batch are asked: those still open, or those without a verdict.

use nearmiss_store::{Item, ItemState};

/// Selection of a batch's questions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Selection {
    /// Those that have no whole answer, without those that the server cut off: it would do so again.
    Open,
    /// Those to which no whole answer came, with those that were cut off, and whole answers without a verdict.
    Failed,
    /// All of them, also those with a whole answer: to look at them, not to ask them.
    All,
}

impl Selection {
    /// Whether a question is among them.
    #[must_use]
    pub fn selects(self, item: &Item) -> bool {
        self.has(item.state) || self.asks_anew(item)
    }

    /// Whether the question is asked although the store has a whole answer to it, since no verdict could be read there.
    #[must_use]
    pub fn asks_anew(self, item: &Item) -> bool {
        self == Self::Failed && item.state == ItemState::Answered && item.unparsed
    }

    /// Whether questions in this state are among them, leaving aside whole answers without a verdict.
    #[must_use]
    pub fn has(self, state: ItemState) -> bool {
        use ItemState::{Answered, Failed, Truncated, Unaskable, Waiting};
        match (self, state) {
            (Self::All, _) => true,
            (_, Answered) => false,
            (Self::Open, Truncated) | (Self::Failed, Waiting) => false,
            (Self::Open, Waiting | Failed | Unaskable) => true,
            (Self::Failed, Failed | Truncated | Unaskable) => true,
        }
    }
}
