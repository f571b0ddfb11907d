//! CommonRoad solutions: vehicle motions that solve a scenario's planning problems, their kinds and benchmark ids.

mod reader;
mod writer;

pub use reader::read_solution;
pub use writer::write_solution;

use jiff::civil::DateTime;
use nearmiss_scene::scenario::plausibility::{LARGEST_COORDINATE, LARGEST_NUMBER, LATEST_STEP};
use nearmiss_scene::scenario::{Diagnostic, VehicleModel, VehicleType};
use strum::VariantArray;

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
        compose_benchmark_id(self, &self.problems.iter().collect::<Vec<_>>())
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

/// A quantity of a state: its element and its unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Field {
    /// The element's name.
    pub name: &'static str,
    /// Unit, SI and radians.
    pub unit: &'static str,
}

impl Field {
    /// No value of it is larger.
    fn largest(&self) -> f64 {
        match self.name {
            "x" | "y" => LARGEST_COORDINATE,
            _ => LARGEST_NUMBER,
        }
    }
}

/// Trajectory kinds of a solution, in schema order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, VariantArray)]
pub enum TrajectoryKind {
    /// Accelerations along the world's axes; no states.
    PmInput,
    /// Steering speeds and accelerations; no states.
    Input,
    /// States of the point mass.
    Pm,
    /// States of the kinematic single-track model.
    Ks,
    /// States of the single-track model.
    St,
    /// States of the multi-body model.
    Mb,
    /// States of the kinematic single-track model with trailer; commonroad-io has it, the schema does not.
    Kst,
}

/// Fields without repeating the word at every one of them.
macro_rules! fields {
    ($($name:literal $unit:literal),+ $(,)?) => { &[$(Field { name: $name, unit: $unit }),+] };
}

const PM_INPUT: &[Field] = fields!["xAcceleration" "m/s²", "yAcceleration" "m/s²"];

const INPUT: &[Field] = fields!["steeringAngleSpeed" "rad/s", "acceleration" "m/s²"];

const PM: &[Field] = fields!["x" "m", "y" "m", "xVelocity" "m/s", "yVelocity" "m/s"];

const KS: &[Field] =
    fields!["x" "m", "y" "m", "steeringAngle" "rad", "velocity" "m/s", "orientation" "rad"];

const ST: &[Field] = fields![
    "x" "m", "y" "m", "steeringAngle" "rad", "velocity" "m/s", "orientation" "rad",
    "yawRate" "rad/s", "slipAngle" "rad",
];

const MB: &[Field] = fields![
    "x" "m", "y" "m", "steeringAngle" "rad", "velocity" "m/s", "orientation" "rad",
    "yawRate" "rad/s", "rollAngle" "rad", "rollRate" "rad/s", "pitchAngle" "rad",
    "pitchRate" "rad/s", "yVelocity" "m/s", "zPosition" "m", "zVelocity" "m/s",
    "rollAngleFront" "rad", "rollRateFront" "rad/s", "yVelocityFront" "m/s",
    "zPositionFront" "m", "zVelocityFront" "m/s", "rollAngleRear" "rad", "rollRateRear" "rad/s",
    "yVelocityRear" "m/s", "zPositionRear" "m", "zVelocityRear" "m/s",
    "leftFrontWheelAngularSpeed" "rad/s", "rightFrontWheelAngularSpeed" "rad/s",
    "leftRearWheelAngularSpeed" "rad/s", "rightRearWheelAngularSpeed" "rad/s",
    "deltaYf" "m", "deltaYr" "m",
];

const KST: &[Field] = fields![
    "x" "m", "y" "m", "steeringAngle" "rad", "velocity" "m/s", "orientation" "rad",
    "hitch_angle" "rad",
];

impl TrajectoryKind {
    /// Every kind, in the order in which the schema wants them.
    pub const ALL: &'static [Self] = Self::VARIANTS;

    /// Its element, that of one of its states, and the quantities of these.
    fn parts(self) -> (&'static str, &'static str, &'static [Field]) {
        match self {
            Self::PmInput => ("pmInputVector", "pmInput", PM_INPUT),
            Self::Input => ("inputVector", "input", INPUT),
            Self::Pm => ("pmTrajectory", "pmState", PM),
            Self::Ks => ("ksTrajectory", "ksState", KS),
            Self::St => ("stTrajectory", "stState", ST),
            Self::Mb => ("mbTrajectory", "mbState", MB),
            Self::Kst => ("kstTrajectory", "kstState", KST),
        }
    }

    /// The element of the trajectory.
    #[must_use]
    pub fn element(self) -> &'static str {
        self.parts().0
    }

    /// The element of one of its states.
    #[must_use]
    pub fn state_element(self) -> &'static str {
        self.parts().1
    }

    /// The quantities of a state besides its time, in the order of commonroad-io.
    #[must_use]
    pub fn fields(self) -> &'static [Field] {
        self.parts().2
    }

    /// Whether it holds what the driver does instead of where the vehicle is.
    #[must_use]
    pub fn is_input(self) -> bool {
        matches!(self, Self::PmInput | Self::Input)
    }

    /// Whether a vehicle of this model can have such a trajectory.
    #[must_use]
    pub fn fits(self, model: VehicleModel) -> bool {
        use VehicleModel::{Ks, Kst, Mb, Pm, St};
        match self {
            Self::PmInput | Self::Pm => model == Pm,
            Self::Input => matches!(model, Ks | St | Mb),
            Self::Ks => model == Ks,
            Self::St => model == St,
            Self::Mb => model == Mb,
            Self::Kst => model == Kst,
        }
    }
}

/// The cost functions that commonroad-io 2026.1 knows.
const COST_FUNCTIONS: [&str; 9] = [
    "JB1", "SA1", "WX1", "SM1", "SM2", "SM3", "MW1", "TR1", "TR2",
];

/// The cost functions that are defined for a point mass.
const POINT_MASS_COSTS: [&str; 3] = ["JB1", "WX1", "MW1"];

/// A benchmark id taken apart.
#[derive(Debug, PartialEq, Eq)]
struct BenchmarkId {
    vehicles: Vec<(VehicleModel, VehicleType)>,
    costs: Vec<String>,
    scenario: String,
    version: String,
}

impl BenchmarkId {
    /// # Errors
    /// It is invalid, and why.
    fn parse(text: &str) -> Result<Self, String> {
        let bare: String = text.chars().filter(|c| !c.is_whitespace()).collect();
        let parts: Vec<&str> = bare.split(':').collect();
        let [vehicles, costs, scenario, version] = parts[..] else {
            return Err(format!(
                "{} parts between colons; expected vehicle, cost function, scenario and version, as in `KS2:SM1:DEU_Test-1_1_T-1:2020a`",
                parts.len()
            ));
        };
        let vehicles: Vec<_> = list(vehicles).map(vehicle).collect::<Result<_, _>>()?;
        let costs: Vec<String> = list(costs).map(str::to_string).collect();
        if let Some(odd) = costs.iter().find(|c| !is_word(c)) {
            return Err(format!("`{odd}` is not a cost function such as `SM1`"));
        }
        if costs.len() != vehicles.len() {
            return Err(format!(
                "{} vehicles but {} cost functions; each vehicle needs one",
                vehicles.len(),
                costs.len()
            ));
        }
        if scenario.is_empty() || version.is_empty() {
            return Err("scenario or version is empty".into());
        }
        if !legal(scenario) || !legal(version) {
            return Err("scenario or version contains control characters".into());
        }
        Ok(Self {
            vehicles,
            costs,
            scenario: scenario.to_string(),
            version: version.to_string(),
        })
    }
}

/// Whether XML can hold a text in an attribute and give it back.
fn legal(text: &str) -> bool {
    !text
        .chars()
        .any(|c| c < ' ' || matches!(c, '\u{fffe}' | '\u{ffff}'))
}

/// Letters and digits, at least one.
fn is_word(text: &str) -> bool {
    !text.is_empty() && text.bytes().all(|b| b.is_ascii_alphanumeric())
}

fn list(text: &str) -> impl Iterator<Item = &str> {
    text.trim_matches(['[', ']']).split(',')
}

fn vehicle(id: &str) -> Result<(VehicleModel, VehicleType), String> {
    let digits = id.find(|c: char| c.is_ascii_digit()).unwrap_or(id.len());
    let (model, number) = id.split_at(digits);
    VehicleModel::parse(model)
        .zip(VehicleType::parse(number))
        .ok_or_else(|| {
            format!(
                "`{id}` is not a vehicle id: a model (PM, KS, ST, MB, KST) and a vehicle from 1 to {}, as in `KS2`",
                VehicleType::ALL.len()
            )
        })
}

/// The id of a solution, with its vehicles in the order in which they are written.
fn compose_benchmark_id(solution: &Solution, order: &[&ProblemSolution]) -> String {
    let joined = |words: Vec<String>| match &words[..] {
        [one] => one.clone(),
        several => format!("[{}]", several.join(",")),
    };
    let vehicles = order.iter().map(|p| p.vehicle_id()).collect();
    let costs = order.iter().map(|p| p.cost.clone()).collect();
    format!(
        "{}:{}:{}:{}",
        joined(vehicles),
        joined(costs),
        solution.scenario_id,
        solution.version
    )
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    #[test]
    fn one_vehicle_and_several() {
        let id = BenchmarkId::parse("KS2:SM1:DEU_Test-1_1_T-1:2020a").unwrap();
        assert_eq!(id.vehicles, [(VehicleModel::Ks, VehicleType::Bmw320i)]);
        assert_eq!(
            (&id.costs[0][..], &id.scenario[..]),
            ("SM1", "DEU_Test-1_1_T-1")
        );
        let id = BenchmarkId::parse("[PM1, KST4]:[JB1,SA1]:C-DEU_Test-1:2020a").unwrap();
        assert_eq!(
            id.vehicles,
            [
                (VehicleModel::Pm, VehicleType::FordEscort),
                (VehicleModel::Kst, VehicleType::Truck)
            ]
        );
        assert_eq!(id.costs, ["JB1", "SA1"]);
    }

    #[test]
    fn what_is_wrong_is_said() {
        for (text, word) in [
            ("", "1 parts"),
            ("KS2:SM1:DEU_Test-1", "3 parts"),
            ("KS9:SM1:X:2020a", "`KS9`"),
            ("XX1:SM1:X:2020a", "`XX1`"),
            ("KS:SM1:X:2020a", "`KS`"),
            ("[KS1,KS2]:SM1:X:2020a", "2 vehicles but 1 cost"),
            ("KS1:S[M:X:2020a", "`S[M`"),
            ("KS1:SM1::2020a", "empty"),
        ] {
            let said = BenchmarkId::parse(text).unwrap_err();
            assert!(said.contains(word), "{text}: {said}");
        }
    }
}
