//! How a command ends: its exit status, and the message that goes with it.

use std::fmt::Display;

use super::interrupt::INTERRUPTED;
use super::output;
use nearmiss_base::system;

/// Result of a command.
pub type Outcome = Result<(), Failure>;

/// Why a command failed; the message names what, where and what to do.
#[derive(Debug)]
pub struct Failure {
    /// For people.
    pub message: String,
    /// The exit status: 1 for a finding, 2 for a usage or input error, 130 when interrupted. A panic ends with 101.
    pub status: u8,
}

impl Failure {
    /// An input or usage error.
    pub fn input(error: impl Display) -> Self {
        Self {
            message: error.to_string(),
            status: 2,
        }
    }

    /// The command has done its work, and the answer is a finding: differences, or some cases that failed.
    pub fn finding(message: impl Display) -> Self {
        Self {
            message: message.to_string(),
            status: 1,
        }
    }

    /// What the system said about a file, or about what else is named.
    pub fn system(name: impl Display, error: &std::io::Error) -> Self {
        Self::input(format!("{name}: {}", system::error_text(error)))
    }

    /// The user has ended it; `kept` says what that leaves, and how it goes on: nothing where there is nothing to say.
    pub fn interrupted(kept: &str) -> Self {
        Self::interrupted_after("", kept)
    }

    /// The same after some of the work.
    pub fn interrupted_after(done: &str, kept: &str) -> Self {
        let semicolon = if kept.is_empty() { "" } else { "; " };
        Self {
            message: format!("interrupted{done}{semicolon}{kept}"),
            status: INTERRUPTED,
        }
    }

    /// Whether the user has ended it.
    pub fn is_interrupted(&self) -> bool {
        self.status == INTERRUPTED
    }

    /// Says on standard error what went wrong.
    pub fn say(&self) {
        output::say(&format!("nearmiss: {}", self.message));
    }
}
