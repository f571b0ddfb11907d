//! Who answers a planner's requests: its process, started without a shell, spoken to in lines, and ended with all that it
//! started; or a function of this program, on a thread of its own.

use std::io::{BufRead, BufReader, Read, Write};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, SyncSender, channel, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use super::{Answering, Fault, PlannerFault};
use crate::planner::Cancel;
use nearmiss_base::system::processes::ended;
use nearmiss_base::system::{self, ProcessGroup};

/// Longest line that is read, bytes.
const LONGEST_LINE: u64 = 8 << 20;

/// Lines that may wait to be read; then the planner waits.
const MAX_WAITING_LINES: usize = 4;

/// Stack of a function's thread, bytes: as much as a program has.
const STACK: usize = 8 << 20;

/// Bytes of standard error that are kept, the last ones.
const STDERR: usize = 16 << 10;

/// How soon a drive that was cancelled is noticed.
const POLL: Duration = Duration::from_millis(50);

/// How long a planner may take to end by itself.
pub(super) const GRACE: Duration = Duration::from_millis(500);

/// What was answered.
#[derive(Debug)]
enum Heard {
    Line(String),
    /// The function failed, and how.
    Failed(String),
    /// A line that is longer than any may be.
    TooLong,
    /// Bytes that are no text.
    NoText,
}

/// A running planner: requests go to it, and answers come from it.
#[derive(Debug)]
pub(super) struct Peer {
    to: Option<Sender<Vec<u8>>>,
    from: Receiver<Heard>,
    /// None of a function.
    process: Option<Process>,
}

/// Its process.
#[derive(Debug)]
struct Process {
    child: Child,
    group: ProcessGroup,
    stderr: Arc<Mutex<Vec<u8>>>,
    /// Reads standard error until its end.
    listener: Option<JoinHandle<()>>,
}

/// Why no line was read.
pub(super) enum NoLine {
    /// The drive was cancelled.
    Cancelled,
    /// The time is over.
    TimedOut,
    /// Anything else that is wrong.
    Fault(Fault),
}

impl Peer {
    /// A function, which answers on a thread of its own: one that takes too long is not waited for, and cannot be ended.
    ///
    /// # Errors
    /// The system starts no thread.
    pub fn of_function(mut answer: Answering) -> Result<Self, Fault> {
        let (to, asked) = channel::<Vec<u8>>();
        let (read, from) = sync_channel(MAX_WAITING_LINES);
        let answering = move || {
            for bytes in asked {
                let heard = match answer(&String::from_utf8_lossy(&bytes)) {
                    Ok(line) => Heard::Line(line),
                    Err(why) => Heard::Failed(why),
                };
                if read.send(heard).is_err() {
                    return;
                }
            }
        };
        let thread = std::thread::Builder::new().name("planner".into());
        thread
            .stack_size(STACK)
            .spawn(answering)
            .map_err(|error| Fault::new(PlannerFault::NotStarted, system::error_text(&error)))?;
        Ok(Self {
            to: Some(to),
            from,
            process: None,
        })
    }

    /// Starts a program with its arguments, in a process group of its own.
    ///
    /// # Errors
    /// It cannot be run.
    pub fn start(words: &[String]) -> Result<Self, Fault> {
        let not_started = |details: String| Fault::new(PlannerFault::NotStarted, details);
        let (program, arguments) = words
            .split_first()
            .ok_or_else(|| not_started("the command is empty".into()))?;
        let mut command = Command::new(program);
        command.args(arguments);
        command.stdin(Stdio::piped());
        command.stdout(Stdio::piped()).stderr(Stdio::piped());
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        let mut child = system::processes::with_default(|| command.spawn())
            .map_err(|error| not_started(format!("{program}: {}", system::error_text(&error))))?;
        let group = ProcessGroup::led_by(child.id());
        let (to, written) = channel::<Vec<u8>>();
        let (read, from) = sync_channel(MAX_WAITING_LINES);
        let stderr = Arc::new(Mutex::new(Vec::new()));
        if let Some(mut stdin) = child.stdin.take() {
            std::thread::spawn(move || {
                // A planner that has gone reads nothing: reading its answer says so.
                for bytes in written {
                    if stdin
                        .write_all(&bytes)
                        .and_then(|()| stdin.flush())
                        .is_err()
                    {
                        break;
                    }
                }
            });
        }
        if let Some(stdout) = child.stdout.take() {
            std::thread::spawn(move || read_lines(stdout, &read));
        }
        let listener = child.stderr.take().map(|stream| {
            let kept = Arc::clone(&stderr);
            std::thread::spawn(move || keep_last(stream, &kept))
        });
        Ok(Self {
            to: Some(to),
            from,
            process: Some(Process {
                child,
                group,
                stderr,
                listener,
            }),
        })
    }

    /// Sends a line, without waiting until it is read.
    pub fn send(&self, mut line: Vec<u8>) {
        if self.process.is_some() {
            line.push(b'\n');
        }
        if let Some(to) = &self.to {
            // Its reader has gone only where the planner has.
            let _ = to.send(line);
        }
    }

    /// The next line, which is to come within `limit`.
    pub fn receive(&mut self, limit: Duration, cancel: &Cancel) -> Result<String, NoLine> {
        let until = Instant::now() + limit;
        loop {
            let left = until.saturating_duration_since(Instant::now());
            match self.from.recv_timeout(left.min(POLL)) {
                Ok(Heard::Line(line)) => return Ok(line),
                Ok(Heard::TooLong) => {
                    let details = format!("a line of more than {} MiB", LONGEST_LINE >> 20);
                    return Err(NoLine::Fault(Fault::new(PlannerFault::Flood, details)));
                }
                Ok(Heard::NoText) => {
                    let details = "bytes that are not UTF-8";
                    return Err(NoLine::Fault(Fault::new(PlannerFault::Nonsense, details)));
                }
                Ok(Heard::Failed(details)) => {
                    return Err(NoLine::Fault(Fault::new(PlannerFault::Died, details)));
                }
                Err(RecvTimeoutError::Disconnected) => return Err(NoLine::Fault(self.died())),
                Err(RecvTimeoutError::Timeout) if cancel.is_asked() => {
                    return Err(NoLine::Cancelled);
                }
                Err(RecvTimeoutError::Timeout) if left.is_zero() => return Err(NoLine::TimedOut),
                Err(RecvTimeoutError::Timeout) => {}
            }
        }
    }

    /// A line that was written without being asked for, if there is one.
    pub fn unasked(&mut self) -> Option<String> {
        match self.from.try_recv().ok()? {
            Heard::Line(line) => Some(line),
            Heard::Failed(_) | Heard::TooLong | Heard::NoText => Some(String::new()),
        }
    }

    /// The last lines of standard error.
    pub fn stderr(&self) -> Vec<String> {
        self.process
            .as_ref()
            .map(Process::stderr)
            .unwrap_or_default()
    }

    /// It answers no more: how it ended.
    fn died(&mut self) -> Fault {
        match &mut self.process {
            Some(process) => process.died(),
            // Its thread ends only with a panic.
            None => Fault::new(PlannerFault::Died, "internal error of the function"),
        }
    }

    /// Whether it waits for its next drive: it runs, and wrote nothing that was not asked for.
    pub fn is_waiting(&mut self) -> bool {
        self.unasked().is_none()
            && (self.process.as_mut()).is_none_or(|process| ended(&mut process.child).is_none())
    }

    /// Asks it to end, with a last line, and does not wait. A function ends where nothing is asked of it any more.
    pub fn dismiss(&mut self, last: Vec<u8>) {
        if self.process.is_some() {
            self.send(last);
        }
        self.to = None;
    }

    /// Asks it to end, with a last line, and ends it where it does not within half a second; the last lines of its
    /// standard error.
    pub fn end(mut self, last: Vec<u8>) -> Vec<String> {
        self.dismiss(last);
        let until = Instant::now() + GRACE;
        self.wait_for_its_end(until);
        self.last_words()
    }

    /// Waits until it closes its standard output.
    pub fn wait_for_its_end(&self, until: Instant) {
        while self.process.is_some() && Instant::now() < until {
            let left = until.saturating_duration_since(Instant::now());
            if let Err(RecvTimeoutError::Disconnected) = self.from.recv_timeout(left) {
                break;
            }
        }
    }

    /// Ends it, with all that it started; the last lines of its standard error.
    pub fn last_words(self) -> Vec<String> {
        self.process.map(Process::last_words).unwrap_or_default()
    }
}

impl Process {
    fn stderr(&self) -> Vec<String> {
        let kept = self.stderr.lock().unwrap_or_else(PoisonError::into_inner);
        let text = String::from_utf8_lossy(&kept);
        let lines = text.lines().map(|line| line.trim_end().to_string());
        lines.filter(|line| !line.is_empty()).collect()
    }

    /// It closed its standard output: how it ended.
    fn died(&mut self) -> Fault {
        let until = Instant::now() + GRACE;
        let mut status = ended(&mut self.child);
        while status.is_none() && Instant::now() < until {
            std::thread::sleep(Duration::from_millis(2));
            status = ended(&mut self.child);
        }
        let details = status.unwrap_or_else(|| "it closed its standard output".into());
        Fault::new(PlannerFault::Died, details)
    }

    fn last_words(self) -> Vec<String> {
        self.group.kill();
        let until = Instant::now() + GRACE;
        // What has left its group may hold it open.
        while self
            .listener
            .as_ref()
            .is_some_and(|listener| !listener.is_finished())
            && Instant::now() < until
        {
            std::thread::sleep(Duration::from_millis(1));
        }
        self.stderr()
    }
}

/// Whatever happens, nothing of it is left running.
impl Drop for Process {
    fn drop(&mut self) {
        self.group.kill();
        self.group.forget();
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn read_lines(stdout: impl Read, to: &SyncSender<Heard>) {
    let mut stdout = BufReader::new(stdout);
    loop {
        let mut line = Vec::new();
        let read = (&mut stdout)
            .take(LONGEST_LINE)
            .read_until(b'\n', &mut line);
        let message = match read {
            Ok(0) | Err(_) => return,
            Ok(_) if line.last() != Some(&b'\n') && line.len() as u64 >= LONGEST_LINE => {
                Heard::TooLong
            }
            Ok(_) => String::from_utf8(line).map_or(Heard::NoText, Heard::Line),
        };
        if to.send(message).is_err() {
            return;
        }
    }
}

fn keep_last(mut stream: impl Read, kept: &Mutex<Vec<u8>>) {
    let mut bytes = [0; 4096];
    while let Ok(count) = stream.read(&mut bytes) {
        if count == 0 {
            return;
        }
        let mut kept = kept.lock().unwrap_or_else(PoisonError::into_inner);
        kept.extend_from_slice(&bytes[..count]);
        if let Some(more) = kept.len().checked_sub(2 * STDERR) {
            let begin = more + STDERR;
            kept.drain(..begin);
        }
    }
}
