//! What goes wrong with a planner that is a process.

/// Why a planner's process ended a drive.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
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

impl PlannerFault {
    /// All of them.
    pub const ALL: [Self; 14] = [
        Self::NotStarted,
        Self::Died,
        Self::StartTimeout,
        Self::CycleTimeout,
        Self::TooLate,
        Self::Flood,
        Self::Nonsense,
        Self::WrongVersion,
        Self::NotFinite,
        Self::Empty,
        Self::TooShort,
        Self::WrongStart,
        Self::WrongTimes,
        Self::Refused,
    ];

    /// Its name in JSON.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::NotStarted => "not_started",
            Self::Died => "died",
            Self::StartTimeout => "start_timeout",
            Self::CycleTimeout => "cycle_timeout",
            Self::TooLate => "too_late",
            Self::Flood => "flood",
            Self::Nonsense => "nonsense",
            Self::WrongVersion => "wrong_version",
            Self::NotFinite => "not_finite",
            Self::Empty => "empty",
            Self::TooShort => "too_short",
            Self::WrongStart => "wrong_start",
            Self::WrongTimes => "wrong_times",
            Self::Refused => "refused",
        }
    }
}

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
pub(super) struct Fault {
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
