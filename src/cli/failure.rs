//! How a command ends: its exit status and message, or a report of a crash.

use std::fmt::Display;
use std::path::Path;

use nearmiss_ask::llm::without_secrets;
use nearmiss_base::system::activity::{ActivityGuard, doing};
use nearmiss_base::system::{self, crash};
use nearmiss_settings::Folders;

use super::interrupt::INTERRUPTED;
use super::output;

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

/// Makes every panic of the program write a report, say so in one sentence, and end it with status 101.
pub fn report_panics() {
    let folder = Folders::find().ok().map(|folders| folders.crashes());
    crash::report_panics(folder, redacted);
}

/// The command that was given, as what is being done; options and their values may say too much for a sentence.
pub fn note_command() -> ActivityGuard {
    let command = std::env::args_os().nth(1).unwrap_or_default();
    let command = command.to_string_lossy();
    let doing_it = doing(format!("running `{command}`"));
    #[cfg(debug_assertions)]
    panic_if_asked(&command);
    doing_it
}

/// Keys of the environment, of `.env` files and in what looks like one are taken out.
fn redacted(text: &str) -> String {
    let config = Folders::find().map(|folders| folders.config);
    let folders = [Path::new("."), config.as_deref().unwrap_or(Path::new("."))];
    without_secrets(text, &folders)
}

/// Lets a test see what a panic leaves: in the main thread, in a worker's, or in a task's.
#[cfg(debug_assertions)]
fn panic_if_asked(command: &str) {
    let Ok(place) = std::env::var("NEARMISS_TEST_PANIC") else {
        return;
    };
    let key = std::env::var("OPENAI_API_KEY").unwrap_or_default();
    let fail = move || panic!("a test asked for this panic, with {key}");
    match (command, place.as_str()) {
        ("models", "main") => fail(),
        ("models", "worker") => rayon::scope(|scope| scope.spawn(move |_| fail())),
        ("models", "task") => {
            let runtime = tokio::runtime::Runtime::new();
            let _ = runtime.map(|runtime| {
                runtime.block_on(async { tokio::spawn(async move { fail() }).await })
            });
        }
        _ => {}
    }
}
