//! The command line: one file a subcommand. Data goes to standard output, words to standard error.

mod inspect;
mod output;

use std::fmt::Display;
use std::path::PathBuf;

/// A terminal workbench for safety-critical driving scenarios.
#[derive(Debug, clap::Parser)]
#[command(name = "nearmiss", version, about)]
pub struct Arguments {
    /// What to do without the workbench.
    #[command(subcommand)]
    pub command: Option<Command>,
    /// Scenario files or folders to open in the workbench [default: the bundled scenarios].
    pub paths: Vec<PathBuf>,
}

/// The headless commands.
#[derive(Debug, clap::Subcommand)]
pub enum Command {
    /// What is in a scenario, and what is wrong with it, with line numbers.
    Inspect(inspect::Inspect),
}

/// What a command ends with.
pub type Outcome = Result<(), Failure>;

/// Why a command did not do what was asked; the message names what, where and what to do.
#[derive(Debug)]
pub struct Failure {
    /// For people.
    pub message: String,
    /// The exit status: 1 for a finding, 2 for a usage or input error, 130 when interrupted.
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
}

/// Runs a headless command.
///
/// # Errors
/// See [`Failure`].
pub fn run(command: &Command) -> Outcome {
    match command {
        Command::Inspect(arguments) => inspect::run(arguments),
    }
}
