//! An attacker's new motion: timed waypoints, or a manoeuvre with parameters.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use strum::{IntoStaticStr, VariantArray};

/// The answer to the trajectory task, as it is written: waypoints or a manoeuvre, the other one null.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct TrajectoryAnswer {
    /// Why this endangers the ego, in a few sentences.
    pub justification: String,
    /// Id of the obstacle that is to move so.
    pub obstacle: i64,
    /// Its positions in time, in order; null if a manoeuvre is given.
    pub waypoints: Option<Vec<WaypointAnswer>>,
    /// What it does; null if waypoints are given.
    pub manoeuvre: Option<Manoeuvre>,
}

/// A waypoint as it is written: at a step or at a time, the other one null.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct WaypointAnswer {
    /// Time step of the scenario; null if a time is given.
    pub step: Option<i64>,
    /// Seconds since step 0; null if a step is given.
    pub time: Option<f64>,
    /// Position on the map, metres.
    pub x: f64,
    /// Position on the map, metres.
    pub y: f64,
    /// Radians from the x axis, counterclockwise; null if it follows from the path.
    pub heading: Option<f64>,
    /// Speed in m/s; null if it follows from the path.
    pub velocity: Option<f64>,
}

/// What a driver does to endanger another one.
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Eq,
    Hash,
    Serialize,
    Deserialize,
    JsonSchema,
    IntoStaticStr,
    VariantArray,
)]
#[strum(serialize_all = "kebab-case")]
#[serde(rename_all = "kebab-case")]
pub enum ManoeuvreKind {
    /// Changes into the ego's lane close in front of it.
    CutIn,
    /// Brakes hard in front of the ego.
    HardBrake,
    /// Leaves its lane slowly towards the ego.
    Drift,
    /// Enters a junction against a red light.
    RunTheLight,
    /// Turns across the ego's path at the last moment.
    LateTurn,
    /// Stays level with the ego, closer than its lane allows.
    DoorToDoor,
    /// Pulls out from standstill or the roadside into the ego's path.
    PullOut,
}

nearmiss_record::named!(ManoeuvreKind);

/// A manoeuvre and its numbers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct Manoeuvre {
    /// Which one.
    pub kind: ManoeuvreKind,
    /// When it begins, seconds since step 0.
    #[schemars(range(min = 0.0))]
    pub start: f64,
    /// How long it takes, seconds, more than 0.
    #[schemars(range(min = 0.0))]
    pub duration: f64,
    /// The gap to the ego that it leaves, metres; null if that does not matter.
    #[schemars(range(min = 0.0))]
    pub gap: Option<f64>,
    /// The obstacle's speed at its end, m/s; null if that does not matter.
    #[schemars(range(min = 0.0))]
    pub speed: Option<f64>,
}

/// When an obstacle is somewhere.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Moment {
    /// At a time step.
    Step(i64),
    /// So many seconds after step 0.
    Seconds(f64),
}

/// Position of an obstacle at a time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Waypoint {
    /// When.
    pub at: Moment,
    /// Position on the map, metres.
    pub x: f64,
    /// Position on the map, metres.
    pub y: f64,
    /// Radians from the x axis, counterclockwise, where it is said.
    pub heading: Option<f64>,
    /// Speed in m/s, where it is said.
    pub velocity: Option<f64>,
}

/// The requested motion of an obstacle.
#[derive(Debug, Clone, PartialEq)]
pub enum Motion {
    /// Through these points: at least two, all with steps or all with times, which rise.
    Waypoints(Vec<Waypoint>),
    /// With this manoeuvre.
    Manoeuvre(Manoeuvre),
}

impl Motion {
    /// What kind of motion it is: the manoeuvre's word, or `waypoints`.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Waypoints(_) => "waypoints",
            Self::Manoeuvre(manoeuvre) => manoeuvre.kind.name(),
        }
    }
}

/// A parsed answer to the trajectory task.
#[derive(Debug, Clone, PartialEq)]
pub struct NewMotion {
    /// Id of the obstacle.
    pub obstacle: i64,
    /// How it is to move.
    pub motion: Motion,
    /// Why this endangers the ego.
    pub justification: String,
}

impl TryFrom<TrajectoryAnswer> for NewMotion {
    type Error = String;

    fn try_from(answer: TrajectoryAnswer) -> Result<Self, String> {
        let motion = match (answer.waypoints, answer.manoeuvre) {
            (Some(points), None) => {
                let points = points.into_iter().map(Waypoint::try_from);
                Motion::Waypoints(in_order(points.collect::<Result<_, _>>()?)?)
            }
            (None, Some(manoeuvre)) => Motion::Manoeuvre(sensible(manoeuvre)?),
            (None, None) => return Err("neither waypoints nor a manoeuvre".into()),
            (Some(_), Some(_)) => return Err("both waypoints and a manoeuvre".into()),
        };
        Ok(Self {
            obstacle: answer.obstacle,
            motion,
            justification: answer.justification,
        })
    }
}

impl From<NewMotion> for TrajectoryAnswer {
    fn from(new: NewMotion) -> Self {
        let (waypoints, manoeuvre) = match new.motion {
            Motion::Waypoints(points) => (
                Some(points.into_iter().map(WaypointAnswer::from).collect()),
                None,
            ),
            Motion::Manoeuvre(manoeuvre) => (None, Some(manoeuvre)),
        };
        Self {
            obstacle: new.obstacle,
            waypoints,
            manoeuvre,
            justification: new.justification,
        }
    }
}

impl TryFrom<WaypointAnswer> for Waypoint {
    type Error = String;

    fn try_from(point: WaypointAnswer) -> Result<Self, String> {
        let at = match (point.step, point.time) {
            (Some(step), None) => Moment::Step(step),
            (None, Some(time)) => Moment::Seconds(time),
            (Some(_), Some(_)) => return Err("a waypoint has both a step and a time".into()),
            (None, None) => return Err("a waypoint has neither a step nor a time".into()),
        };
        Ok(Self {
            at,
            x: point.x,
            y: point.y,
            heading: point.heading,
            velocity: point.velocity,
        })
    }
}

impl From<Waypoint> for WaypointAnswer {
    fn from(point: Waypoint) -> Self {
        let (step, time) = match point.at {
            Moment::Step(step) => (Some(step), None),
            Moment::Seconds(time) => (None, Some(time)),
        };
        Self {
            step,
            time,
            x: point.x,
            y: point.y,
            heading: point.heading,
            velocity: point.velocity,
        }
    }
}

/// The points, if they make a motion.
fn in_order(points: Vec<Waypoint>) -> Result<Vec<Waypoint>, String> {
    if points.len() < 2 {
        return Err("a motion needs at least two waypoints".into());
    }
    let rises = |pair: &[Waypoint]| match (pair[0].at, pair[1].at) {
        (Moment::Step(a), Moment::Step(b)) => Ok(a < b),
        (Moment::Seconds(a), Moment::Seconds(b)) => Ok(a < b),
        _ => Err("some waypoints have steps, others times".to_string()),
    };
    for pair in points.windows(2) {
        if !rises(pair)? {
            return Err("the waypoints are not in time order".into());
        }
    }
    Ok(points)
}

fn sensible(manoeuvre: Manoeuvre) -> Result<Manoeuvre, String> {
    let negative = |value: Option<f64>| value.is_some_and(|v| v < 0.0);
    if manoeuvre.start < 0.0 || manoeuvre.duration <= 0.0 {
        return Err("the manoeuvre needs a start of at least 0 and a duration above 0".into());
    }
    if negative(manoeuvre.gap) || negative(manoeuvre.speed) {
        return Err("gap and speed of the manoeuvre cannot be negative".into());
    }
    Ok(manoeuvre)
}
