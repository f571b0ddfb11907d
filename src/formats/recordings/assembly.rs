//! Puts the tracks and the map of a recording together to a scenario with its ego and a planning problem.

use std::collections::{BTreeMap, HashSet};

use nearmiss_base::geometry::{Footprint, Point, Shape};
use nearmiss_scene::scenario::plausibility;
use nearmiss_scene::scenario::plausibility::{ElementRef, refused_time_step};
use nearmiss_scene::scenario::{
    ContentHash, Goal, Header, Intersection, Lanelet, LaneletNetwork, Location, Obstacle,
    ObstacleParts, ObstacleRole, ObstacleType, PlanningProblem, Position, Prediction, Quantity,
    RecordedEgo, Scenario, Sign, State, StateField, Steps, TrafficLight,
};

use super::Report;
use crate::commonroad::ReadError;
use crate::commonroad::builder::{ScenarioBuilder, SourceLocation, Target, Targets};

/// The map of a recording.
#[derive(Default)]
pub struct Map {
    pub lanelets: Vec<Lanelet>,
    pub signs: Vec<Sign>,
    pub lights: Vec<TrafficLight>,
    pub intersections: Vec<Intersection>,
    /// Outlines of what can be driven on beside the lanelets.
    pub areas: Vec<Vec<Point>>,
}

/// A road user of a recording.
pub struct RecordedTrack {
    /// Unique among tracks and map.
    pub id: i64,
    pub kind: ObstacleType,
    /// Metres.
    pub length: f64,
    /// Metres.
    pub width: f64,
    /// Its body, where that is known to be no box; the places of its states are those that it is told from.
    pub shape: Option<Shape>,
    /// Whether it stands at its place for ever.
    pub is_static: bool,
    /// At the steps at which it is there, in order.
    pub states: Vec<TrackState>,
}

/// A track at a step; the place is the middle of its body.
#[derive(Debug, Clone, Copy)]
pub struct TrackState {
    pub step: i64,
    pub position: Point,
    /// Radians, counterclockwise from the x-axis.
    pub heading: f64,
    /// m/s along the heading.
    pub velocity: Option<f64>,
    /// m/s² along the heading.
    pub acceleration: Option<f64>,
}

/// Everything about a recording but its map and tracks.
pub struct About {
    /// The data set, as scenarios name their source.
    pub source: &'static str,
    pub benchmark_id: String,
    /// Seconds.
    pub time_step_size: f64,
    pub tags: Vec<String>,
    /// The track that is the ego.
    pub ego: Option<i64>,
    pub hash: ContentHash,
}

impl About {
    /// A recording without an ego of its own, of which nothing is hashed.
    pub fn bare(
        source: &'static str,
        benchmark_id: impl Into<String>,
        time_step_size: f64,
    ) -> Self {
        Self {
            source,
            benchmark_id: benchmark_id.into(),
            time_step_size,
            tags: Vec::new(),
            ego: None,
            hash: ContentHash::digest(b""),
        }
    }
}

/// The scenario of a recording.
///
/// # Errors
/// Its time step or a shape is impossible.
pub fn assemble(
    report: Report,
    about: About,
    map: Map,
    tracks: Vec<RecordedTrack>,
) -> Result<Scenario, ReadError> {
    let dt = about.time_step_size;
    if let Some(why) = refused_time_step(dt) {
        return Err(report.at("time step").fail(format!("`{dt}` {why}")));
    }
    let mut builder = ScenarioBuilder::default();
    builder.location = Some(Location::default());
    builder.tags = about.tags;
    for lanelet in map.lanelets {
        let at = report.at(format!("lane {}", lanelet.id));
        builder.lanelet(&at, lanelet);
    }
    for sign in map.signs {
        let at = report.at(format!("sign {}", sign.id));
        builder.sign(&at, sign);
    }
    for light in map.lights {
        let at = report.at(format!("light {}", light.id));
        builder.light(&at, light);
    }
    for intersection in map.intersections {
        let at = report.at(format!("intersection {}", intersection.id));
        builder.intersection(&at, intersection);
    }
    let mut own = None;
    for track in tracks {
        let at = report.at(format!("track {}", track.id));
        if track.states.is_empty() {
            at.warn("no state; left out");
            continue;
        }
        let parts = parts(&report, track)?;
        if about.ego == Some(parts.id) {
            own = Some(parts);
        } else {
            builder.obstacle(&at, parts);
        }
    }
    if let Some(own) = &own {
        let at = report.at(format!("track {}", own.id));
        builder.problem(&at, problem(own));
    }
    let attributes = [
        ("author", ""),
        ("affiliation", ""),
        ("source", about.source),
    ];
    let header = Header {
        benchmark_id: about.benchmark_id,
        other_format: Some(about.source),
        version: "2020a".into(),
        time_step_size: dt,
        attributes: BTreeMap::from(attributes.map(|(k, v)| (k.to_string(), v.to_string()))),
    };
    let mut scenario = builder.finish(header, about.hash);
    scenario.network.areas = map.areas;
    scenario.recorded_ego = own.map(|parts| RecordedEgo {
        obstacle: Obstacle::new(parts, dt),
        file: report.file().to_string(),
    });
    check_references(&report, &scenario.network);
    for finding in plausibility::check(&scenario) {
        let element = element(finding.about, &scenario);
        report.push(finding.severity, element, finding.message);
    }
    scenario.diagnostics = report.into_diagnostics();
    Ok(scenario)
}

fn parts(report: &Report, track: RecordedTrack) -> Result<ObstacleParts, ReadError> {
    let at = report.at(format!("track {}", track.id));
    let (length, width) = (at.size(track.length)?, at.size(track.width)?);
    let shape = track
        .shape
        .unwrap_or_else(|| Shape::rectangle(length, width));
    let footprint = match Footprint::new(shape) {
        Ok(footprint) => Some(footprint),
        Err(error) => {
            at.leave_out(&error)?;
            None
        }
    };
    let mut states = track.states.into_iter().map(state);
    let initial = states.next();
    let later: Vec<State> = states.collect();
    Ok(ObstacleParts {
        id: track.id,
        role: if track.is_static {
            ObstacleRole::Static
        } else {
            ObstacleRole::Dynamic
        },
        kind: track.kind,
        footprint,
        initial,
        prediction: if later.is_empty() {
            Prediction::None
        } else {
            Prediction::Trajectory(later)
        },
        signals: Vec::new(),
    })
}

fn state(of: TrackState) -> State {
    State {
        position: Some(Position::Point(of.position)),
        orientation: Some(Quantity::Exact(of.heading)),
        velocity: of.velocity.map(Quantity::Exact),
        acceleration: of.acceleration.map(Quantity::Exact),
        ..State::at(Steps::exact(of.step))
    }
}

/// Room around the last recorded place that counts as arrived, metres to the front and back, and to the sides.
const GOAL: (f64, f64) = (10.0, 4.0);

/// So many steps before the end of the recording it may arrive.
const ARRIVAL: i64 = 10;

/// The task that the track solves: from its first state to where it ends, by the end of the recording.
fn problem(own: &ObstacleParts) -> PlanningProblem {
    let first = own.initial.clone();
    let mut initial = first.unwrap_or_else(|| State::at(Steps::exact(0)));
    initial.velocity.get_or_insert(Quantity::Exact(0.0));
    // What CommonRoad requires of the start of a problem.
    for field in [StateField::YawRate, StateField::SlipAngle] {
        initial.more.push((field, Quantity::Exact(0.0)));
    }
    let last = match &own.prediction {
        Prediction::Trajectory(states) => states.last(),
        _ => None,
    };
    let goals = last.and_then(|last| {
        let region = Shape::Rectangle {
            length: GOAL.0,
            width: GOAL.1,
            center: last.point()?,
            orientation: last.orientation?.middle(),
            origin_x_shift: 0.0,
        };
        Some(Goal {
            time: Steps {
                // One that stands at first must not be there at once.
                from: (last.time.to - ARRIVAL).max(initial.time.from + 1),
                to: last.time.to,
            },
            positions: vec![Position::Region(region)],
            orientation: None,
            velocity: None,
        })
    });
    PlanningProblem {
        id: own.id,
        initial,
        goals: goals.into_iter().collect(),
    }
}

/// Warns of lanes that continue into, or lie beside, what is not there.
fn check_references(report: &Report, network: &LaneletNetwork) {
    let known = Targets::new(network);
    for lanelet in &network.lanelets {
        let beside = [&lanelet.adjacent_left, &lanelet.adjacent_right]
            .into_iter()
            .flatten()
            .map(|a| &a.id);
        let all = lanelet.predecessors.iter().chain(&lanelet.successors);
        for id in all
            .chain(beside)
            .filter(|id| !known.has(Target::Lanelet, **id))
        {
            let at = report.at(format!("lane {}", lanelet.id));
            at.warn(format!("refers to missing lane {id}"));
        }
    }
}

/// The element of a finding, by the ids that the recording gives.
fn element(about: ElementRef, scenario: &Scenario) -> String {
    let network = &scenario.network;
    let track = |i: usize| scenario.obstacles.get(i).map_or(0, |o| o.id);
    match about {
        ElementRef::Scenario | ElementRef::Location => String::new(),
        ElementRef::Lanelet(i) => format!("lane {}", network.lanelets.get(i).map_or(0, |l| l.id)),
        ElementRef::Sign(i) => format!("sign {}", network.signs.get(i).map_or(0, |s| s.id)),
        ElementRef::Light(i) => format!("light {}", network.lights.get(i).map_or(0, |l| l.id)),
        ElementRef::Intersection(_) => "intersection".into(),
        ElementRef::Obstacle(i) => format!("track {}", track(i)),
        ElementRef::State { obstacle, state } => {
            let states = scenario.obstacles.get(obstacle).map(|o| o.states());
            let step = states
                .and_then(|mut all| all.nth(state))
                .map(|s| s.time.from);
            format!(
                "track {}, step {}",
                track(obstacle),
                step.unwrap_or_default()
            )
        }
        ElementRef::Start(_) | ElementRef::Goal { .. } => "ego".into(),
    }
}

/// How a velocity in the plane goes along a heading: its magnitude, negative where it points backwards, m/s.
pub fn signed_speed(heading: f64, x: f64, y: f64) -> f64 {
    let speed = x.hypot(y);
    if x * heading.cos() + y * heading.sin() < 0.0 {
        -speed
    } else {
        speed
    }
}

/// The heading that a quaternion turns the x-axis to, seen from above, radians.
pub fn yaw([w, x, y, z]: [f64; 4]) -> f64 {
    f64::atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
}

/// The middle one of some numbers; 0 of none.
pub fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    match values.len() {
        0 => 0.0,
        n if n % 2 == 1 => values[n / 2],
        n => f64::midpoint(values[n / 2 - 1], values[n / 2]),
    }
}

/// Gives out ids: the data set's own where they are positive and free.
#[derive(Default)]
pub struct Ids {
    taken: HashSet<i64>,
    next: i64,
}

/// Ids up to this are counted on from.
const LARGEST: i64 = i64::MAX / 2;

impl Ids {
    /// Where the data set uses these ids.
    pub fn beyond(used: impl IntoIterator<Item = i64>) -> Self {
        let used = used.into_iter().filter(|id| *id < LARGEST);
        Self {
            taken: HashSet::new(),
            next: used.max().unwrap_or(0).max(0) + 1,
        }
    }

    /// Takes an id; whether it was free.
    pub fn take(&mut self, id: i64) -> bool {
        self.taken.insert(id)
    }

    /// This id, or a free one where it is taken or none.
    pub fn keep(&mut self, id: i64) -> i64 {
        if id > 0 && self.taken.insert(id) {
            return id;
        }
        self.fresh()
    }

    /// A free id.
    pub fn fresh(&mut self) -> i64 {
        while !self.taken.insert(self.next) {
            self.next += 1;
        }
        self.next
    }
}

/// Vehicles longer than this are trucks, metres, in data sets that have one class for all.
pub const TRUCK_LENGTH: f64 = 7.5;

/// Parts of the names that data sets give to classes of road users, and what they mean; the first one that is there counts.
const CLASSES: [(&str, ObstacleType); 27] = [
    ("motor", ObstacleType::Motorcycle),
    ("pedestrian", ObstacleType::Pedestrian),
    ("person", ObstacleType::Pedestrian),
    ("walker", ObstacleType::Pedestrian),
    ("human", ObstacleType::Pedestrian),
    ("child", ObstacleType::Pedestrian),
    ("adult", ObstacleType::Pedestrian),
    ("bicycle", ObstacleType::Bicycle),
    ("cycl", ObstacleType::Bicycle),
    ("bike", ObstacleType::Bicycle),
    ("scooter", ObstacleType::Bicycle),
    ("construction", ObstacleType::ConstructionZone),
    ("cone", ObstacleType::RoadBoundary),
    ("barrier", ObstacleType::RoadBoundary),
    ("truck", ObstacleType::Truck),
    ("lorry", ObstacleType::Truck),
    ("trailer", ObstacleType::Truck),
    ("heavy", ObstacleType::Truck),
    ("bus", ObstacleType::Bus),
    ("tram", ObstacleType::Train),
    ("train", ObstacleType::Train),
    ("taxi", ObstacleType::Taxi),
    ("ped", ObstacleType::Pedestrian),
    ("car", ObstacleType::Car),
    ("van", ObstacleType::Car),
    ("vehicle", ObstacleType::Car),
    ("auto", ObstacleType::Car),
];

/// The kind that a class means, by its name in English.
pub fn kind_by_class(class: &str) -> ObstacleType {
    let class = class.to_lowercase();
    let found = CLASSES.iter().find(|(part, _)| class.contains(part));
    match class.as_str() {
        "ego" | "av" | "sdc" | "agent" | "host" => ObstacleType::Car,
        "motor_vehicle" | "human_vehicle" | "passenger" => ObstacleType::Car,
        _ => found.map_or(ObstacleType::Unknown, |(_, kind)| *kind),
    }
}

/// The kind of a body of this length and width, metres; a car where they are 0.
pub fn kind_by_size((length, width): (f64, f64)) -> ObstacleType {
    match (length, width) {
        (l, w) if l <= 0.0 || w <= 0.0 => ObstacleType::Car,
        (l, w) if l <= 1.3 && w <= 1.3 => ObstacleType::Pedestrian,
        (l, w) if l <= 2.6 && w <= 1.1 => ObstacleType::Bicycle,
        (l, _) if l > TRUCK_LENGTH => ObstacleType::Truck,
        _ => ObstacleType::Car,
    }
}

/// Length and width that are assumed, metres.
pub fn default_size(kind: ObstacleType) -> (f64, f64) {
    match kind {
        ObstacleType::Car | ObstacleType::Taxi | ObstacleType::PriorityVehicle => (4.6, 1.9),
        ObstacleType::Truck => (8.5, 2.5),
        ObstacleType::Bus => (12.0, 2.6),
        ObstacleType::Motorcycle => (2.1, 0.8),
        ObstacleType::Bicycle => (1.8, 0.7),
        ObstacleType::Pedestrian => (0.6, 0.6),
        ObstacleType::Train => (30.0, 2.7),
        _ => (1.0, 1.0),
    }
}

/// What was assumed, by kind, as in `car 4.6 m × 1.9 m`.
pub fn in_words(kinds: impl IntoIterator<Item = ObstacleType>) -> String {
    let mut kinds: Vec<ObstacleType> = kinds.into_iter().collect();
    kinds.sort_unstable();
    kinds.dedup();
    let each = kinds.iter().map(|kind| {
        let (length, width) = default_size(*kind);
        format!("{} {length} m × {width} m", kind.name())
    });
    each.collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ids_are_kept_where_they_are_free() {
        let mut ids = Ids::beyond([7, 9, 3, i64::MAX]);
        assert!(ids.take(7) && ids.take(9) && !ids.take(9));
        assert_eq!(
            [3, 7, 0, -1, 10].map(|id| ids.keep(id)),
            [3, 10, 11, 12, 13]
        );
        assert_eq!(ids.fresh(), 14);
    }

    #[test]
    fn vehicles_of_motors_and_humans_are_cars() {
        for class in ["motor_vehicle", "HUMAN_VEHICLE", "passenger", "agent"] {
            assert_eq!(kind_by_class(class), ObstacleType::Car, "{class}");
        }
        let motorcycle = kind_by_class("vehicle.motorcycle");
        assert_eq!(motorcycle, ObstacleType::Motorcycle);
    }
}
