//! Builds a scenario from the parts translated by the XML and protobuf readers: checks, defaults, diagnostics.

mod numbers;

pub(crate) use numbers::{
    TimeScale, coordinate, finite, is_needed, optional_quantity, quantity, refused_step, size,
};

use std::cell::{Cell, RefCell};
use std::collections::{BTreeMap, HashSet};

use nearmiss_base::geometry::{Footprint, Point, SemiTrailer, Shape, ShapeError, Truck};
use nearmiss_scene::scenario::{
    Adjacent, Bound, ContentHash, Diagnostic, Header, Intersection, Lanelet, LaneletNetwork,
    LineMarking, Location, Obstacle, ObstacleParts, ObstacleRole, PlanningProblem, Prediction,
    Quantity, Scenario, Severity, Sign, State, StateField, TrafficLight, identity,
};

use super::xml::short;
use nearmiss_base::system;

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
    if !identity::is_valid(id) {
        let message = format!(
            "benchmark id `{}` does not follow the naming scheme",
            short(id)
        );
        at.note(Severity::Note, message);
    }
}

/// Kind of element that a reference points to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Target {
    Lanelet,
    Sign,
    Light,
    Incoming,
}

/// The elements of a network that can be referred to.
pub(crate) struct Targets(HashSet<(Target, i64)>);

impl Targets {
    pub fn new(network: &LaneletNetwork) -> Self {
        let incomings = network
            .intersections
            .iter()
            .flat_map(|i| &i.incomings)
            .map(|i| (Target::Incoming, i.id));
        let lanelets = network.lanelets.iter().map(|l| (Target::Lanelet, l.id));
        let signs = network.signs.iter().map(|s| (Target::Sign, s.id));
        let lights = network.lights.iter().map(|l| (Target::Light, l.id));
        Self(
            lanelets
                .chain(signs)
                .chain(lights)
                .chain(incomings)
                .collect(),
        )
    }

    pub fn has(&self, target: Target, id: i64) -> bool {
        self.0.contains(&(target, id))
    }
}

/// A shape that encloses something; `None` if the format lets it be left out.
///
/// # Errors
/// It encloses nothing, and cannot be left out.
pub(crate) fn checked(at: &impl SourceLocation, shape: Shape) -> Result<Option<Shape>, ReadError> {
    match shape.check() {
        Ok(()) => Ok(Some(shape)),
        Err(error) => at.leave_out(&error).map(|()| None),
    }
}

/// Shapes as one; nothing, with a diagnostic, where there is none.
pub(crate) fn union(at: &impl SourceLocation, shapes: Vec<Shape>) -> Option<Shape> {
    if shapes.is_empty() {
        at.warn("no shape; it covers nothing");
    }
    Shape::union(shapes)
}

/// The body of an obstacle, ready to be measured; `None` if the format lets it be left out.
///
/// # Errors
/// It cannot be measured, and cannot be left out.
pub(crate) fn footprint(
    at: &impl SourceLocation,
    shape: Option<Shape>,
) -> Result<Option<Footprint>, ReadError> {
    match shape.map(Footprint::new).transpose() {
        Ok(footprint) => Ok(footprint),
        Err(error) => at.leave_out(&error).map(|()| None),
    }
}

/// A polygon; the last corner of a closed ring is left out.
pub(crate) fn polygon(mut vertices: Vec<Point>) -> Shape {
    if vertices.len() > 3 && vertices.first() == vertices.last() {
        vertices.pop();
    }
    Shape::Polygon { vertices }
}

/// A truck of length, width, wheelbase, distance from the rear to the rear axle, length of the cabin, and distance
/// from the rear axle to the hitch, metres. Its origin is at the rear axle where `shift` says nothing.
pub(crate) fn truck(dimensions: [f64; 6], shift: Option<f64>) -> Truck {
    let [
        length,
        width,
        wheelbase,
        rear_to_rear_axle,
        cabin_length,
        rear_axle_to_hitch,
    ] = dimensions;
    Truck {
        length,
        width,
        wheelbase,
        rear_to_rear_axle,
        cabin_length,
        rear_axle_to_hitch,
        origin_x_shift: shift.unwrap_or(rear_to_rear_axle - length / 2.0),
    }
}

/// A truck in line with its trailer, which has a length, a width, a wheelbase, and a distance from its front to the
/// hitch, metres.
pub(crate) fn semi_trailer_truck(tractor: Truck, trailer: [f64; 4]) -> Shape {
    let [length, width, wheelbase, front_to_hitch] = trailer;
    let trailer = SemiTrailer {
        length,
        width,
        wheelbase,
        front_to_hitch,
    };
    Shape::SemiTrailerTruck {
        tractor,
        trailer,
        hitch_angle: 0.0,
    }
}

/// A place in a file: an element of XML, a field of protobuf.
pub(crate) trait SourceLocation {
    /// An error about what is here.
    fn fail(&self, message: impl Into<String>) -> ReadError;

    /// Notes something assumed or left out here.
    fn note(&self, severity: Severity, message: impl Into<String>);

    /// Warns of something assumed or left out here.
    fn warn(&self, message: impl Into<String>) {
        self.note(Severity::Warning, message);
    }

    /// Warns of a number that is nearer to 0 than any that is measured.
    fn warn_tiny(&self, value: f64);

    /// Leaves out a shape that encloses nothing.
    ///
    /// # Errors
    /// The format does not let it be left out.
    fn leave_out(&self, error: &ShapeError) -> Result<(), ReadError>;
}

/// More diagnostics than this say nothing new.
const MOST_DIAGNOSTICS: usize = 500;

/// As many kinds of unused elements are told apart; more are counted together.
const MOST_KINDS: usize = 200;

/// How often a kind of element is not used, and the line of the first one.
#[derive(Debug)]
struct Unused {
    line: usize,
    count: usize,
}

/// The diagnostics of a file, in the order in which they are found.
#[derive(Debug, Default)]
pub(crate) struct Diagnostics {
    listed: RefCell<Vec<Diagnostic>>,
    suppressed: Cell<usize>,
    unused: RefCell<BTreeMap<String, Unused>>,
}

impl Diagnostics {
    /// Adds one; `place` is its line and element.
    pub fn push(
        &self,
        severity: Severity,
        place: impl FnOnce() -> (usize, String),
        message: impl Into<String>,
    ) {
        let mut listed = self.listed.borrow_mut();
        if listed.len() >= MOST_DIAGNOSTICS {
            self.suppressed.set(self.suppressed.get() + 1);
            return;
        }
        let (line, element) = place();
        listed.push(Diagnostic {
            severity,
            line,
            element,
            message: message.into(),
        });
    }

    /// Counts what stands in the file and is not used, by its kind: a path of names without ids, such as
    /// `lanelet/userData` or `lane@direction` for an attribute. Every reader accounts so for all that it passes over.
    /// `line` is asked only of the first of a kind; 0 where the file has no lines.
    pub fn unused(&self, kind: impl Into<String>, line: impl FnOnce() -> usize) {
        self.unused_times(kind, 1, line);
    }

    /// The same of so many at once.
    pub fn unused_times(
        &self,
        kind: impl Into<String>,
        count: usize,
        line: impl FnOnce() -> usize,
    ) {
        let mut unused = self.unused.borrow_mut();
        let mut kind = kind.into();
        if unused.len() >= MOST_KINDS && !unused.contains_key(&kind) {
            kind = "other kinds".into();
        }
        match unused.get_mut(&kind) {
            Some(known) => known.count += count,
            None => {
                let line = line();
                unused.insert(kind, Unused { line, count });
            }
        }
    }

    /// All of them, how many are not listed, and what is not used, a kind each.
    pub fn into_list(self) -> Vec<Diagnostic> {
        let mut listed = self.listed.into_inner();
        if self.suppressed.get() > 0 {
            listed.push(Diagnostic {
                severity: Severity::Note,
                line: 0,
                element: String::new(),
                message: format!("{} more like these are not listed", self.suppressed.get()),
            });
        }
        let unused = self.unused.into_inner().into_iter();
        listed.extend(unused.map(|(element, Unused { line, count })| Diagnostic {
            severity: Severity::Unused,
            line,
            element,
            message: format!("{count} ×"),
        }));
        listed
    }
}

impl From<Vec<Diagnostic>> for Diagnostics {
    fn from(listed: Vec<Diagnostic>) -> Self {
        Self {
            listed: listed.into(),
            ..Self::default()
        }
    }
}

/// Why a file is not a scenario.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{file}{}{}: {message}", place(*line, *column), inside(*line, *column, element))]
pub struct ReadError {
    /// Which file.
    pub file: String,
    /// Line from 1; 0 where the file has no lines or could not be read at all.
    pub line: usize,
    /// Column in characters from 1; 0 where only the line is known.
    pub column: usize,
    /// The element, or in protobuf the field, as a path from the root; may be empty.
    pub element: String,
    /// The content found, and what was expected.
    pub message: String,
}

fn place(line: usize, column: usize) -> String {
    match (line, column) {
        (0, _) => String::new(),
        (line, 0) => format!(":{line}"),
        (line, column) => format!(":{line}:{column}"),
    }
}

fn inside(line: usize, column: usize, element: &str) -> String {
    match (line, column, element) {
        (_, _, "") => String::new(),
        (0, _, field) | (_, 0, field) => format!(": in {field}"),
        (_, _, element) => format!(": in <{element}>"),
    }
}

impl ReadError {
    pub(crate) fn io(file: &str, error: &std::io::Error) -> Self {
        Self {
            file: file.to_string(),
            line: 0,
            column: 0,
            element: String::new(),
            message: system::error_text(error),
        }
    }
}
