//! Which questions of a batch are asked: those still open, or those that failed.

use crate::store::ItemState;

/// Selection of a batch's questions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Selection {
    /// Those that have no whole answer, without those that the server cut off: it would do so again.
    Open,
    /// Those to which no whole answer came, with those that were cut off.
    Failed,
}

impl Selection {
    /// Whether a question is among them.
    #[must_use]
    pub fn has(self, state: ItemState) -> bool {
        use ItemState::{Answered, Failed, Truncated, Unaskable, Waiting};
        match (self, state) {
            (_, Answered) => false,
            (Self::Open, Truncated) | (Self::Failed, Waiting) => false,
            (Self::Open, Waiting | Failed | Unaskable) => true,
            (Self::Failed, Failed | Truncated | Unaskable) => true,
        }
    }
}
