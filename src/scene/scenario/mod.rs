//! Scenarios: the road network, road users and planning problems; immutable once read.

mod crop;
mod difference;
pub mod identity;
mod network;
mod obstacle;
mod planning;
pub mod plausibility;
pub mod prediction;
mod references;
mod road;
mod scene;
mod summary;
pub mod track;
mod transform;
mod vehicle;

pub use crop::{Around, AroundError, Centre, Crop, CropError, Cropped};
pub use difference::{Changed, Differences, ElementDifferences, FieldDifference};
pub use identity::{ContentHash, HashedBeginning};
pub use network::{
    Adjacent, Bound, Incoming, Intersection, Lanelet, LaneletNetwork, LightPhase, Sign,
    SignElement, SignMeaning, StopLine, TrafficLight,
};
pub use obstacle::{Obstacle, ObstacleParts, Occupancy, Prediction, SignalState};
pub use planning::{Goal, PlanningProblem, Position, Quantity, State, Steps};
pub use references::Referable;
pub use road::{
    Destination, DirectedLanelet, Direction, DrivableArea, Lane, LaneGraph, LaneRelation,
    LaneRelations, Leg, Route, RouteError, Side,
};
pub use scene::{
    Ego, EgoSource, Participant, RecordedEgo, Scene, SceneError, Window, WindowEnd, WindowRule,
    obstacle_taken,
};
pub use summary::{alike, in_short};
pub use track::{DerivedCounts, Jump, LONGEST_TRACK, Motion, Sample, Track, driven_way};
pub use transform::{Transform, TransformError, Transformed, in_frame};
pub use vehicle::{HumanLimits, VehicleModel, VehicleType};

use std::collections::BTreeMap;

/// One scenario: a map with traffic on it and a planning problem.
#[derive(Debug, Clone, PartialEq)]
pub struct Scenario {
    /// Author, date and source.
    pub header: Header,
    /// The location on Earth, as far as the file gives it.
    pub location: Option<Location>,
    /// The tags, as written (`urban`, `intersection`, …).
    pub tags: Vec<String>,
    /// The road.
    pub network: LaneletNetwork,
    /// All obstacles, in the file's order.
    pub obstacles: Vec<Obstacle>,
    /// The ego's planning problems; usually one.
    pub planning_problems: Vec<PlanningProblem>,
    /// The ego of a recording; CommonRoad files have none in them.
    pub recorded_ego: Option<RecordedEgo>,
    /// Assumptions and omissions made while reading.
    pub diagnostics: Vec<Diagnostic>,
    /// Hash of the bytes it was read from; of several files, of one after the other.
    pub hash: ContentHash,
}

/// The attributes of a scenario file's root.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Header {
    /// The benchmark id, e.g. `DEU_Bremen-1_10_T-1`.
    pub benchmark_id: String,
    /// The format that it was read from, where that is not CommonRoad.
    pub other_format: Option<&'static str>,
    /// The format's version, e.g. `2020a`; where another format was read, the one that is written.
    pub version: String,
    /// Seconds between two time steps.
    pub time_step_size: f64,
    /// Author, affiliation, source, date and the other attributes of the root.
    pub attributes: BTreeMap<String, String>,
}

/// Where a scenario takes place.
#[derive(Debug, Clone, PartialEq, Default, serde::Serialize)]
pub struct Location {
    /// Id in the GeoNames database.
    pub geo_name_id: Option<i64>,
    /// Degrees north.
    #[serde(rename = "gps_latitude")]
    pub latitude: Option<f64>,
    /// Degrees east.
    #[serde(rename = "gps_longitude")]
    pub longitude: Option<f64>,
    /// How the map's coordinates lie on the Earth.
    #[serde(rename = "geo_transformation")]
    pub transformation: Option<GeoTransformation>,
    /// Time of day, weather, and whether it is under the ground.
    pub environment: Option<Environment>,
}

/// How a map's coordinates lie on the Earth.
#[derive(Debug, Clone, PartialEq, Default, serde::Serialize)]
pub struct GeoTransformation {
    /// Projection, as a PROJ string or a code.
    #[serde(rename = "geo_reference")]
    pub reference: Option<String>,
    /// Shift along x, metres.
    #[serde(rename = "x_translation")]
    pub x: Option<f64>,
    /// Shift along y, metres.
    #[serde(rename = "y_translation")]
    pub y: Option<f64>,
    /// Turn about z, radians.
    #[serde(rename = "z_rotation")]
    pub rotation: Option<f64>,
    /// Scale.
    pub scaling: Option<f64>,
}

/// The surroundings of a scenario, in the words of the file.
#[derive(Debug, Clone, PartialEq, Eq, Default, serde::Serialize)]
pub struct Environment {
    /// Clock time, `hh:mm:ss`.
    pub time: Option<String>,
    /// Day, night, and so on.
    pub time_of_day: Option<String>,
    /// Weather.
    pub weather: Option<String>,
    /// Whether it is under the ground.
    pub underground: Option<String>,
}

/// A note on an assumption or omission made while reading.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct Diagnostic {
    /// How much it matters.
    pub severity: Severity,
    /// Line in the file, from 1; 0 where the file has no lines.
    pub line: usize,
    /// The element, or in protobuf the field, as a path; may be empty.
    pub element: String,
    /// The problem, and the assumption made.
    pub message: String,
}

impl std::fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}: ", self.severity)?;
        match (self.line, self.element.as_str()) {
            (0, "") => {}
            (0, field) => write!(f, "{field}: ")?,
            (line, "") => write!(f, "line {line}: ")?,
            (line, element) => write!(f, "line {line}: <{element}>: ")?,
        }
        f.write_str(&self.message)
    }
}

/// How much a diagnostic matters.
#[derive(Debug, Clone, Copy, PartialEq, Hash, Eq, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// Unusual, and without effect.
    Note,
    /// It stands in the file and nothing is made of it.
    Unused,
    /// Something was assumed or left out.
    Warning,
}

impl std::fmt::Display for Severity {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Note => "note",
            Self::Unused => "not used",
            Self::Warning => "warning",
        })
    }
}

impl Scenario {
    /// The obstacle with this id.
    #[must_use]
    pub fn obstacle(&self, id: i64) -> Option<&Obstacle> {
        self.obstacles.iter().find(|o| o.id == id)
    }

    /// Seconds between two time steps.
    #[must_use]
    pub fn dt(&self) -> f64 {
        self.header.time_step_size
    }
}

/// Defines an enumeration whose variants have the names that files use.
macro_rules! names {
    ($(#[$doc:meta])* $name:ident { $($variant:ident = $text:literal),+ $(,)? }) => {
        $(#[$doc])*
        #[allow(missing_docs, reason = "a variant's name is the word of the format")]
        #[derive(
            Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, strum::Display, strum::IntoStaticStr,
            strum::VariantArray,
        )]
        pub enum $name { $(#[strum(to_string = $text)] $variant),+ }

        nearmiss_record::named!($name, "word of CommonRoad");
    };
}

names! {
    /// The marking or barrier at the border of a lanelet.
    LineMarking {
        Dashed = "dashed", Solid = "solid", SolidSolid = "solid_solid",
        DashedDashed = "dashed_dashed", SolidDashed = "solid_dashed",
        DashedSolid = "dashed_solid", Curb = "curb", LoweredCurb = "lowered_curb",
        BroadDashed = "broad_dashed", BroadSolid = "broad_solid",
        NoMarking = "no_marking", Unknown = "unknown",
    }
}

names! {
    /// The kind of road that a lanelet is part of.
    LaneletType {
        Urban = "urban", Country = "country", Highway = "highway", Interstate = "interstate",
        Parking = "parking", DriveWay = "driveWay", MainCarriageWay = "mainCarriageWay",
        AccessRamp = "accessRamp", ExitRamp = "exitRamp", Shoulder = "shoulder",
        BusLane = "busLane", BusStop = "busStop", BicycleLane = "bicycleLane",
        Sidewalk = "sidewalk", Crosswalk = "crosswalk", Restricted = "restricted",
        RestrictedArea = "restricted_area", Intersection = "intersection", Border = "border",
        Tram = "tram", Unknown = "unknown",
    }
}

names! {
    /// Road users that may use a lanelet.
    RoadUser {
        Vehicle = "vehicle", Car = "car", Truck = "truck", Bus = "bus",
        Motorcycle = "motorcycle", Bicycle = "bicycle", Pedestrian = "pedestrian",
        PriorityVehicle = "priorityVehicle", Train = "train", Taxi = "taxi",
    }
}

names! {
    /// The type of an obstacle.
    ObstacleType {
        Unknown = "unknown", Car = "car", Truck = "truck", Bus = "bus", Bicycle = "bicycle",
        Pedestrian = "pedestrian", PriorityVehicle = "priorityVehicle",
        ParkedVehicle = "parkedVehicle", ConstructionZone = "constructionZone", Train = "train",
        RoadBoundary = "roadBoundary", Motorcycle = "motorcycle", Taxi = "taxi",
        Building = "building", Pillar = "pillar", MedianStrip = "median_strip",
    }
}

impl ObstacleType {
    /// Its name for people: `parked vehicle` for `parkedVehicle`.
    #[must_use]
    pub fn words(self) -> String {
        let mut words = String::new();
        for letter in self.to_string().chars() {
            match letter {
                '_' => words.push(' '),
                'A'..='Z' => words.extend([' ', letter.to_ascii_lowercase()]),
                _ => words.push(letter),
            }
        }
        words
    }
}

names! {
    /// The part an obstacle plays.
    ObstacleRole {
        Static = "static", Dynamic = "dynamic", Phantom = "phantom", Environment = "environment",
    }
}

names! {
    /// A colour of a traffic light.
    SignalColor {
        Red = "red", Yellow = "yellow", RedYellow = "redYellow", Green = "green",
        Inactive = "inactive",
    }
}

names! {
    /// The signals of a vehicle.
    Signal {
        Horn = "horn", IndicatorLeft = "indicatorLeft", IndicatorRight = "indicatorRight",
        BrakingLights = "brakingLights", HazardWarningLights = "hazardWarningLights",
        FlashingBlueLights = "flashingBlueLights",
    }
}

names! {
    /// The directions a traffic light is for.
    TrafficDirection {
        Right = "right", Straight = "straight", Left = "left", LeftStraight = "leftStraight",
        StraightRight = "straightRight", LeftRight = "leftRight", All = "all",
    }
}

names! {
    /// A quantity of a state beyond time and position. Metres, radians, seconds.
    StateField {
        Orientation = "orientation", Velocity = "velocity", Acceleration = "acceleration",
        YawRate = "yawRate", SlipAngle = "slipAngle", SteeringAngle = "steeringAngle",
        SteeringAngleSpeed = "steeringAngleSpeed", VelocityY = "velocityY",
        AccelerationY = "accelerationY", RollAngle = "rollAngle", RollRate = "rollRate",
        PitchAngle = "pitchAngle", PitchRate = "pitchRate", PositionZ = "positionZ",
        VelocityZ = "velocityZ", RollAngleFront = "rollAngleFront",
        RollRateFront = "rollRateFront", VelocityYFront = "velocityYFront",
        PositionZFront = "positionZFront", VelocityZFront = "velocityZFront",
        RollAngleRear = "rollAngleRear", RollRateRear = "rollRateRear",
        VelocityYRear = "velocityYRear", PositionZRear = "positionZRear",
        VelocityZRear = "velocityZRear",
        LeftFrontWheelAngularSpeed = "leftFrontWheelAngularSpeed",
        RightFrontWheelAngularSpeed = "rightFrontWheelAngularSpeed",
        LeftRearWheelAngularSpeed = "leftRearWheelAngularSpeed",
        RightRearWheelAngularSpeed = "rightRearWheelAngularSpeed",
        DeltaYFront = "deltaYFront", DeltaYRear = "deltaYRear", Curvature = "curvature",
        CurvatureChange = "curvatureChange", Jerk = "jerk", Jounce = "jounce",
        HitchAngle = "hitchAngle", CurvatureRate = "curvatureRate",
        FrontWheelAngularSpeed = "frontWheelAngularSpeed",
        RearWheelAngularSpeed = "rearWheelAngularSpeed",
        LongitudinalPosition = "longitudinalPosition", LateralPosition = "lateralPosition",
        JerkDot = "jerkDot", KappaDotDot = "kappaDotDot",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_reads_back() {
        for marking in LineMarking::ALL {
            assert_eq!(LineMarking::parse(marking.name()), Some(marking));
        }
        for field in StateField::ALL {
            assert_eq!(StateField::parse(field.name()), Some(field));
        }
        assert_eq!(ObstacleType::parse("spaceship"), None);
    }
}
