//! The messages of CommonRoad's protobuf formats, as far as they are read.
//!
//! Numbers and types of fields are those of the schemas in commonroad-io: 2024.3 carries the single message of
//! version 2020a, 2026.1 the three messages of 2024. Where both are the same on the wire there is one message here.
//! Every field is optional: the schema's `required` is checked where a message is turned into a scenario, so that
//! what is missing can be named. Enumerations are kept as numbers, because a number without a word must not be lost.

mod common;
mod information;
mod map;
mod obstacle;
mod place;
mod planning;
mod road;
mod shape;
mod state;

pub(super) use common::{FloatExactOrInterval, IntegerExactOrInterval, Point, TimeStamp};
pub(super) use information::{
    FileInformation, MapId, MapInformation, ScenarioInformation, ScenarioMetaInformation,
};
pub(super) use map::{
    Boundary, IncomingGroup, MapIntersection, MapLanelet, MapLight, MapSign, MapSignElement,
    MapStopLine, SignValue, TrafficLightCycle,
};
pub(super) use obstacle::{
    DynamicObstacle, EnvironmentObstacle, PhantomObstacle, SetBasedPrediction, StaticObstacle,
};
pub(super) use place::{Environment, GeoTransformation, Location};
pub(super) use planning::{GoalState, PlanningProblem, ScenarioTags};
pub(super) use road::{
    CycleElement, Intersection, Lanelet, SignNumber, StopLine, TrafficLight, TrafficSign,
    TrafficSignElement,
};
pub(super) use shape::{
    Body, BodyShape, Circle, Polygon, Rectangle, Region, RegionShape, SemiTrailerTruckShape,
    TruckShape,
};
#[cfg(test)]
pub(super) use shape::{TrailerDims, TruckDims};
pub(super) use state::{SignalState, State};
