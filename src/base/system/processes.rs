//! Processes: programs of this machine, children that end with this one, and job control by the shell.

pub use signals::{Signals, ask_to_stop, stop, take_over, was_continued, with_default};

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Child;
use std::sync::{Mutex, PoisonError};

/// The leaders of those that run.
static RUNNING: Mutex<BTreeSet<i32>> = Mutex::new(BTreeSet::new());

/// A process group of a child of this program; it is killed where [`end_process_groups`] comes first.
#[derive(Debug)]
pub struct ProcessGroup {
    leader: Option<i32>,
}

impl ProcessGroup {
    /// That of a child which leads a group of its own, by its process id.
    #[must_use]
    pub fn led_by(id: u32) -> Self {
        let leader = i32::try_from(id).ok();
        let mut running = RUNNING.lock().unwrap_or_else(PoisonError::into_inner);
        running.extend(leader);
        Self { leader }
    }

    /// Kills all that is left of it.
    pub fn kill(&self) {
        if let Some(leader) = self.leader {
            kill(leader);
        }
    }

    /// Forgets it: before its leader is waited for, as its id may then be that of another process.
    pub fn forget(&mut self) {
        if let Some(leader) = self.leader.take() {
            let mut running = RUNNING.lock().unwrap_or_else(PoisonError::into_inner);
            running.remove(&leader);
        }
    }
}

impl Drop for ProcessGroup {
    fn drop(&mut self) {
        self.forget();
    }
}

/// Kills every group that still runs.
pub fn end_process_groups() {
    let running = RUNNING.lock().unwrap_or_else(PoisonError::into_inner);
    running.iter().copied().for_each(kill);
}

#[cfg(unix)]
fn kill(leader: i32) {
    use rustix::process::{Pid, Signal, kill_process_group};
    if let Some(leader) = Pid::from_raw(leader) {
        // Those that have ended already are not there.
        let _ = kill_process_group(leader, Signal::KILL);
    }
}

#[cfg(not(unix))]
fn kill(_: i32) {}

/// How a child ended, if it has. It is not waited for: until then its id, and that of its group, are those of no other
/// process.
#[cfg(unix)]
pub fn ended(child: &mut Child) -> Option<String> {
    use rustix::process::{Pid, WaitId, WaitIdOptions, waitid};
    let id = Pid::from_raw(i32::try_from(child.id()).ok()?)?;
    let options = WaitIdOptions::EXITED | WaitIdOptions::NOHANG | WaitIdOptions::NOWAIT;
    let status = waitid(WaitId::Pid(id), options).ok()??;
    let signal = status.terminating_signal();
    Some(match (status.exit_status(), signal) {
        (Some(code), _) => format!("exit status {code}"),
        (None, Some(signal)) => format!("killed by signal {signal}"),
        (None, None) => "it ended".into(),
    })
}

/// The same where children are not waited for apart from their end.
#[cfg(not(unix))]
pub fn ended(child: &mut Child) -> Option<String> {
    Some(child.try_wait().ok()??.to_string())
}

/// Lets the system end a child after so many seconds of work, or where it writes a file of more bytes: it ends also where
/// this program was killed before.
#[cfg(target_os = "linux")]
pub fn limit(child: &Child, seconds: u64, bytes: u64) {
    use rustix::process::{Pid, Resource, Rlimit, prlimit};
    let id = i32::try_from(child.id()).ok().and_then(Pid::from_raw);
    for (resource, most) in [(Resource::Cpu, seconds), (Resource::Fsize, bytes)] {
        let most = Rlimit {
            current: Some(most),
            maximum: Some(most),
        };
        // One that has ended already needs none.
        let _ = id.map(|id| prlimit(Some(id), resource, most));
    }
}

/// Elsewhere the system does not.
#[cfg(not(target_os = "linux"))]
pub fn limit(_: &Child, _: u64, _: u64) {}

/// Whether a word is the path of a file, or the name of one in the folders of `PATH`.
#[must_use]
pub fn is_program(word: &str) -> bool {
    program(word).is_some()
}

/// The file that a word means as a program: that of its path, or the first of that name in the folders of `PATH`.
#[must_use]
pub fn program(word: &str) -> Option<PathBuf> {
    let path = Path::new(word);
    if path.components().count() > 1 {
        return path.is_file().then(|| path.to_path_buf());
    }
    let folders = std::env::var_os("PATH").unwrap_or_default();
    let mut files = std::env::split_paths(&folders).flat_map(|folder| {
        let file = folder.join(word);
        let with_ending = file.with_extension(std::env::consts::EXE_EXTENSION);
        [file, with_ending]
    });
    files.find(|file| file.is_file())
}

/// Job-control signals from a shell or another program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum JobSignal {
    /// It is to stop: call [`stop`] once the terminal is given back.
    Stop,
    /// It was stopped and goes on, or was told to go on before it had stopped; [`was_continued`] tells once.
    Continue,
}

#[cfg(target_os = "linux")]
mod signals {
    //! Linux: both signals stay blocked and pending, and the kernel itself drops a stop that a continuation overtakes.
    //!
    //! A handler would have to note that SIGTSTP came, and the program would stop later; a SIGCONT in between is found
    //! only if its handler has run by then, on whichever thread. Of blocked signals the kernel keeps the later one alone
    //! (signal(7): each of the two discards the other where it is pending), and unblocking SIGTSTP stops the program in
    //! the same moment in which the kernel sees that it is still pending.

    use std::io;
    use std::os::fd::{AsFd, BorrowedFd};
    use std::sync::OnceLock;

    use nix::poll::{PollFd, PollFlags, PollTimeout, poll};
    use nix::sys::signal::{SigSet, Signal, kill, raise};
    use nix::sys::signalfd::{SfdFlags, SignalFd};
    use nix::unistd::Pid;
    use tokio::io::unix::AsyncFd;

    use super::JobSignal;

    struct Pending {
        stop: SignalFd,
        go_on: SignalFd,
    }

    static PENDING: OnceLock<Pending> = OnceLock::new();

    fn set(signals: &[Signal]) -> SigSet {
        signals.iter().copied().collect()
    }

    fn descriptor(signal: Signal) -> io::Result<SignalFd> {
        let flags = SfdFlags::SFD_NONBLOCK | SfdFlags::SFD_CLOEXEC;
        Ok(SignalFd::with_flags(&set(&[signal]), flags)?)
    }

    /// How long a stop that the kernel would not make waits for the continuation that may follow at once, milliseconds.
    const GRACE: u8 = 50;

    /// Whether this signal came and was not taken.
    fn is_pending(signal: &impl AsFd) -> bool {
        comes_within(signal, PollTimeout::ZERO)
    }

    /// Whether this signal came and was not taken, or comes soon.
    fn comes_within(signal: &impl AsFd, timeout: impl Into<PollTimeout>) -> bool {
        let mut asked = [PollFd::new(signal.as_fd(), PollFlags::POLLIN)];
        poll(&mut asked, timeout).is_ok_and(|ready| ready > 0)
    }

    /// Takes over what happens on SIGTSTP and SIGCONT. Threads that exist already would still stop the program: call it
    /// before any is started.
    ///
    /// # Errors
    /// The system refuses.
    pub fn take_over() -> io::Result<()> {
        set(&[Signal::SIGTSTP, Signal::SIGCONT]).thread_block()?;
        if PENDING.get().is_none() {
            let pending = Pending {
                stop: descriptor(Signal::SIGTSTP)?,
                go_on: descriptor(Signal::SIGCONT)?,
            };
            PENDING.get_or_init(|| pending);
        }
        Ok(())
    }

    /// Starts another program, by `start`, with the signals as the shell has them: what is blocked here would be there.
    pub fn with_default<T>(start: impl FnOnce() -> T) -> T {
        let ours = set(&[Signal::SIGTSTP, Signal::SIGCONT]);
        let blocked = SigSet::thread_get_mask();
        let taken_over = blocked.is_ok_and(|b| b.contains(Signal::SIGTSTP));
        if taken_over {
            let _ = ours.thread_unblock();
        }
        let started = start();
        if taken_over {
            let _ = ours.thread_block();
        }
        started
    }

    /// The user asked with a key to stop the program, as SIGTSTP does.
    pub fn ask_to_stop() {
        let _ = kill(Pid::this(), Signal::SIGTSTP);
    }

    /// Stops the program until it is continued; does nothing where it was not asked to, or was continued since.
    ///
    /// # Errors
    /// The system refuses.
    pub fn stop() -> io::Result<()> {
        let Some(Pending { stop, go_on }) = PENDING.get() else {
            return Ok(());
        };
        if !is_pending(stop) {
            return Ok(());
        }
        let asked = set(&[Signal::SIGTSTP]);
        asked.thread_unblock()?;
        asked.thread_block()?;
        // SIGTSTP stops nothing where no shell waits for the program (an orphaned process group); SIGSTOP does. The kernel
        // does not weigh that one against a continuation, so one that follows at once is waited for.
        if !comes_within(go_on, GRACE) {
            raise(Signal::SIGSTOP)?;
        }
        Ok(())
    }

    /// Whether the program was continued since this was last asked.
    #[must_use]
    pub fn was_continued() -> bool {
        let go_on = PENDING.get().map(|pending| &pending.go_on);
        go_on.is_some_and(|signal| matches!(signal.read_signal(), Ok(Some(_))))
    }

    /// Waits for the two signals.
    pub struct Signals {
        stop: AsyncFd<BorrowedFd<'static>>,
        go_on: AsyncFd<BorrowedFd<'static>>,
    }

    impl Signals {
        /// Begins to wait; what came since [`take_over`] is heard, too.
        ///
        /// # Errors
        /// The signals were not taken over, or the system refuses.
        pub fn listen() -> io::Result<Self> {
            let pending = PENDING.get().ok_or(io::ErrorKind::NotConnected)?;
            Ok(Self {
                stop: registered(&pending.stop)?,
                go_on: registered(&pending.go_on)?,
            })
        }

        /// The next one. It stays pending: [`stop`] or [`was_continued`] must follow.
        pub async fn wait(&mut self) -> JobSignal {
            tokio::select! {
                () = pending(&self.go_on) => JobSignal::Continue,
                () = pending(&self.stop) => JobSignal::Stop,
            }
        }
    }

    #[expect(
        deprecated,
        reason = "its successor is unsafe, for descriptors that are closed; these never are"
    )]
    fn registered(signal: &'static SignalFd) -> io::Result<AsyncFd<BorrowedFd<'static>>> {
        AsyncFd::new(signal.as_fd())
    }

    async fn pending(signal: &AsyncFd<BorrowedFd<'static>>) {
        loop {
            let Ok(mut guard) = signal.readable().await else {
                // The runtime ends.
                return std::future::pending().await;
            };
            if is_pending(signal.get_ref()) {
                return;
            }
            // It was taken, or dropped by the kernel.
            guard.clear_ready();
        }
    }
}

#[cfg(all(unix, not(target_os = "linux")))]
mod signals {
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
}

#[cfg(not(unix))]
mod signals {
    //! Systems without job control: nothing stops the program, nothing continues it.

    use std::io;

    use super::JobSignal;

    /// Does nothing.
    ///
    /// # Errors
    /// None.
    pub fn take_over() -> io::Result<()> {
        Ok(())
    }

    /// Starts another program, by `start`.
    pub fn with_default<T>(start: impl FnOnce() -> T) -> T {
        start()
    }

    /// Does nothing.
    pub fn ask_to_stop() {}

    /// Does nothing.
    ///
    /// # Errors
    /// None.
    pub fn stop() -> io::Result<()> {
        Ok(())
    }

    /// Never.
    #[must_use]
    pub fn was_continued() -> bool {
        false
    }

    /// Waits for ever.
    pub struct Signals;

    impl Signals {
        /// Begins to wait.
        ///
        /// # Errors
        /// None.
        pub fn listen() -> io::Result<Self> {
            Ok(Self)
        }

        /// Never returns.
        pub async fn wait(&mut self) -> JobSignal {
            std::future::pending().await
        }
    }
}
