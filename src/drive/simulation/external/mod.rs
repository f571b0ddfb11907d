//! Planners that are processes of their own and read JSON from a pipe, or functions that get the same, and what goes wrong
//! with them.
//!
//! nearmiss starts the process, says `hello` with scenario, road and planning problem, and asks for a trajectory each
//! cycle. The drive itself is that of the built-in planner: the same loop, contacts, goals and edges of the road.
//! The protocol is described by `nearmiss help planners`.

mod messages;
mod process;
mod protocol;
mod reading;
mod session;

use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::time::{Duration, Instant};

use process::Peer;
use protocol::Ready;
use strum::{IntoStaticStr, VariantArray};

pub use protocol::{
    OLDEST_PROTOCOL, PROTOCOL, ReferencePoint, planner_message_names, planner_message_schema,
};
pub use session::ExternalReport;
pub(super) use session::Session;

/// Whether the ego waits for its planner.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "lowercase")]
pub enum Clock {
    /// It does: the drive is the same however long planning takes.
    #[default]
    Simulated,
    /// It does not: an answer counts from the time step at which it is there.
    Real,
}

nearmiss_record::named!(Clock);

/// How a planner's process is run.
#[derive(Debug, Clone, PartialEq)]
pub struct ExternalOptions {
    /// The program and its arguments.
    pub command: Vec<String>,
    /// How long it may take from its start to `ready`.
    pub start: Duration,
    /// How long it may take for a cycle.
    pub cycle: Duration,
    /// Predictions even if it does not ask for them.
    pub predictions: bool,
    /// At least so many earlier states of obstacles.
    pub history: usize,
    /// Simulated or real time.
    pub clock: Clock,
}

impl ExternalOptions {
    /// How long a planner may take to get ready.
    pub const START: Duration = Duration::from_secs(60);

    /// How long a planner may take for a cycle.
    pub const CYCLE: Duration = Duration::from_secs(10);

    /// The usual ones for a command.
    #[must_use]
    pub fn new(command: Vec<String>) -> Self {
        Self {
            command,
            start: Self::START,
            cycle: Self::CYCLE,
            predictions: false,
            history: 0,
            clock: Clock::default(),
        }
    }

    /// The words of a command line, as a shell splits them; no shell runs.
    ///
    /// # Errors
    /// A quote is not closed, or there is no word.
    pub fn split_command(line: &str) -> Result<Vec<String>, String> {
        match shell_words::split(line) {
            Ok(words) if words.is_empty() => Err("an empty command".into()),
            Ok(words) => Ok(words),
            Err(_) => Err("a quote that is not closed".into()),
        }
    }
}

/// A planner that is a function of this program: what its process would be.
pub trait PlannerFunction: std::fmt::Debug + Send + Sync {
    /// What answers the requests of one drive, on a thread of its own.
    fn begin(&self) -> Answering;
}

/// Answers a request of the protocol, `hello` or `plan`, with a line of the protocol; where it fails, says how.
pub type Answering = Box<dyn FnMut(&str) -> Result<String, String> + Send>;

/// A planner that is a process; many drives at once may use it, each with a process of its own.
#[derive(Debug)]
pub struct ExternalPlanner {
    name: String,
    options: ExternalOptions,
    /// What answers in place of a process.
    function: Option<Arc<dyn PlannerFunction>>,
    /// Processes that wait for their next drive.
    idle: Mutex<Vec<Peer>>,
    ready: OnceLock<Ready>,
}

impl ExternalPlanner {
    /// A planner called `name`; its processes start when they are needed.
    #[must_use]
    pub fn new(name: impl Into<String>, options: ExternalOptions) -> Self {
        Self {
            name: name.into(),
            options,
            function: None,
            idle: Mutex::default(),
            ready: OnceLock::new(),
        }
    }

    /// A planner that is a function: there is no command among its options.
    #[must_use]
    pub fn of_function(
        name: impl Into<String>,
        options: ExternalOptions,
        function: Arc<dyn PlannerFunction>,
    ) -> Self {
        let mut planner = Self::new(name, options);
        planner.function = Some(function);
        planner
    }

    /// The name under which it was chosen: that of the configuration, else its command.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// How it is run.
    #[must_use]
    pub fn options(&self) -> &ExternalOptions {
        &self.options
    }

    /// Whether its trajectories depend on the scene alone, as it said itself in its first drive, so that drives which
    /// begin alike can share cycles. Measured times differ: in real time they cannot.
    #[must_use]
    pub fn is_stateless(&self) -> bool {
        let said = self.ready.get().is_some_and(|ready| ready.stateless);
        said && self.options.clock == Clock::Simulated
    }

    /// A process that waits, else a new one.
    fn peer(&self) -> Result<Peer, Fault> {
        let mut idle = self.idle.lock().unwrap_or_else(PoisonError::into_inner);
        // One that has ended, or has written something since its last drive, is of no use for another one.
        while let Some(mut peer) = idle.pop() {
            if peer.is_waiting() {
                return Ok(peer);
            }
        }
        drop(idle);
        match &self.function {
            Some(function) => Peer::of_function(function.begin()),
            None => Peer::start(&self.options.command),
        }
    }

    fn put_back(&self, peer: Peer) {
        let mut idle = self.idle.lock().unwrap_or_else(PoisonError::into_inner);
        idle.push(peer);
    }

    fn remember(&self, ready: &Ready) {
        self.ready.get_or_init(|| ready.clone());
    }
}

/// Processes that wait are asked to end, all at once; those that do not are ended.
impl Drop for ExternalPlanner {
    fn drop(&mut self) {
        let idle = self.idle.get_mut().unwrap_or_else(PoisonError::into_inner);
        for peer in idle.iter_mut() {
            peer.dismiss(session::bye());
        }
        let until = Instant::now() + process::GRACE;
        for peer in idle.drain(..) {
            peer.wait_for_its_end(until);
        }
    }
}

/// Why a planner's process ended a drive.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "snake_case")]
pub enum PlannerFault {
    /// Its program cannot be run.
    NotStarted,
    /// It ended, or closed its standard output.
    Died,
    /// No `ready` within the time for starting.
    StartTimeout,
    /// No answer within the time for a cycle.
    CycleTimeout,
    /// In real time: the trajectory before it was at its end when the answer came.
    TooLate,
    /// It wrote more than was asked for: a line that is too long, or lines between the requests.
    Flood,
    /// A line that is no message of the protocol, or not the one that was asked for.
    Nonsense,
    /// It speaks another version of the protocol.
    WrongVersion,
    /// A trajectory with a number that is not finite.
    NotFinite,
    /// A trajectory without states.
    Empty,
    /// A trajectory that ends before the next cycle.
    TooShort,
    /// A trajectory that does not begin where the vehicle is.
    WrongStart,
    /// A trajectory whose times do not increase.
    WrongTimes,
    /// It said itself that it failed.
    Refused,
}

nearmiss_record::named!(PlannerFault);

impl std::fmt::Display for PlannerFault {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::NotStarted => "the planner cannot be started",
            Self::Died => "the planner ended",
            Self::StartTimeout => "the planner did not get ready in time",
            Self::CycleTimeout => "the planner did not answer in time",
            Self::TooLate => "the planner answered too late",
            Self::Flood => "the planner wrote more than it was asked for",
            Self::Nonsense => "the planner's answer is not of the protocol",
            Self::WrongVersion => "the planner speaks another version of the protocol",
            Self::NotFinite => "the trajectory has a number that is not finite",
            Self::Empty => "the trajectory is empty",
            Self::TooShort => "the trajectory is too short",
            Self::WrongStart => "the trajectory does not begin where the ego is",
            Self::WrongTimes => "the times of the trajectory do not increase",
            Self::Refused => "the planner reported an error",
        })
    }
}

/// A fault in a drive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PlannerError {
    /// What it is.
    pub fault: PlannerFault,
    /// The time step at which the ego had no trajectory.
    pub step: i64,
}

impl std::fmt::Display for PlannerError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} at step {}", self.fault, self.step)
    }
}

/// A fault with its details in words.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Fault {
    pub fault: PlannerFault,
    /// More than the fault's own words say; may be empty.
    pub details: String,
}

impl Fault {
    pub fn new(fault: PlannerFault, details: impl Into<String>) -> Self {
        Self {
            fault,
            details: details.into(),
        }
    }
}

/// Why there is no trajectory.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(in crate::simulation) enum NoTrajectory {
    /// The drive was cancelled.
    Cancelled,
    /// The planner found nothing that can be driven, and said so.
    Infeasible,
    /// A fault; the details are in the report.
    Fault(PlannerFault),
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
