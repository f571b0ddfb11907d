//! The state of an answer: one rule for all tables of what counts, and as what.

use strum::{IntoStaticStr, VariantArray};

use super::{Run, RunState};

/// How the end of an answer is called that this program cut off because of its size.
pub const TOO_LONG: &str = "too_long";

/// State of an answer, or of an attempt to get one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "lowercase")]
pub enum AnswerState {
    /// The answer is whole, and a verdict was read in it.
    Answered,
    /// The answer is whole, and no verdict could be read in it.
    Unparsed,
    /// The answer was cut off: by the token limit, by the size that is read of one, or it is blank.
    Truncated,
    /// A filter of the server stopped the answer or blocked the question.
    Filtered,
    /// No whole answer came.
    Failed,
    /// It was cancelled.
    Cancelled,
    /// The program ended while the answer arrived.
    Interrupted,
    /// The answer is arriving, or is awaited.
    #[default]
    Waiting,
    /// Another attempt at the same question counts in its place; what it cost still counts.
    Superseded,
}

nearmiss_record::named!(AnswerState, "state");

/// What an answer is counted as.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CountedAs {
    /// A yes or no, right or wrong.
    Verdict,
    /// An answer without a verdict.
    Unparsed,
    /// A question without a whole answer.
    Failed,
    /// A question that is still to be asked.
    Unasked,
    /// Nothing: another attempt is counted.
    Nothing,
}

impl AnswerState {
    /// The state of one run: where it stands, why its model stopped, and whether a verdict was read.
    #[must_use]
    pub fn of_run(state: RunState, finish: Option<&str>, has_verdict: bool) -> Self {
        match (state, finish) {
            (RunState::Answered, _) if has_verdict => Self::Answered,
            (RunState::Answered, _) => Self::Unparsed,
            (RunState::Truncated, Some("content_filter" | "blocked")) => Self::Filtered,
            (RunState::Truncated, _) => Self::Truncated,
            (RunState::Failed, _) => Self::Failed,
            (RunState::Cancelled, _) => Self::Cancelled,
            (RunState::Interrupted, _) => Self::Interrupted,
            (RunState::Running, _) => Self::Waiting,
        }
    }

    /// The state of a run as the store has it; whether another one counts in its place is not known of one alone.
    #[must_use]
    pub fn from_run(run: &Run) -> Self {
        let (finish, verdict) = (run.ending.finish.as_deref(), &run.ending.verdict);
        Self::of_run(run.ending.state, finish, verdict.is_some())
    }

    /// What it is counted as. A cut answer is a failed question, whatever can be read in what there is of it: the rest
    /// could have said something else, and how much arrives depends on the limit, not on the model.
    #[must_use]
    pub fn counted_as(self) -> CountedAs {
        match self {
            Self::Answered => CountedAs::Verdict,
            Self::Unparsed => CountedAs::Unparsed,
            Self::Truncated | Self::Filtered | Self::Failed => CountedAs::Failed,
            Self::Cancelled | Self::Interrupted | Self::Waiting => CountedAs::Unasked,
            Self::Superseded => CountedAs::Nothing,
        }
    }

    /// Why a run that ended like this has no verdict that counts, where it says nothing itself.
    #[must_use]
    pub fn reason(self, finish: Option<&str>) -> &'static str {
        match (self, finish) {
            (Self::Truncated, Some("length")) => "the answer ran into the token limit",
            (Self::Truncated, Some(TOO_LONG)) => "the answer was too long to be read whole",
            (Self::Truncated, Some("blank")) => "the answer is blank",
            (Self::Truncated, _) => "the server ended the answer before it was whole",
            (Self::Filtered, Some("blocked")) => "the server's filter blocked the question",
            (Self::Filtered, _) => "the server's content filter stopped the answer",
            (Self::Cancelled, _) => "it was cancelled",
            (Self::Interrupted, _) => "the program ended while the answer arrived",
            (Self::Waiting, _) => "the answer has not arrived yet",
            (Self::Unparsed, _) => "no verdict was found in the answer",
            (Self::Answered | Self::Failed | Self::Superseded, _) => "no whole answer came",
        }
    }
}

/// Which of several attempts at one question counts: a whole answer before one that was cut or failed, these before
/// what was cancelled or interrupted; of equals the one that entered the store last, see [`super::SUPERSEDED`].
#[must_use]
pub fn attempt_rank(state: RunState) -> u8 {
    match state {
        RunState::Answered => 2,
        RunState::Truncated | RunState::Failed => 1,
        RunState::Running | RunState::Interrupted | RunState::Cancelled => 0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cut_answer_is_a_failed_question_whatever_it_says() {
        for (state, finish, verdict, expected, counted) in [
            (
                RunState::Answered,
                Some("stop"),
                true,
                "answered",
                CountedAs::Verdict,
            ),
            (
                RunState::Answered,
                Some("refusal"),
                false,
                "unparsed",
                CountedAs::Unparsed,
            ),
            (
                RunState::Truncated,
                Some("length"),
                true,
                "truncated",
                CountedAs::Failed,
            ),
            (
                RunState::Truncated,
                Some("blank"),
                false,
                "truncated",
                CountedAs::Failed,
            ),
            (
                RunState::Truncated,
                Some("content_filter"),
                true,
                "filtered",
                CountedAs::Failed,
            ),
            (RunState::Failed, None, true, "failed", CountedAs::Failed),
            (
                RunState::Cancelled,
                None,
                false,
                "cancelled",
                CountedAs::Unasked,
            ),
            (
                RunState::Interrupted,
                None,
                true,
                "interrupted",
                CountedAs::Unasked,
            ),
            (
                RunState::Running,
                None,
                false,
                "waiting",
                CountedAs::Unasked,
            ),
        ] {
            let found = AnswerState::of_run(state, finish, verdict);
            assert_eq!((found.name(), found.counted_as()), (expected, counted));
        }
    }
}
