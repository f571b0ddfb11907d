//! The road network in `hello`, of the planner protocol.

use schemars::JsonSchema;
use serde::Serialize;

/// The road network.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Road<'a> {
    /// Pieces of lanes.
    pub lanelets: Vec<Lanelet<'a>>,
    /// Traffic signs.
    pub signs: Vec<Sign<'a>>,
    /// Traffic lights; their colours come with each cycle.
    pub lights: Vec<Light>,
    /// Intersections.
    pub intersections: Vec<Intersection<'a>>,
}

/// A piece of a lane, driven from the first points of its bounds to the last ones.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Lanelet<'a> {
    /// Unique.
    pub id: i64,
    /// Bound on the left, points in metres.
    pub left: Vec<[f64; 2]>,
    /// Bound on the right.
    pub right: Vec<[f64; 2]>,
    /// Marking of the left bound, in the words of CommonRoad.
    pub left_marking: &'static str,
    /// Marking of the right bound.
    pub right_marking: &'static str,
    /// Lanelets that end where it begins.
    pub predecessors: &'a [i64],
    /// Lanelets that begin where it ends.
    pub successors: &'a [i64],
    /// The neighbour on the left.
    pub left_neighbour: Option<Neighbour>,
    /// The neighbour on the right.
    pub right_neighbour: Option<Neighbour>,
    /// Types of road, in the words of CommonRoad.
    pub types: Vec<&'static str>,
    /// Road users in its direction, in the words of CommonRoad.
    pub users_one_way: Vec<&'static str>,
    /// Road users in both directions.
    pub users_bidirectional: Vec<&'static str>,
    /// The lowest speed limit of its signs, m/s.
    pub speed_limit: Option<f64>,
    /// Ends of its stop line.
    pub stop_line: Option<[[f64; 2]; 2]>,
    /// Signs that hold on it.
    pub signs: &'a [i64],
    /// Lights that hold on it.
    pub lights: &'a [i64],
}

/// A lanelet beside another one.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Neighbour {
    /// Its id.
    pub id: i64,
    /// Whether it is driven in the same direction.
    pub same_direction: bool,
}

/// A traffic sign.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Sign<'a> {
    /// Unique.
    pub id: i64,
    /// Where it stands.
    pub position: Option<[f64; 2]>,
    /// What it says; a post may carry several.
    pub elements: Vec<SignElement<'a>>,
}

/// One sign on a post.
#[derive(Debug, Serialize, JsonSchema)]
pub struct SignElement<'a> {
    /// The country's number, such as `274`.
    pub id: &'a str,
    /// Values on it, such as a speed in m/s.
    pub values: &'a [String],
}

/// A traffic light.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Light {
    /// Unique.
    pub id: i64,
    /// Where it stands.
    pub position: Option<[f64; 2]>,
}

/// An intersection.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Intersection<'a> {
    /// Unique.
    pub id: i64,
    /// Roads that lead in.
    pub incomings: Vec<Incoming<'a>>,
}

/// A road that leads into an intersection.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Incoming<'a> {
    /// Unique.
    pub id: i64,
    /// Its last lanelets.
    pub lanelets: &'a [i64],
    /// Lanelets that turn right.
    pub right: &'a [i64],
    /// Lanelets that go straight on.
    pub straight: &'a [i64],
    /// Lanelets that turn left.
    pub left: &'a [i64],
    /// The incoming to the left of which it is.
    pub is_left_of: Option<i64>,
}
