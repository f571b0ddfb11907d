//! Crash reports of every command and the workbench: where they are written, and what they must not contain.

use std::path::Path;

use nearmiss_ask::llm::without_secrets;
use nearmiss_base::system::activity::{ActivityGuard, doing};
use nearmiss_base::system::crash;
use nearmiss_settings::Folders;

/// Makes every panic of the program write a report, say so in one sentence, and end it with status 101.
pub fn report_panics() {
    let folder = Folders::find().ok().map(|folders| folders.crashes());
    crash::report_panics(folder, redacted);
}

/// The command that was given, as what is being done; options and their values may say too much for a sentence.
pub fn running() -> ActivityGuard {
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
