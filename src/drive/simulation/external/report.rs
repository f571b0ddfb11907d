//! What is known of a planner's process after a drive.

use std::time::Duration;

use super::fault::{Fault, PlannerFault};
use super::protocol::Ready;
use super::{Clock, ExternalPlanner};

/// Characters of a planner's name that are kept.
const LONGEST_NAME: usize = 80;

/// Characters of the last line of standard error in a sentence.
const LONGEST_LAST_LINE: usize = 200;

/// A drive as seen from beside a planner's process.
#[derive(Debug, Clone, PartialEq)]
pub struct ExternalReport {
    /// The planner as the user names it.
    pub planner: String,
    /// Its name and version as it said them; empty before it was ready.
    pub name: String,
    /// See `name`.
    pub version: String,
    /// Simulated or real time.
    pub clock: Clock,
    /// Whether obstacles came with predictions.
    pub predictions: bool,
    /// Earlier states that each obstacle came with, at most.
    pub history: usize,
    /// The fault that ended the drive.
    pub fault: Option<PlannerFault>,
    /// The time step at which there was no trajectory for this.
    pub fault_step: Option<i64>,
    /// The fault's details, or why nothing could be driven.
    pub message: Option<String>,
    /// The last lines of standard error.
    pub stderr: Vec<String>,
    /// From the start of the process to its `ready`; `None` where it never came.
    pub started_in: Option<Duration>,
    /// Time of each cycle beside what the planner itself measured, milliseconds; empty where it did not say.
    pub overhead_ms: Vec<f64>,
    /// In real time: the most steps until an answer counted.
    pub late_steps: usize,
    /// In real time: the largest distance between the ego and a trajectory that came late, metres.
    pub largest_offset: f64,
}

impl ExternalReport {
    pub(super) fn new(planner: &ExternalPlanner) -> Self {
        Self {
            planner: planner.name().to_string(),
            name: String::new(),
            version: String::new(),
            clock: planner.options.clock,
            predictions: false,
            history: 0,
            fault: None,
            fault_step: None,
            message: None,
            stderr: Vec::new(),
            started_in: None,
            overhead_ms: Vec::new(),
            late_steps: 0,
            largest_offset: 0.0,
        }
    }

    pub(super) fn greeted(&mut self, ready: &Ready, started_in: Duration) {
        self.name.clone_from(&ready.name);
        self.version.clone_from(&ready.version);
        self.predictions = ready.predictions;
        self.history = ready.history;
        self.started_in = Some(started_in);
    }

    pub(super) fn count(&mut self, took: Duration, own_ms: Option<f64>) {
        let took = took.as_secs_f64() * 1e3;
        let own = own_ms.filter(|own| (0.0..=took).contains(own));
        self.overhead_ms.extend(own.map(|own| took - own));
    }

    pub(super) fn fail(&mut self, fault: &Fault, step: i64) {
        self.fault = Some(fault.fault);
        self.fault_step = Some(step);
        self.message = Some(fault.details.clone()).filter(|details| !details.is_empty());
    }

    /// The planner with its version, as its process said them, on one line; else as the user names it.
    #[must_use]
    pub fn named(&self) -> String {
        let said = match (self.name.as_str(), self.version.as_str()) {
            ("", _) => self.planner.clone(),
            (name, "") => name.into(),
            (name, version) => format!("{name} {version}"),
        };
        let plain = said.chars().filter(|c| !c.is_control());
        plain.take(LONGEST_NAME).collect()
    }

    /// The fault in a sentence: its name, the time step, and its details; nothing without one.
    #[must_use]
    pub fn fault_in_words(&self) -> Option<String> {
        let fault = self.fault?;
        let step = self.fault_step.map(|step| format!(" at step {step}"));
        let name = format!("{}{}", fault.name(), step.unwrap_or_default());
        Some(match &self.message {
            Some(details) => format!("{name}: {fault}: {details}"),
            None => format!("{name}: {fault}"),
        })
    }

    /// The same with the last line of standard error, where the planner wrote one.
    #[must_use]
    pub fn failure(&self) -> Option<String> {
        let words = self.fault_in_words()?;
        Some(match self.stderr.last() {
            Some(line) => {
                let line: String = line.trim().chars().take(LONGEST_LAST_LINE).collect();
                format!("{words}; stderr: {line}")
            }
            None => words,
        })
    }
}
