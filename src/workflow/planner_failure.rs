//! How a planner's process failed before there was anything to work on.

use nearmiss_drive::simulation::{ExternalReport, PlannerFault};

/// How a planner's process failed in a scenario.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{scenario}: not driven by `{planner}`: {words}")]
pub struct PlannerFailure {
    /// The scenario, as errors name it.
    pub scenario: String,
    /// The planner as the user names it.
    pub planner: String,
    /// The fault with its time step, its details, and the last line of standard error.
    pub words: String,
    /// What kind of fault it is.
    pub fault: PlannerFault,
    /// The time step at which there was no trajectory.
    pub step: Option<i64>,
    /// The last lines of standard error.
    pub stderr: Vec<String>,
}

impl PlannerFailure {
    /// The failure of a drive; nothing where its planner did not fail.
    #[must_use]
    pub fn from_report(scenario: String, report: &ExternalReport) -> Option<Self> {
        Some(Self {
            scenario,
            planner: report.planner.clone(),
            words: report.failure()?,
            fault: report.fault?,
            step: report.fault_step,
            stderr: report.stderr.clone(),
        })
    }
}
