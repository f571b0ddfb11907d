//! How a command ends: its exit status, and the message that goes with it.

use std::fmt::Display;

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

    /// Says on standard error what went wrong.
    pub fn say(&self) {
        output::say(&format!("nearmiss: {}", self.message));
    }
}
