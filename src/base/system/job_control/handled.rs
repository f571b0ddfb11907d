//! Unix but Linux: handlers note what came last. A continuation between the last look and the stop is lost.

use std::io;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, OnceLock};

use signal_hook::consts::{SIGCONT, SIGSTOP, SIGTSTP};
use signal_hook::{flag, low_level};
use tokio::signal::unix::{Signal, SignalKind, signal};

use super::JobSignal;

/// What the handlers of the signals write.
#[derive(Default)]
struct Noted {
    /// Which of the two was handled last.
    last: Arc<AtomicUsize>,
    continued: Arc<AtomicBool>,
}

/// Neither came, or it was obeyed.
const NONE: usize = 0;
const STOP: usize = 1;
const CONTINUE: usize = 2;

static NOTED: OnceLock<Noted> = OnceLock::new();

/// Takes over what happens on SIGTSTP and SIGCONT.
///
/// # Errors
/// The system refuses.
pub fn take_over() -> io::Result<()> {
    if NOTED.get().is_none() {
        let noted = Noted::default();
        flag::register_usize(SIGTSTP, Arc::clone(&noted.last), STOP)?;
        flag::register_usize(SIGCONT, Arc::clone(&noted.last), CONTINUE)?;
        flag::register(SIGCONT, Arc::clone(&noted.continued))?;
        NOTED.get_or_init(|| noted);
    }
    Ok(())
}

/// Starts another program, by `start`; handlers are not handed on.
pub fn with_default<T>(start: impl FnOnce() -> T) -> T {
    start()
}

/// The user asked with a key to stop the program, as SIGTSTP does.
pub fn ask_to_stop() {
    if let Some(noted) = NOTED.get() {
        noted.last.store(STOP, Ordering::SeqCst);
    }
}

/// Stops the program until it is continued; does nothing where it was not asked to, or was continued since.
///
/// # Errors
/// The system refuses.
pub fn stop() -> io::Result<()> {
    let Some(Noted { last, continued }) = NOTED.get() else {
        return Ok(());
    };
    let asked = last.compare_exchange(STOP, NONE, Ordering::SeqCst, Ordering::SeqCst);
    // SIGSTOP, as SIGTSTP stops nothing where no shell waits for the program.
    if asked.is_ok() && !continued.load(Ordering::SeqCst) {
        low_level::raise(SIGSTOP)?;
    }
    Ok(())
}

/// Whether the program was continued since this was last asked.
#[must_use]
pub fn was_continued() -> bool {
    let Some(Noted { last, continued }) = NOTED.get() else {
        return false;
    };
    let was = continued.swap(false, Ordering::SeqCst);
    if was {
        // Handlers of signals that come together run in any order. To go on is the safe side: a stop that is lost
        // can be asked for again.
        last.store(NONE, Ordering::SeqCst);
    }
    was
}

/// Waits for the two signals.
pub struct Signals {
    stop: Signal,
    go_on: Signal,
}

impl Signals {
    /// Begins to wait; what came before is not heard.
    ///
    /// # Errors
    /// The system refuses.
    pub fn listen() -> io::Result<Self> {
        Ok(Self {
            stop: signal(SignalKind::from_raw(SIGTSTP))?,
            go_on: signal(SignalKind::from_raw(SIGCONT))?,
        })
    }

    /// The next one; [`stop`] or [`was_continued`] must follow.
    pub async fn wait(&mut self) -> JobSignal {
        tokio::select! {
            Some(()) = self.go_on.recv() => JobSignal::Continue,
            Some(()) = self.stop.recv() => JobSignal::Stop,
            else => std::future::pending().await,
        }
    }
}
