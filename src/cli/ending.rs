//! How a command ends: its exit status and message, a report of a crash, or Ctrl-C, SIGTERM and a terminal that closes.
//!
//! A command with work to finish polls a flag and ends by itself. What does not end in time (a huge file being read, a
//! server name being resolved) is killed: rows on standard output are whole lines, and unfinished files are removed.

use std::fmt::Display;
use std::io;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::channel;
use std::sync::{Arc, Once, OnceLock};
use std::time::Duration;

use nearmiss_ask::llm::without_secrets;
use nearmiss_base::system::crash::{ActivityGuard, doing};
use nearmiss_base::system::{self, crash, end_process_groups, remove_unfinished};
use nearmiss_settings::Folders;
use tokio::sync::Notify;

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

/// The exit status of an interrupted program.
const INTERRUPTED: u8 = 130;

/// How long a command may take to finish, a little less than its last words need.
pub const GRACE: Duration = Duration::from_millis(500);

/// After this a command that has not finished is ended. Without optimisation everything takes some ten times as long.
const LATEST: Duration = Duration::from_millis(if cfg!(debug_assertions) { 3000 } else { 850 });

/// How long the last line on standard output is waited for.
const LAST_LINE: Duration = Duration::from_millis(100);

/// Flags set by the signals.
struct SignalFlags {
    flag: Arc<AtomicBool>,
    /// Whether the command has something to finish.
    tidies: AtomicBool,
    woken: Notify,
}

fn signal_flags() -> &'static SignalFlags {
    static HEARD: OnceLock<SignalFlags> = OnceLock::new();
    HEARD.get_or_init(|| SignalFlags {
        flag: Arc::default(),
        tidies: AtomicBool::new(false),
        woken: Notify::new(),
    })
}

/// A flag that the first signal sets; the second one ends the program at once.
///
/// With `tidy` false there is nothing to finish, and the first one ends it.
pub fn interrupted(tidy: bool) -> Arc<AtomicBool> {
    signal_flags().tidies.fetch_or(tidy, Ordering::SeqCst);
    Arc::clone(&signal_flags().flag)
}

/// Waits for the first signal; the program then has [`GRACE`] to finish.
pub async fn signal() {
    let heard = signal_flags();
    heard.tidies.store(true, Ordering::SeqCst);
    loop {
        let woken = heard.woken.notified();
        if heard.flag.load(Ordering::SeqCst) {
            return;
        }
        woken.await;
    }
}

/// Begins to listen, once in a process; where the system refuses, a signal does what it does to any program.
pub fn listen() {
    static LISTENING: Once = Once::new();
    LISTENING.call_once(listen_on);
}

#[cfg(unix)]
fn listen_on() {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGQUIT, SIGTERM};
    // SIGHUP comes when the terminal or its connection has gone, SIGQUIT from Ctrl-\.
    let obeyed = [SIGHUP, SIGQUIT].into_iter().filter(|s| !is_ignored(*s));
    let signals = [SIGINT, SIGTERM].into_iter().chain(obeyed);
    let Ok(mut signals) = signal_hook::iterator::Signals::new(signals) else {
        return;
    };
    std::thread::spawn(move || {
        let heard = signal_flags();
        for _ in signals.forever() {
            if heard.flag.swap(true, Ordering::SeqCst) || !heard.tidies.load(Ordering::SeqCst) {
                end();
            }
            heard.woken.notify_waiters();
            std::thread::spawn(|| {
                std::thread::sleep(LATEST);
                end();
            });
        }
    });
}

/// Whether the parent process wants this one to go on when this signal comes, as `nohup` does. Where the system does
/// not tell, that may be so for SIGHUP.
#[cfg(unix)]
fn is_ignored(signal: i32) -> bool {
    let ignored = std::fs::read_to_string("/proc/self/status")
        .ok()
        .as_deref()
        .and_then(|status| {
            let mask = status
                .lines()
                .find_map(|line| line.strip_prefix("SigIgn:"))?;
            u64::from_str_radix(mask.trim(), 16).ok()
        });
    match ignored {
        Some(mask) => mask >> (signal - 1) & 1 == 1,
        None => signal == signal_hook::consts::SIGHUP,
    }
}

#[cfg(not(unix))]
fn listen_on() {
    use signal_hook::consts::{SIGINT, SIGTERM};
    let heard = signal_flags();
    for signal in [SIGINT, SIGTERM] {
        // The order matters: the first signal must find the flag unset.
        let flag = || Arc::clone(&heard.flag);
        let _ =
            signal_hook::flag::register_conditional_shutdown(signal, INTERRUPTED.into(), flag());
        let _ = signal_hook::flag::register(signal, flag());
    }
}

/// Ends and removes what is not to outlive the program: other programs that it started, and standard input, where it was kept.
pub fn clean_up() {
    end_process_groups();
    remove_unfinished();
}

/// Ends the program as interrupted, whatever it is doing.
fn end() -> ! {
    let (sender, last_line) = channel();
    std::thread::spawn(move || {
        // Until it is free a row is being written; from now on none is begun.
        let out = io::stdout().lock();
        output::say("nearmiss: interrupted");
        // The receiver is gone where that took too long.
        let _ = sender.send(());
        std::thread::sleep(LATEST);
        drop(out);
    });
    // A reader that has stopped reading is not waited for.
    let _ = last_line.recv_timeout(LAST_LINE);
    end_process_groups();
    remove_unfinished();
    std::process::exit(INTERRUPTED.into())
}
