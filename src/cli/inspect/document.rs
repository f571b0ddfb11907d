//! A scenario's complete contents as JSON: metres, radians, m/s, time steps, in the format's terms.

use std::collections::{BTreeMap, HashMap};

use nearmiss_base::geometry::{Footprint, Shape};
use nearmiss_formats::{EgoError, Entry};
use nearmiss_scene::scenario::{
    Destination, Diagnostic, Direction, Ego, Goal, Intersection, Lanelet, LaneletNetwork, Leg,
    Location, Motion, Obstacle, ObstacleRole, ObstacleType, Occupancy, PlanningProblem, Position,
    Prediction, Quantity, RoadUser, Route, RouteError, Scenario, Side, Sign, SignalState, State,
    Steps, TrafficLight, identity,
};
use nearmiss_workflow::ScenarioRow;
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;

/// A scenario.
#[derive(Serialize, JsonSchema)]
pub struct ScenarioDocument<'s> {
    scenario: &'s str,
    file: String,
    benchmark_id: String,
    /// Benchmark id as in the file.
    benchmark_id_as_written: &'s str,
    /// Version of the format.
    version: &'s str,
    /// Seconds between steps.
    time_step_size: f64,
    /// Attributes of the root element.
    attributes: &'s BTreeMap<String, String>,
    /// Location.
    #[schemars(with = "Option<Value>")]
    location: Option<&'s Location>,
    /// Tags.
    tags: &'s [String],
    /// Hash of the content.
    hash: String,
    /// Lanelets.
    #[schemars(with = "Vec<Value>")]
    lanelets: &'s [Lanelet],
    /// Traffic signs.
    #[schemars(with = "Vec<Value>")]
    traffic_signs: Vec<Referred<'s, Sign>>,
    /// Traffic lights.
    #[schemars(with = "Vec<Value>")]
    traffic_lights: Vec<Referred<'s, TrafficLight>>,
    /// Intersections.
    #[schemars(with = "Vec<Value>")]
    intersections: &'s [Intersection],
    /// Obstacles with their motion.
    #[schemars(with = "Vec<Value>")]
    obstacles: Vec<ObstacleDocument<'s>>,
    /// Planning problems.
    #[schemars(with = "Vec<Value>")]
    planning_problems: Vec<ProblemDocument<'s>>,
    /// The ego: id, source, steps and states; or the error of reading it.
    #[schemars(with = "Option<Value>")]
    ego: Option<EgoDocument<'s>>,
    /// The row that the scenario has among several: the moment that matters, and what is most dangerous.
    row: Option<&'s ScenarioRow>,
    /// Route of each planning problem.
    #[schemars(with = "Vec<Value>")]
    routes: Vec<RouteDocument>,
    #[schemars(with = "Vec<Value>")]
    diagnostics: &'s [Diagnostic],
}

/// An obstacle: type, states, occupancy sets and signals.
#[derive(Serialize)]
struct ObstacleDocument<'s> {
    id: i64,
    role: ObstacleRole,
    r#type: ObstacleType,
    shape: Option<&'s Shape>,
    prediction: Option<&'static str>,
    states: Vec<StateDocument<'s>>,
    occupancies: usize,
    occupancy_set: &'s [Occupancy],
    signal_series: &'s [SignalState],
}

/// A planning problem: the initial state of the ego, and goals with their regions.
#[derive(Serialize)]
struct ProblemDocument<'s> {
    id: i64,
    initial: StateDocument<'s>,
    goals: Vec<GoalDocument<'s>>,
}

/// `positions` are alternatives; `lanelets` are those among them.
#[derive(Serialize)]
struct GoalDocument<'s> {
    #[serde(flatten)]
    goal: &'s Goal,
    lanelets: Vec<i64>,
}

#[derive(Serialize)]
#[serde(untagged)]
enum EgoDocument<'s> {
    Recorded {
        id: i64,
        source: String,
        /// First and last.
        steps: (i64, i64),
        states: Vec<StateDocument<'s>>,
        diagnostics: &'s [Diagnostic],
    },
    Unreadable {
        error: String,
    },
}

impl<'s> ScenarioDocument<'s> {
    pub fn new(
        entry: &'s Entry,
        scenario: &'s Scenario,
        ego: &'s Result<Option<Ego>, EgoError>,
        row: Option<&'s ScenarioRow>,
    ) -> Self {
        let (header, network) = (&scenario.header, &scenario.network);
        let references = References::from_network(network);
        let (signs, lights) = (network.signs.iter(), network.lights.iter());
        Self {
            scenario: &entry.name,
            file: entry.display(),
            benchmark_id: identity::normalized(&header.benchmark_id).into_owned(),
            benchmark_id_as_written: &header.benchmark_id,
            version: &header.version,
            time_step_size: header.time_step_size,
            attributes: &header.attributes,
            location: scenario.location.as_ref(),
            tags: &scenario.tags,
            hash: nearmiss_workflow::tables::short_hash(&scenario.hash),
            lanelets: &network.lanelets,
            traffic_signs: signs.map(|sign| references.to_sign(sign)).collect(),
            traffic_lights: lights.map(|light| references.to_light(light)).collect(),
            intersections: &network.intersections,
            obstacles: scenario.obstacles.iter().map(obstacle).collect(),
            planning_problems: scenario.planning_problems.iter().map(problem).collect(),
            ego: ego_document(ego),
            row,
            routes: RouteDocument::all(scenario),
            diagnostics: &scenario.diagnostics,
        }
    }
}

fn ego_document(ego: &Result<Option<Ego>, EgoError>) -> Option<EgoDocument<'_>> {
    match ego {
        Ok(ego) => ego.as_ref().map(|ego| EgoDocument::Recorded {
            id: ego.id,
            source: ego.source.to_string(),
            steps: (ego.track.steps().start, ego.track.steps().end - 1),
            states: ego
                .track
                .iter()
                .map(|(step, motion)| StateDocument::recorded(step, motion))
                .collect(),
            diagnostics: &ego.diagnostics,
        }),
        Err(error) => Some(EgoDocument::Unreadable {
            error: error.to_string(),
        }),
    }
}

fn obstacle(obstacle: &Obstacle) -> ObstacleDocument<'_> {
    let (prediction, occupancies) = match &obstacle.prediction {
        Prediction::None => (None, &[][..]),
        Prediction::Trajectory(_) => (Some("trajectory"), &[][..]),
        Prediction::Occupancies(occupancies) => (Some("occupancy_set"), occupancies.as_slice()),
    };
    let first = obstacle.initial.iter().map(StateDocument::initial);
    let later = obstacle.states().skip(first.len()).map(StateDocument::new);
    ObstacleDocument {
        id: obstacle.id,
        role: obstacle.role,
        r#type: obstacle.kind,
        shape: obstacle.footprint.as_ref().map(Footprint::shape),
        prediction,
        states: first.chain(later).collect(),
        occupancies: occupancies.len(),
        occupancy_set: occupancies,
        signal_series: &obstacle.signals,
    }
}

fn problem(problem: &PlanningProblem) -> ProblemDocument<'_> {
    ProblemDocument {
        id: problem.id,
        initial: StateDocument::initial(&problem.initial),
        goals: problem
            .goals
            .iter()
            .map(|goal| GoalDocument {
                goal,
                lanelets: goal.lanelets(),
            })
            .collect(),
    }
}

/// A state with `x` and `y`, or with the `position` in which it is uncertain where it is; `time_step` is the first,
/// and `time_interval` is there where it is uncertain when.
#[derive(Default, Serialize)]
struct StateDocument<'s> {
    time_step: i64,
    #[serde(skip_serializing_if = "Option::is_none")]
    x: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    y: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    position: Option<&'s Position>,
    #[serde(skip_serializing_if = "Option::is_none")]
    time_interval: Option<Steps>,
    #[serde(skip_serializing_if = "Option::is_none")]
    orientation: Option<Quantity>,
    #[serde(skip_serializing_if = "Option::is_none")]
    velocity: Option<Quantity>,
    #[serde(skip_serializing_if = "Option::is_none")]
    acceleration: Option<Quantity>,
    #[serde(flatten)]
    more: BTreeMap<&'static str, Quantity>,
    /// What an initial state does not say and is 0 therefore.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    not_said: Vec<&'static str>,
}

impl<'s> StateDocument<'s> {
    fn new(state: &'s State) -> Self {
        let (time, point) = (state.time, state.point());
        let velocity = state.point_mass_velocity();
        let direction = velocity.map(|v| Quantity::Exact(v.y.atan2(v.x)));
        let more = state.more.iter();
        Self {
            time_step: time.from,
            x: point.map(|p| p.x),
            y: point.map(|p| p.y),
            position: state.position.as_ref().filter(|_| point.is_none()),
            time_interval: (time.to != time.from).then_some(time),
            orientation: state.orientation.or(direction),
            velocity: state.velocity,
            acceleration: state.acceleration,
            more: more.map(|(field, value)| (field.name(), *value)).collect(),
            not_said: Vec::new(),
        }
    }

    /// An initial state; what it does not say is 0, as the format has it for initial states.
    fn initial(state: &'s State) -> Self {
        let mut document = Self::new(state);
        for (name, value) in [
            ("orientation", &mut document.orientation),
            ("velocity", &mut document.velocity),
        ] {
            if value.is_none() {
                *value = Some(Quantity::Exact(0.0));
                document.not_said.push(name);
            }
        }
        document
    }

    /// A recorded step.
    fn recorded(step: i64, motion: &Motion) -> Self {
        let exact = |value: f64| Some(Quantity::Exact(value));
        Self {
            time_step: step,
            x: Some(motion.pose.position.x),
            y: Some(motion.pose.position.y),
            orientation: exact(motion.pose.heading),
            velocity: exact(motion.velocity),
            acceleration: exact(motion.acceleration),
            ..Self::default()
        }
    }
}

/// References to signs and lights: lanelet ids by the id referred to.
struct References {
    signs: Referring,
    lights: Referring,
}

#[derive(Default)]
struct Referring {
    lanelets: HashMap<i64, Vec<i64>>,
    stop_lines: HashMap<i64, Vec<i64>>,
}

impl References {
    fn from_network(network: &LaneletNetwork) -> Self {
        let mut found = Self {
            signs: Referring::default(),
            lights: Referring::default(),
        };
        for lanelet in &network.lanelets {
            note(&mut found.signs.lanelets, lanelet, &lanelet.signs);
            note(&mut found.lights.lanelets, lanelet, &lanelet.lights);
            if let Some(line) = &lanelet.stop_line {
                note(&mut found.signs.stop_lines, lanelet, &line.signs);
                note(&mut found.lights.stop_lines, lanelet, &line.lights);
            }
        }
        found
    }

    fn to_sign<'n>(&self, sign: &'n Sign) -> Referred<'n, Sign> {
        self.signs.with(sign, sign.id)
    }

    fn to_light<'n>(&self, light: &'n TrafficLight) -> Referred<'n, TrafficLight> {
        self.lights.with(light, light.id)
    }
}

fn note(into: &mut HashMap<i64, Vec<i64>>, lanelet: &Lanelet, ids: &[i64]) {
    for id in ids {
        let referring = into.entry(*id).or_default();
        // A lanelet may refer to the same thing twice.
        if referring.last() != Some(&lanelet.id) {
            referring.push(lanelet.id);
        }
    }
}

/// A sign or light with the lanelets that refer to it.
#[derive(Serialize)]
struct Referred<'n, T> {
    #[serde(flatten)]
    itself: &'n T,
    lanelets: Vec<i64>,
    stop_lines: Vec<i64>,
}

impl Referring {
    fn with<'n, T>(&self, itself: &'n T, id: i64) -> Referred<'n, T> {
        let ids = |to: &HashMap<i64, Vec<i64>>| to.get(&id).cloned().unwrap_or_default();
        Referred {
            itself,
            lanelets: ids(&self.lanelets),
            stop_lines: ids(&self.stop_lines),
        }
    }
}

type Found<'a> = (&'a PlanningProblem, Result<Route, RouteError>);

/// The route of each planning problem for a car.
fn routes(scenario: &Scenario) -> Vec<Found<'_>> {
    if scenario.planning_problems.is_empty() {
        return Vec::new();
    }
    let graph = scenario.network.lane_graph(Some(RoadUser::Car));
    let problems = scenario.planning_problems.iter();
    problems.map(|p| (p, graph.route(p))).collect()
}

/// A line for each planning problem.
pub fn summary(scenario: &Scenario) -> String {
    let line = |(problem, route): Found<'_>| {
        let words = match route {
            Ok(route) => route_note(&route),
            Err(error) => format!("none: {error}"),
        };
        format!("  route       planning problem {}: {words}\n", problem.id)
    };
    routes(scenario).into_iter().map(line).collect()
}

fn route_note(route: &Route) -> String {
    let leg = |leg: &Leg| {
        let change = match leg.change {
            Some(Side::Left) => "change left to ",
            Some(Side::Right) => "change right to ",
            None => "",
        };
        let direction = match leg.driven.direction {
            Direction::Along => "",
            Direction::Against => " against its direction",
        };
        format!("{change}{}{direction}", leg.driven.lanelet)
    };
    let legs: Vec<String> = route.legs.iter().map(leg).collect();
    let destination = match route.destination {
        Destination::RoadAhead => ", the road ahead, as no goal has a position",
        Destination::Goal(_) | Destination::Recording => "",
    };
    format!(
        "lanelets {}, {:.1} m{destination}",
        legs.join(", "),
        route.length()
    )
}

/// The route of a planning problem, or why there is none.
#[derive(Serialize)]
struct RouteDocument {
    planning_problem: i64,
    #[serde(flatten)]
    found: FoundRoute,
}

#[derive(Serialize)]
#[serde(untagged)]
enum FoundRoute {
    Route {
        destination: Destination,
        length: f64,
        legs: Vec<LegDocument>,
        deviation: f64,
    },
    None {
        no_route: String,
    },
}

#[derive(Serialize)]
struct LegDocument {
    lanelet: i64,
    direction: Direction,
    lane_change: Option<Side>,
}

impl RouteDocument {
    /// One for each planning problem.
    fn all(scenario: &Scenario) -> Vec<Self> {
        let document = |(problem, route): Found<'_>| Self {
            planning_problem: problem.id,
            found: match route {
                Ok(route) => FoundRoute::Route {
                    destination: route.destination,
                    length: route.length(),
                    legs: route.legs.iter().map(leg).collect(),
                    deviation: route.path.deviation(),
                },
                Err(error) => FoundRoute::None {
                    no_route: error.to_string(),
                },
            },
        };
        routes(scenario).into_iter().map(document).collect()
    }
}

fn leg(leg: &Leg) -> LegDocument {
    LegDocument {
        lanelet: leg.driven.lanelet,
        direction: leg.driven.direction,
        lane_change: leg.change,
    }
}
