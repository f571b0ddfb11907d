//! CommonRoad solutions: vehicle motions that solve a scenario's planning problems.

mod kind;
mod reader;
mod writer;

use jiff::civil::DateTime;

pub use kind::{Field, TrajectoryKind};
pub use reader::read_solution;
pub use writer::write_solution;

use nearmiss_scene::scenario::plausibility::limits::LATEST_STEP;
use nearmiss_scene::scenario::{Diagnostic, VehicleModel, VehicleType};

/// A solution of a scenario: one vehicle, or several for a cooperative one.
#[derive(Debug, Clone, PartialEq)]
pub struct Solution {
    /// The scenario's benchmark id.
    pub scenario_id: String,
    /// The version of the scenario's format, e.g. `2020a`.
    pub version: String,
    /// Creation time in an unknown time zone; whole seconds are kept.
    pub date: Option<DateTime>,
    /// How long it took to compute, seconds; positive.
    pub computation_time: Option<f64>,
    /// On which processor it was computed.
    pub processor: Option<String>,
    /// The motions, one a planning problem.
    pub problems: Vec<ProblemSolution>,
    /// Assumptions and omissions made while reading.
    pub diagnostics: Vec<Diagnostic>,
}

/// One vehicle's solution of one planning problem.
#[derive(Debug, Clone, PartialEq)]
pub struct ProblemSolution {
    /// Id of the planning problem.
    pub planning_problem: i64,
    /// How the vehicle's motion is modelled.
    pub model: VehicleModel,
    /// Which vehicle it is; the file does not carry its size.
    pub vehicle: VehicleType,
    /// The cost function it is to be judged with, e.g. `SM1`.
    pub cost: String,
    /// The motion.
    pub trajectory: SolutionTrajectory,
}

/// States of one kind, in order of time, one a time step; at least one.
#[derive(Debug, Clone, PartialEq)]
pub struct SolutionTrajectory {
    kind: TrajectoryKind,
    states: Vec<SolutionState>,
}

/// One state, or one input.
#[derive(Debug, Clone, PartialEq)]
pub struct SolutionState {
    /// Time step.
    pub step: i64,
    /// The quantities of [`TrajectoryKind::fields`], in that order; all within ±1e9, and coordinates within ±2.5e7.
    pub values: Vec<f64>,
}

/// Why a solution cannot be written.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum SolutionError {
    /// It is empty.
    #[error("a solution without a trajectory; it needs one per planning problem")]
    Empty,
    /// A trajectory without states.
    #[error("a trajectory without states")]
    NoStates,
    /// A state has more or fewer quantities than its kind.
    #[error("step {step}: {found} quantities; <{element}> needs {expected}")]
    Length {
        /// Time step.
        step: i64,
        /// The state's element.
        element: &'static str,
        /// How many it has.
        found: usize,
        /// How many its kind has.
        expected: usize,
    },
    /// A quantity is not finite.
    #[error("step {step}: {field} is {value}, which is implausible")]
    NotFinite {
        /// Time step.
        step: i64,
        /// Which quantity.
        field: &'static str,
        /// The value, as text.
        value: String,
    },
    /// Two states at one time step.
    #[error("time step {0} is given twice")]
    Repeated(i64),
    /// A time step is beyond what the format can hold.
    #[error("time step {0} is implausible")]
    Step(i64),
    /// The trajectory is not one of the vehicle's model.
    #[error("planning problem {problem}: a vehicle of model {model} has no <{element}>")]
    Model {
        /// Which problem.
        problem: i64,
        /// The vehicle's model.
        model: VehicleModel,
        /// The trajectory's element.
        element: &'static str,
    },
    /// Two solutions of one problem.
    #[error("planning problem {0} is solved twice")]
    Twice(i64),
    /// A word of the benchmark id, or the processor's name, cannot be written.
    #[error("{what} `{value}` cannot be written: {why}")]
    Word {
        /// Which word.
        what: &'static str,
        /// The element.
        value: String,
        /// The mistake.
        why: &'static str,
    },
    /// The computation time is not positive and finite.
    #[error("a computation time of {0} s; it must be positive")]
    ComputationTime(String),
    /// The model's states cannot be made of positions, headings and velocities.
    #[error("the states of model {0} cannot be derived from an ego's motion; PM and KS can")]
    NotDerivable(VehicleModel),
    /// Writing failed.
    #[error("cannot write the solution: {0}")]
    Write(String),
}

impl Solution {
    /// The benchmark id of the whole solution, e.g. `KS2:SM1:DEU_Test-1_1_T-1:2020a`.
    #[must_use]
    pub fn benchmark_id(&self) -> String {
        kind::compose(self, &self.problems.iter().collect::<Vec<_>>())
    }

    /// The solution of one planning problem.
    #[must_use]
    pub fn problem(&self, id: i64) -> Option<&ProblemSolution> {
        self.problems.iter().find(|p| p.planning_problem == id)
    }
}

impl ProblemSolution {
    /// Model and vehicle, e.g. `KS2`.
    #[must_use]
    pub fn vehicle_id(&self) -> String {
        format!("{}{}", self.model, self.vehicle.number())
    }
}

impl SolutionTrajectory {
    /// A trajectory of `states` in any order.
    ///
    /// # Errors
    /// None, or two at one time step, or one whose quantities are not those of `kind`, all finite.
    pub fn new(
        kind: TrajectoryKind,
        mut states: Vec<SolutionState>,
    ) -> Result<Self, SolutionError> {
        if states.is_empty() {
            return Err(SolutionError::NoStates);
        }
        states.sort_by_key(|s| s.step);
        if let Some(pair) = states.windows(2).find(|w| w[0].step == w[1].step) {
            return Err(SolutionError::Repeated(pair[0].step));
        }
        let fields = kind.fields();
        for state in &states {
            let step = state.step;
            if step.checked_abs().is_none_or(|s| s > LATEST_STEP) {
                return Err(SolutionError::Step(step));
            }
            if state.values.len() != fields.len() {
                return Err(SolutionError::Length {
                    step,
                    element: kind.state_element(),
                    found: state.values.len(),
                    expected: fields.len(),
                });
            }
            let mut pairs = fields.iter().zip(&state.values);
            if let Some((field, value)) = pairs.find(|(f, v)| v.is_nan() || v.abs() > f.largest()) {
                return Err(SolutionError::NotFinite {
                    step,
                    field: field.name,
                    value: value.to_string(),
                });
            }
        }
        Ok(Self { kind, states })
    }

    /// The quantities of its states.
    #[must_use]
    pub fn kind(&self) -> TrajectoryKind {
        self.kind
    }

    /// The states, in order of time.
    #[must_use]
    pub fn states(&self) -> &[SolutionState] {
        &self.states
    }

    /// A quantity of one of its states, if this kind has it.
    #[must_use]
    pub fn value(&self, state: &SolutionState, name: &str) -> Option<f64> {
        let place = self.kind.fields().iter().position(|f| f.name == name)?;
        state.values.get(place).copied()
    }
}
