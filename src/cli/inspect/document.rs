//! A scenario's complete contents as JSON: metres, radians, m/s, time steps, in the format's terms.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;

use super::states::StateDocument;
use super::traffic::{References, Referred};
use crate::json;
use crate::routes::RouteDocument;
use nearmiss_base::geometry::{Footprint, Shape};
use nearmiss_formats::{EgoError, Entry};
use nearmiss_scene::scenario::{
    Diagnostic, Ego, Goal, Intersection, Lanelet, Location, Obstacle, ObstacleRole, ObstacleType,
    Occupancy, PlanningProblem, Prediction, Scenario, Sign, SignalState, TrafficLight, identity,
};

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
    /// Route of each planning problem.
    #[schemars(with = "Vec<Value>")]
    routes: Vec<RouteDocument>,
    #[schemars(with = "Vec<Value>")]
    diagnostics: &'s [Diagnostic],
}

impl json::Output for ScenarioDocument<'_> {
    const NAME: &'static str = "inspect";
    const TITLE: &'static str = "`inspect FILE --format json`: a scenario";
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
            hash: crate::row_file::short_hash(&scenario.hash),
            lanelets: &network.lanelets,
            traffic_signs: signs.map(|sign| references.to_sign(sign)).collect(),
            traffic_lights: lights.map(|light| references.to_light(light)).collect(),
            intersections: &network.intersections,
            obstacles: scenario.obstacles.iter().map(obstacle).collect(),
            planning_problems: scenario.planning_problems.iter().map(problem).collect(),
            ego: ego_document(ego),
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
