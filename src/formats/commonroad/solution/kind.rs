//! Trajectory kinds of a solution, and the quantities of their states.

use nearmiss_scene::scenario::VehicleModel;
use nearmiss_scene::scenario::plausibility::limits::{LARGEST_COORDINATE, LARGEST_NUMBER};

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
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
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
    pub const ALL: &'static [Self] = &[
        Self::PmInput,
        Self::Input,
        Self::Pm,
        Self::Ks,
        Self::St,
        Self::Mb,
        Self::Kst,
    ];

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
