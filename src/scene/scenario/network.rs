//! The road: lanelets with their borders and neighbours, signs, lights, intersections.

use std::collections::HashMap;

use serde::{Serialize, Serializer};

use super::road::Index;
use super::{LaneletType, LineMarking, RoadUser, SignalColor, TrafficDirection};
use nearmiss_base::geometry::{Bounds, Point};

/// The lanelets of a scenario, with signs, lights and intersections.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LaneletNetwork {
    /// In the file's order.
    pub lanelets: Vec<Lanelet>,
    /// Traffic signs.
    pub signs: Vec<Sign>,
    /// Traffic lights.
    pub lights: Vec<TrafficLight>,
    /// Intersections.
    pub intersections: Vec<Intersection>,
    pub(super) index: Index,
    places: HashMap<i64, usize>,
    bounds: Vec<Bounds>,
}

/// A piece of lane between two borders, driven from the first to the last points.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Lanelet {
    /// Unique in the scenario.
    pub id: i64,
    /// Border on the left of the driving direction.
    #[serde(flatten, serialize_with = "left_bound")]
    pub left: Bound,
    /// Border on the right.
    #[serde(flatten, serialize_with = "right_bound")]
    pub right: Bound,
    /// Lanelets that end where this one begins.
    pub predecessors: Vec<i64>,
    /// Lanelets that begin where this one ends.
    pub successors: Vec<i64>,
    /// Neighbour on the left.
    pub adjacent_left: Option<Adjacent>,
    /// Neighbour on the right.
    pub adjacent_right: Option<Adjacent>,
    /// Where to stop.
    pub stop_line: Option<StopLine>,
    /// The kinds of road it is part of.
    pub types: Vec<LaneletType>,
    /// Road users that may use it in its direction.
    pub users_one_way: Vec<RoadUser>,
    /// Road users that may use it in both directions.
    pub users_bidirectional: Vec<RoadUser>,
    /// Signs that hold on it.
    #[serde(rename = "traffic_signs")]
    pub signs: Vec<i64>,
    /// Lights that hold on it.
    #[serde(rename = "traffic_lights")]
    pub lights: Vec<i64>,
}

fn left_bound<S: Serializer>(bound: &Bound, to: S) -> Result<S::Ok, S::Error> {
    #[derive(Serialize)]
    struct Left<'a> {
        left_bound: &'a [Point],
        left_line_marking: LineMarking,
        #[serde(skip_serializing_if = "<[f64]>::is_empty")]
        left_heights: &'a [f64],
    }
    let left = Left {
        left_bound: &bound.points,
        left_line_marking: bound.marking,
        left_heights: &bound.heights,
    };
    left.serialize(to)
}

fn right_bound<S: Serializer>(bound: &Bound, to: S) -> Result<S::Ok, S::Error> {
    #[derive(Serialize)]
    struct Right<'a> {
        right_bound: &'a [Point],
        right_line_marking: LineMarking,
        #[serde(skip_serializing_if = "<[f64]>::is_empty")]
        right_heights: &'a [f64],
    }
    let right = Right {
        right_bound: &bound.points,
        right_line_marking: bound.marking,
        right_heights: &bound.heights,
    };
    right.serialize(to)
}

/// One border of a lanelet.
#[derive(Debug, Clone, PartialEq)]
pub struct Bound {
    /// At least two points, in driving direction, metres.
    pub points: Vec<Point>,
    /// Heights of the points, metres; empty where the file has none.
    pub heights: Vec<f64>,
    /// The line marking.
    pub marking: LineMarking,
}

impl Default for Bound {
    fn default() -> Self {
        Self {
            points: Vec::new(),
            heights: Vec::new(),
            marking: LineMarking::Unknown,
        }
    }
}

/// A neighbouring lanelet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Adjacent {
    /// Its id.
    pub id: i64,
    /// Whether it is driven in the same direction.
    pub same_direction: bool,
}

/// A line to stop at.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StopLine {
    /// Its ends; without them it lies at the end of the lanelet.
    pub points: Option<(Point, Point)>,
    /// What is painted there.
    #[serde(rename = "line_marking")]
    pub marking: LineMarking,
    /// Signs it belongs to.
    #[serde(rename = "traffic_signs")]
    pub signs: Vec<i64>,
    /// Lights it belongs to.
    #[serde(rename = "traffic_lights")]
    pub lights: Vec<i64>,
}

/// A traffic sign.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Sign {
    /// Unique in the scenario.
    pub id: i64,
    /// Where it stands.
    pub position: Option<Point>,
    /// Whether it stands only in the map, not on the road.
    #[serde(rename = "virtual")]
    pub is_virtual: bool,
    /// What it says; a post may carry several.
    pub elements: Vec<SignElement>,
}

/// One sign on a post.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct SignElement {
    /// The country's number of the sign, e.g. `274`.
    pub id: String,
    /// Values on it, e.g. a speed in m/s.
    #[serde(rename = "additional_values")]
    pub values: Vec<String>,
}

/// A traffic light.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TrafficLight {
    /// Unique in the scenario.
    pub id: i64,
    /// Where it stands.
    pub position: Option<Point>,
    /// Whether it is switched on.
    pub active: bool,
    /// Whom it is for.
    pub direction: Option<TrafficDirection>,
    /// Time steps before the first phase begins.
    #[serde(rename = "time_offset")]
    pub offset: i64,
    /// Its phases, repeated for ever.
    pub cycle: Vec<LightPhase>,
}

/// One phase of a traffic light.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct LightPhase {
    /// Time steps.
    pub duration: i64,
    /// Colour shown.
    pub color: SignalColor,
}

/// Where roads meet.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Intersection {
    /// Unique in the scenario.
    pub id: i64,
    /// Roads that lead in.
    pub incomings: Vec<Incoming>,
    /// Lanelets of crossings.
    pub crossings: Vec<i64>,
}

/// A road that leads into an intersection.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Incoming {
    /// Unique in the scenario.
    pub id: i64,
    /// Its last lanelets.
    pub lanelets: Vec<i64>,
    /// Lanelets that turn right.
    #[serde(rename = "successors_right")]
    pub right: Vec<i64>,
    /// Lanelets that go straight on.
    #[serde(rename = "successors_straight")]
    pub straight: Vec<i64>,
    /// Lanelets that turn left.
    #[serde(rename = "successors_left")]
    pub left: Vec<i64>,
    /// The incoming to the left of which this one is.
    pub is_left_of: Option<i64>,
}

impl Lanelet {
    /// The region between the borders, as a ring (not closed), whichever way they are drawn.
    #[must_use]
    pub fn ring(&self) -> Vec<Point> {
        let (left, right) = (&self.left.points, &self.right.points);
        let mut ring = Vec::with_capacity(left.len() + right.len());
        ring.extend_from_slice(left);
        if self.borders_disagree() {
            ring.extend(right);
        } else {
            ring.extend(right.iter().rev());
        }
        ring
    }
}

impl LaneletNetwork {
    /// A network of these parts, with its index built.
    #[must_use]
    pub fn new(
        lanelets: Vec<Lanelet>,
        signs: Vec<Sign>,
        lights: Vec<TrafficLight>,
        intersections: Vec<Intersection>,
    ) -> Self {
        // Of several with one id, the first is meant.
        let places = lanelets
            .iter()
            .enumerate()
            .rev()
            .map(|(i, l)| (l.id, i))
            .collect();
        let bounds = lanelets
            .iter()
            .map(|l| {
                let points = l.left.points.iter().chain(&l.right.points);
                Bounds::from_points(points).unwrap_or(Bounds {
                    min: Point::origin(),
                    max: Point::origin(),
                })
            })
            .collect();
        Self {
            lanelets,
            signs,
            lights,
            intersections,
            index: Index::default(),
            places,
            bounds,
        }
    }

    /// The lanelet with this id.
    #[must_use]
    pub fn lanelet(&self, id: i64) -> Option<&Lanelet> {
        self.place(id).map(|place| &self.lanelets[place])
    }

    /// The place in `lanelets` of the one with this id; of several the first.
    #[must_use]
    pub fn place(&self, id: i64) -> Option<usize> {
        self.places.get(&id).copied()
    }

    /// The box around a lanelet, by its place in `lanelets`.
    #[must_use]
    pub fn bounds_of(&self, place: usize) -> Bounds {
        self.bounds[place]
    }

    /// The box around the whole road; `None` if there is no road.
    #[must_use]
    pub fn bounds(&self) -> Option<Bounds> {
        self.bounds.iter().copied().reduce(|a, b| a.union(&b))
    }
}
