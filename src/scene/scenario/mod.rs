//! Scenarios: the road network, road users and planning problems; immutable once read.

pub mod identity;
mod jump;
mod names;
mod network;
mod obstacle;
mod planning;
pub mod plausibility;
pub mod prediction;
mod road;
mod scene;
mod signs;
mod summary;
pub mod track;
mod transform;
mod vehicle;

use std::collections::BTreeMap;

pub use identity::{ContentHash, HashedBeginning};
pub use jump::{Jump, driven_way};
pub use names::{
    LaneletType, LineMarking, ObstacleRole, ObstacleType, RoadUser, Signal, SignalColor,
    StateField, TrafficDirection,
};
pub use network::{
    Adjacent, Bound, Incoming, Intersection, Lanelet, LaneletNetwork, LightPhase, Sign,
    SignElement, StopLine, TrafficLight,
};
pub use obstacle::{Obstacle, ObstacleParts, Occupancy, Prediction, SignalState};
pub use planning::{Goal, PlanningProblem, Position, Quantity, State, Steps};
pub use road::{
    Destination, DirectedLanelet, Direction, DrivableArea, Lane, LaneGraph, LaneRelation,
    LaneRelations, Leg, Route, RouteError, Side,
};
pub use scene::{
    Ego, EgoSource, Participant, RecordedEgo, Scene, SceneError, Window, WindowEnd, WindowRule,
    obstacle_taken,
};
pub use signs::SignMeaning;
pub use summary::{alike, in_short};
pub use track::{DerivedCounts, LONGEST_TRACK, Motion, Sample, Track};
pub use transform::in_frame;
pub use transform::{Transform, TransformError, Transformed};
pub use vehicle::{HumanLimits, VehicleModel, VehicleType};

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
