//! Ctrl-C, SIGTERM, and a terminal that closes: every headless command ends within a second and keeps its finished work.
//!
//! A command with work to finish polls a flag and ends by itself. What does not end in time (a huge file being read, a
//! server name being resolved) is killed: rows on standard output are whole lines, and unfinished files are removed.

use std::io;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::channel;
use std::sync::{Arc, Once, OnceLock};
use std::time::Duration;

use tokio::sync::Notify;

use super::output;
use nearmiss_base::system::{end_process_groups, remove_unfinished};

/// The exit status of an interrupted program.
pub const INTERRUPTED: u8 = 130;

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

fn heard() -> &'static SignalFlags {
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
    heard().tidies.fetch_or(tidy, Ordering::SeqCst);
    Arc::clone(&heard().flag)
}

/// Waits for the first signal; the program then has [`GRACE`] to finish.
pub async fn signal() {
    let heard = heard();
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
        let heard = heard();
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

/// Whether whoever started the program wants it to go on when this signal comes, as `nohup` does. Where the system does
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
    let heard = heard();
    for signal in [SIGINT, SIGTERM] {
        // The order matters: the first signal must find the flag unset.
        let flag = || Arc::clone(&heard.flag);
        let _ =
            signal_hook::flag::register_conditional_shutdown(signal, INTERRUPTED.into(), flag());
        let _ = signal_hook::flag::register(signal, flag());
    }
}

/// Ends the program as interrupted, whatever it is doing.
pub fn end() -> ! {
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
