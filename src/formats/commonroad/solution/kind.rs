//! Trajectory kinds of a solution with the quantities of their states, and its benchmark id.

use strum::VariantArray;

use nearmiss_scene::scenario::plausibility::limits::{LARGEST_COORDINATE, LARGEST_NUMBER};
use nearmiss_scene::scenario::{VehicleModel, VehicleType};

use super::{ProblemSolution, Solution};

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
    pub(super) fn largest(&self) -> f64 {
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

    /// The element of the trajectory.
    #[must_use]
    pub fn element(self) -> &'static str {
        match self {
            Self::PmInput => "pmInputVector",
            Self::Input => "inputVector",
            Self::Pm => "pmTrajectory",
            Self::Ks => "ksTrajectory",
            Self::St => "stTrajectory",
            Self::Mb => "mbTrajectory",
            Self::Kst => "kstTrajectory",
        }
    }

    /// The element of one of its states.
    #[must_use]
    pub fn state_element(self) -> &'static str {
        match self {
            Self::PmInput => "pmInput",
            Self::Input => "input",
            Self::Pm => "pmState",
            Self::Ks => "ksState",
            Self::St => "stState",
            Self::Mb => "mbState",
            Self::Kst => "kstState",
        }
    }

    /// The quantities of a state besides its time, in the order of commonroad-io.
    #[must_use]
    pub fn fields(self) -> &'static [Field] {
        match self {
            Self::PmInput => PM_INPUT,
            Self::Input => INPUT,
            Self::Pm => PM,
            Self::Ks => KS,
            Self::St => ST,
            Self::Mb => MB,
            Self::Kst => KST,
        }
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
pub(super) const COST_FUNCTIONS: [&str; 9] = [
    "JB1", "SA1", "WX1", "SM1", "SM2", "SM3", "MW1", "TR1", "TR2",
];

/// The cost functions that are defined for a point mass.
pub(super) const POINT_MASS_COSTS: [&str; 3] = ["JB1", "WX1", "MW1"];

/// A benchmark id taken apart.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct BenchmarkId {
    pub vehicles: Vec<(VehicleModel, VehicleType)>,
    pub costs: Vec<String>,
    pub scenario: String,
    pub version: String,
}

impl BenchmarkId {
    /// # Errors
    /// It is invalid, and why.
    pub fn parse(text: &str) -> Result<Self, String> {
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
pub(super) fn legal(text: &str) -> bool {
    !text
        .chars()
        .any(|c| c < ' ' || matches!(c, '\u{fffe}' | '\u{ffff}'))
}

/// Letters and digits, at least one.
pub(super) fn is_word(text: &str) -> bool {
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
pub(super) fn compose(solution: &Solution, order: &[&ProblemSolution]) -> String {
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
