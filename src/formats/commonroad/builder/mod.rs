//! Builds a scenario from the parts translated by the XML and protobuf readers: checks, defaults and diagnostics.

mod numbers;
mod place;
mod references;
mod shapes;
mod times;

use std::collections::HashSet;

pub(crate) use numbers::{
    coordinate, finite, is_needed, optional_quantity, quantity, refused_step, size,
};
pub(crate) use place::{Diagnostics, SourceLocation};
pub(crate) use references::{Target, Targets};
pub(crate) use shapes::{checked, footprint, polygon, semi_trailer_truck, truck, union};
pub(crate) use times::TimeScale;

use super::ReadError;
use super::xml::short;
use nearmiss_base::geometry::Point;
use nearmiss_scene::scenario::{
    Adjacent, Bound, ContentHash, Header, Intersection, Lanelet, LaneletNetwork, LineMarking,
    Location, Obstacle, ObstacleParts, ObstacleRole, PlanningProblem, Prediction, Quantity,
    Scenario, Severity, Sign, State, StateField, TrafficLight, benchmark_id,
};

/// A scenario that is being read, element by element.
#[derive(Default)]
pub(crate) struct ScenarioBuilder {
    pub location: Option<Location>,
    pub tags: Vec<String>,
    pub lanelets: Vec<Lanelet>,
    pub signs: Vec<Sign>,
    lights: Vec<TrafficLight>,
    intersections: Vec<Intersection>,
    obstacles: Vec<ObstacleParts>,
    problems: Vec<PlanningProblem>,
    ids: HashSet<i64>,
}

impl ScenarioBuilder {
    pub fn lanelet(&mut self, at: &impl SourceLocation, lanelet: Lanelet) {
        self.take_id(at, lanelet.id);
        self.lanelets.push(lanelet);
    }

    pub fn sign(&mut self, at: &impl SourceLocation, sign: Sign) {
        if sign.elements.is_empty() {
            at.note(Severity::Note, "a traffic sign without elements");
        }
        self.take_id(at, sign.id);
        self.signs.push(sign);
    }

    pub fn light(&mut self, at: &impl SourceLocation, light: TrafficLight) {
        self.take_id(at, light.id);
        self.lights.push(light);
    }

    pub fn intersection(&mut self, at: &impl SourceLocation, intersection: Intersection) {
        if intersection.incomings.is_empty() {
            at.note(Severity::Note, "an intersection without roads");
        }
        self.take_id(at, intersection.id);
        self.intersections.push(intersection);
    }

    pub fn obstacle(&mut self, at: &impl SourceLocation, mut parts: ObstacleParts) {
        if matches!(parts.role, ObstacleRole::Static | ObstacleRole::Dynamic) {
            // A set says where it is, and which region it covers there.
            let in_a_set =
                matches!(&parts.prediction, Prediction::Occupancies(all) if !all.is_empty());
            if parts.footprint.is_none() && !in_a_set {
                at.warn("no shape; not measured");
            }
            if parts.initial.is_none() && !in_a_set {
                at.warn("no initial state");
            }
        }
        if let Some(message) = parts.uncertainty() {
            at.warn(message);
        }
        if let Some(message) = parts.without_orientation() {
            at.note(Severity::Note, message);
        }
        if !self.ids.insert(parts.id) {
            // Who shares its id with another is there all the same.
            let free = (FREE_IDS..).find(|id| self.ids.insert(*id));
            let new = free.unwrap_or(parts.id);
            at.warn(format!(
                "id {} is used twice; this obstacle is {new}",
                parts.id
            ));
            parts.id = new;
        }
        self.obstacles.push(parts);
    }

    pub fn problem(&mut self, at: &impl SourceLocation, problem: PlanningProblem) {
        if problem.goals.is_empty() {
            at.warn("no goal");
        }
        self.take_id(at, problem.id);
        self.problems.push(problem);
    }

    /// How many different ids there are.
    pub fn count(&self) -> usize {
        self.ids.len()
    }

    /// The largest id of road and traffic: planning problems do not count.
    pub fn largest_id(&self) -> Option<i64> {
        let problems: HashSet<_> = self.problems.iter().map(|p| p.id).collect();
        self.ids.difference(&problems).copied().max()
    }

    /// The scenario, without its diagnostics; the obstacles' motion is worked out for the header's time step.
    pub fn finish(self, header: Header, hash: ContentHash) -> Scenario {
        let obstacles = self.obstacles.into_iter();
        Scenario {
            obstacles: obstacles
                .map(|parts| Obstacle::new(parts, header.time_step_size))
                .collect(),
            header,
            location: self.location,
            tags: self.tags,
            network: LaneletNetwork::new(
                self.lanelets,
                self.signs,
                self.lights,
                self.intersections,
            ),
            planning_problems: self.problems,
            recorded_ego: None,
            diagnostics: Vec::new(),
            hash,
        }
    }

    fn take_id(&mut self, at: &impl SourceLocation, id: i64) {
        if !self.ids.insert(id) {
            at.warn(format!("id {id} is used twice; references mean the first"));
        }
    }
}

/// Ids of obstacles whose own is another's begin here.
const FREE_IDS: i64 = 1_000_000_000;

/// A border of a lanelet; `heights` count where every point has one.
///
/// # Errors
/// It has less than two points.
pub(crate) fn bound(
    at: &impl SourceLocation,
    points: Vec<Point>,
    heights: Vec<f64>,
    marking: LineMarking,
) -> Result<Bound, ReadError> {
    if points.len() < 2 {
        let message = format!("{} points; at least 2 are needed", points.len());
        return Err(at.fail(message));
    }
    let heights = if heights.len() == points.len() {
        heights
    } else {
        Vec::new()
    };
    Ok(Bound {
        points,
        heights,
        marking,
    })
}

/// The lanelet beside one; `same_direction` where the file says which.
pub(crate) fn adjacent(
    at: &impl SourceLocation,
    id: i64,
    same_direction: Option<bool>,
) -> Adjacent {
    if same_direction.is_none() {
        at.warn("the driving direction is neither same nor opposite; taken as same");
    }
    Adjacent {
        id,
        same_direction: same_direction.unwrap_or(true),
    }
}

/// The ends of a stop line; `None` if it lies at the end of its lanelet.
pub(crate) fn stop_line(at: &impl SourceLocation, points: &[Point]) -> Option<(Point, Point)> {
    if !matches!(points.len(), 0 | 2) {
        let taken = if points.len() < 2 {
            "assumed at the end of its lanelet"
        } else {
            "the first two are used"
        };
        let count = points.len();
        at.warn(format!(
            "a stop line with {count} points instead of none or two; {taken}"
        ));
    }
    match points {
        [from, to, ..] => Some((*from, *to)),
        _ => None,
    }
}

/// Gives a state a quantity.
pub(crate) fn set_quantity(state: &mut State, field: StateField, value: Option<Quantity>) {
    match field {
        StateField::Orientation => state.orientation = value,
        StateField::Velocity => state.velocity = value,
        StateField::Acceleration => state.acceleration = value,
        _ => state.more.extend(value.map(|value| (field, value))),
    }
}

/// Notes a benchmark id that does not follow the rule.
pub(crate) fn check_benchmark_id(at: &impl SourceLocation, id: &str) {
    if !benchmark_id::is_valid(id) {
        let message = format!(
            "benchmark id `{}` does not follow the naming scheme",
            short(id)
        );
        at.note(Severity::Note, message);
    }
}
