//! Messages of the planner protocol, version 1: one JSON object a line; their schemas.
//!
//! nearmiss writes `hello`, `plan` and `bye` to the planner's standard input and reads `ready`, `trajectory` and
//! `error` from its standard output. `nearmiss help planners` is the description for authors of planners; the schemas
//! come from these types.

use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::messages::Road;

/// The newest version of the protocol that is spoken.
pub const PROTOCOL: u32 = 1;

/// The oldest version that is still spoken.
pub const OLDEST_PROTOCOL: u32 = 1;

/// The point of the vehicle that positions are about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ReferencePoint {
    /// The middle of the rear axle.
    #[default]
    RearAxle,
    /// The centre of the body.
    Centre,
}

/// `hello`: the first line to a planner, once a drive.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Hello<'a> {
    /// Newest version of the protocol that nearmiss speaks.
    pub protocol: u32,
    /// Oldest version that nearmiss still speaks.
    pub oldest_protocol: u32,
    /// nearmiss and its version.
    pub program: String,
    /// Name of the scenario.
    pub scenario: &'a str,
    /// Seconds between two time steps.
    pub dt: f64,
    /// Time step at which the drive begins.
    pub first_step: i64,
    /// Last time step of the drive; without a goal by then it is a timeout.
    pub last_step: i64,
    /// `simulated`: the ego waits for each answer; `real`: an answer counts from the time step at which it is there.
    pub clock: &'static str,
    /// Steps that are driven of a trajectory before the next one is asked for.
    pub replan: usize,
    /// How far predictions reach, seconds.
    pub horizon: f64,
    /// What predictions come from, for planners that want them: `lane`, `constant-velocity`, or `recorded`, the future
    /// itself.
    pub prediction: &'static str,
    /// The ego vehicle.
    pub vehicle: Vehicle,
    /// The road network.
    pub road: Road<'a>,
    /// Obstacles that never move.
    pub static_obstacles: Vec<Obstacle>,
    /// Where the ego starts and where it is to go.
    pub problem: Problem,
}

/// The ego vehicle with the limits of the kinematic single-track model.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Vehicle {
    /// Its name.
    pub name: &'static str,
    /// Its number among the CommonRoad vehicles.
    pub number: u8,
    /// Metres.
    pub length: f64,
    /// Metres.
    pub width: f64,
    /// Between the axles, metres.
    pub wheelbase: f64,
    /// From the rear axle forward to the centre, metres.
    pub rear_to_centre: f64,
    /// In any direction, m/s².
    pub max_acceleration: f64,
    /// Above this speed (m/s) the engine gives `max_acceleration · switch_speed / v`.
    pub switch_speed: f64,
    /// m/s.
    pub max_speed: f64,
    /// To either side, radians.
    pub max_steering: f64,
    /// rad/s.
    pub max_steering_rate: f64,
}

/// An obstacle at a time step.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Obstacle {
    /// Unique.
    pub id: i64,
    /// Its type, in the words of CommonRoad.
    pub r#type: &'static str,
    /// Length of the box around it along its heading, metres.
    pub length: f64,
    /// Width of the box, metres.
    pub width: f64,
    /// Middle of the box in the obstacle's frame (forward, left), metres; usually [0, 0].
    pub box_middle: [f64; 2],
    /// Where it is, metres.
    pub x: f64,
    /// Metres.
    pub y: f64,
    /// Radians.
    pub heading: f64,
    /// m/s along the heading.
    pub velocity: f64,
    /// m/s² along the heading.
    pub acceleration: f64,
    /// Earlier states, oldest first, without the present: as many as the planner wants and were observed.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub history: Vec<PastState>,
    /// What it may do next, the likeliest first; only for planners that want predictions.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub predictions: Vec<Prediction>,
}

/// An obstacle at an earlier time step.
#[derive(Debug, Serialize, JsonSchema)]
pub struct PastState {
    /// The time step.
    pub step: i64,
    /// Metres.
    pub x: f64,
    /// Metres.
    pub y: f64,
    /// Radians.
    pub heading: f64,
    /// m/s along the heading.
    pub velocity: f64,
    /// m/s² along the heading.
    pub acceleration: f64,
}

/// One motion that an obstacle may have.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Prediction {
    /// 0 to 1.
    pub probability: f64,
    /// `[x, y, heading, velocity]` of the middle of its box, one a time step, the present first; rounded to millionths.
    pub states: Vec<[f64; 4]>,
}

/// Where the ego starts and where it is to go.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Problem {
    /// The planning problem's id.
    pub id: i64,
    /// The start, as the scenario says it: positions are the centre.
    pub start: Start,
    /// Any one of these is an arrival.
    pub goals: Vec<Goal>,
}

/// The start of a planning problem.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Start {
    /// Centre of the vehicle, metres.
    pub x: f64,
    /// Metres.
    pub y: f64,
    /// Radians.
    pub heading: f64,
    /// m/s.
    pub velocity: f64,
    /// m/s².
    pub acceleration: f64,
    /// rad/s.
    pub yaw_rate: f64,
}

/// A goal: all that it says has to hold for the centre of the vehicle.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Goal {
    /// First time step that counts.
    pub first_step: i64,
    /// Last time step that counts.
    pub last_step: i64,
    /// Lanelets; empty where the goal names none.
    pub lanelets: Vec<i64>,
    /// Areas as polygons; empty where the goal has none. Lanelets and areas are alternatives.
    pub areas: Vec<Vec<[f64; 2]>>,
    /// From and to, radians.
    pub heading: Option<[f64; 2]>,
    /// From and to, m/s.
    pub velocity: Option<[f64; 2]>,
}

/// `plan`: the scene at a time step; the planner answers with a trajectory or an error.
#[derive(Debug, Serialize, JsonSchema)]
pub struct PlanMessage {
    /// The time step.
    pub step: i64,
    /// Seconds since the first step.
    pub time: f64,
    /// The ego now.
    pub ego: EgoState,
    /// Obstacles that move and are there now.
    pub obstacles: Vec<Obstacle>,
    /// Traffic lights now.
    pub lights: Vec<LightState>,
    /// Goals that can still be reached.
    pub goals: Vec<Goal>,
}

/// The ego at a time step.
#[derive(Debug, Serialize, JsonSchema)]
pub struct EgoState {
    /// The point that x and y are about, as the planner chose it in `ready`.
    pub reference_point: ReferencePoint,
    /// Metres.
    pub x: f64,
    /// Metres.
    pub y: f64,
    /// Radians.
    pub heading: f64,
    /// m/s along the heading.
    pub velocity: f64,
    /// m/s² along the heading.
    pub acceleration: f64,
    /// Angle of the front wheels, radians, left positive.
    pub steering: f64,
    /// rad/s.
    pub yaw_rate: f64,
}

/// A traffic light now.
#[derive(Debug, Serialize, JsonSchema)]
pub struct LightState {
    /// Its id.
    pub id: i64,
    /// `red`, `yellow`, `redYellow`, `green` or `inactive`.
    pub color: &'static str,
}

/// What a planner may answer.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(tag = "type", rename_all = "snake_case")]
pub enum Answer {
    /// The answer to `hello`.
    Ready(Ready),
    /// An answer to `plan`.
    Trajectory(Trajectory),
    /// The other answer to `plan`, or to `hello`.
    Error(Refusal),
}

/// `ready`: the planner can drive.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize, JsonSchema)]
pub struct Ready {
    /// Version of the protocol that is used; one that `hello` offers.
    pub protocol: u32,
    /// Name of the planner.
    pub name: String,
    /// Version of the planner.
    #[serde(default)]
    pub version: String,
    /// The point that positions of the ego are about, in `plan` and in `trajectory`.
    #[serde(default)]
    pub reference_point: ReferencePoint,
    /// Whether obstacles come with predictions.
    #[serde(default)]
    pub predictions: bool,
    /// Earlier states that each obstacle comes with, at most.
    #[serde(default)]
    pub history: usize,
    /// Whether another `hello` may follow on the same process, for the next drive; else each drive has a process of its
    /// own.
    #[serde(default)]
    pub reusable: bool,
    /// Whether each trajectory depends on `hello` and that `plan` alone. Drives that begin alike then take over what was
    /// planned before, instead of planning it again.
    #[serde(default)]
    pub stateless: bool,
}

/// `trajectory`: what the ego is to do from now on.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
pub struct Trajectory {
    /// The time step of the `plan` that it answers.
    pub step: i64,
    /// The states; the first one is the ego now. At least `replan` more.
    pub states: Vec<PlannedState>,
    /// Time that the planner itself measured for this cycle, milliseconds.
    #[serde(default)]
    pub ms: Option<f64>,
}

/// A planned state of the ego.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, JsonSchema)]
pub struct PlannedState {
    /// Seconds from now; without it one state a time step.
    #[serde(default)]
    pub t: Option<f64>,
    /// Metres.
    pub x: f64,
    /// Metres.
    pub y: f64,
    /// Radians.
    pub heading: f64,
    /// m/s along the heading.
    pub velocity: f64,
    /// m/s² along the heading; without it the change of the velocity.
    #[serde(default)]
    pub acceleration: Option<f64>,
    /// Angle of the front wheels, radians; without it as the heading turns.
    #[serde(default)]
    pub steering: Option<f64>,
}

/// `error`: the planner has no trajectory.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize, JsonSchema)]
pub struct Refusal {
    /// Why.
    pub message: String,
    /// Whether it works and found nothing that can be driven: the drive then ends as `infeasible`.
    #[serde(default)]
    pub infeasible: bool,
}

/// `bye`: nothing follows; the planner is to end.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Bye {}

/// A message to a planner.
#[derive(Debug, Serialize)]
#[serde(tag = "type", rename_all = "snake_case")]
pub(super) enum Message<'a> {
    Hello(&'a Hello<'a>),
    Plan(&'a PlanMessage),
    Bye(Bye),
}

/// A message: its name, what it is, and its schema without the type.
type Described = (&'static str, &'static str, fn() -> Value);

/// The names of the messages with what each is, in the order of a drive.
const MESSAGES: [Described; 6] = [
    (
        "hello",
        "nearmiss to the planner, once a drive",
        schema::<Hello<'static>>,
    ),
    ("ready", "the planner's answer to `hello`", answer::<Ready>),
    (
        "plan",
        "nearmiss to the planner, each cycle",
        schema::<PlanMessage>,
    ),
    (
        "trajectory",
        "the planner's answer to `plan`",
        answer::<Trajectory>,
    ),
    (
        "error",
        "the planner has no trajectory, or cannot drive",
        answer::<Refusal>,
    ),
    ("bye", "nearmiss to the planner: the end", schema::<Bye>),
];

/// The messages of the protocol by name, each with what it is.
pub fn planner_message_names() -> impl Iterator<Item = (&'static str, &'static str)> {
    MESSAGES.iter().map(|(name, about, _)| (*name, *about))
}

/// The JSON schema of a message of the protocol.
#[must_use]
pub fn planner_message_schema(name: &str) -> Option<Value> {
    let (name, _, schema) = MESSAGES.iter().find(|(known, ..)| *known == name)?;
    let mut schema = schema();
    // The type of a message is said by its tag, which is no field of it.
    let mut properties = serde_json::Map::new();
    properties.insert("type".into(), json!({ "const": name }));
    if let Some(fields) = schema["properties"].as_object() {
        properties.extend(fields.clone());
    }
    schema["properties"] = Value::Object(properties);
    let mut required = vec![json!("type")];
    required.extend(schema["required"].as_array().cloned().unwrap_or_default());
    schema["required"] = Value::Array(required);
    Some(schema)
}

fn schema<T: JsonSchema>() -> Value {
    schema_of::<T>(SchemaSettings::draft2020_12().for_serialize())
}

fn answer<T: JsonSchema>() -> Value {
    schema_of::<T>(SchemaSettings::draft2020_12().for_deserialize())
}

fn schema_of<T: JsonSchema>(settings: SchemaSettings) -> Value {
    let settings = settings.with(|s| s.inline_subschemas = true);
    settings
        .into_generator()
        .into_root_schema_for::<T>()
        .to_value()
}
