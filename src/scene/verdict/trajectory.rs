//! An attacker and its new motion, timed waypoints or a manoeuvre, and how models name them.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use strum::{IntoStaticStr, VariantArray};

use super::ObstacleRisk;
use super::critical::{self, Entry};
use super::parsed_answer::Notes;
use super::values::{self, Id, Object, get, plain};

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

/// The answer to the attacker task.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct AttackerChoice {
    /// Why this one, in a few sentences that cite steps and numbers.
    pub justification: String,
    /// Id of the obstacle whose motion is to be changed; null if none can endanger the ego.
    pub attacker: Option<i64>,
    /// The obstacles that come into question, the best attacker first.
    pub obstacles: Vec<ObstacleRisk>,
}

const CHOICES: [&str; 9] = [
    "attacker",
    "attackerid",
    "egoattacker",
    "egoattackerid",
    "chosenattacker",
    "selectedattacker",
    "chosenobstacle",
    "selectedobstacle",
    "attackerobstacleid",
];

const CANDIDATES: [&str; 3] = ["potentialattacker", "candidate", "potentialegoattacker"];

/// Whether an object speaks of an attacker, and not only of obstacles.
pub(super) fn is_named(object: &Object) -> bool {
    [&CHOICES[..], &CANDIDATES[..]]
        .iter()
        .any(|names| values::find(object, names).is_some())
}

/// The choice that an object makes, in whatever words; nothing if it makes none.
pub(super) fn interpret(object: &Object, notes: &mut Notes) -> Option<AttackerChoice> {
    let chosen = values::find(object, &CHOICES);
    let candidates = values::find(object, &CANDIDATES);
    let groups = critical::groups(object);
    let by_groups = groups.iter().any(|group| group.level <= 1);
    let mut of_candidates: Vec<Entry> = candidates.map(critical::entries).unwrap_or_default();
    of_candidates.extend(
        chosen
            .filter(|v| v.is_array() || v.is_object())
            .map(critical::entries)
            .unwrap_or_default(),
    );
    let first = of_candidates.iter().find_map(|entry| known(&entry.id));
    let mut obstacles = Vec::new();
    for entry in of_candidates {
        critical::add(&mut obstacles, entry, None, notes);
    }
    obstacles.extend(critical::obstacles(object, notes));
    let mut seen = std::collections::HashSet::new();
    obstacles.retain(|o| seen.insert(o.id));
    let attacker = match chosen {
        Some(value) if values::is_nothing(value) => None,
        Some(value) if value.is_array() || value.is_object() => {
            notes.add("the attacker was read from a list");
            Some(first?)
        }
        Some(value) => Some(known(&values::id(value))?),
        None if candidates.is_some() || by_groups || !obstacles.is_empty() => {
            notes.add("no attacker is named explicitly, so the first candidate was used");
            let riskiest = obstacles.iter().min_by_key(|o| o.risk_score).map(|o| o.id);
            first.or(riskiest)
        }
        None => return None,
    };
    let justification = super::parse::justification(object, notes);
    Some(AttackerChoice {
        attacker,
        obstacles,
        justification,
    })
}

fn known(id: &Id) -> Option<i64> {
    match id {
        Id::Is(id) => Some(*id),
        Id::Unclear(_) => None,
    }
}

const OBSTACLES: [&str; 8] = [
    "obstacle",
    "obstacleid",
    "attacker",
    "attackerid",
    "egoattacker",
    "egoattackerid",
    "vehicleid",
    "id",
];

const POINTS: [&str; 10] = [
    "waypoint",
    "trajectory",
    "newtrajectory",
    "adversarialtrajectory",
    "modifiedtrajectory",
    "generatedtrajectory",
    "trajectorypoint",
    "point",
    "state",
    "path",
];

const MANOEUVRES: [&str; 2] = ["manoeuvre", "maneuver"];

const STEPS: [&str; 2] = ["step", "timestep"];

const TIMES: [&str; 4] = ["time", "t", "second", "timestamp"];

const HEADINGS: [&str; 4] = ["heading", "orientation", "yaw", "theta"];

const SPEEDS: [&str; 3] = ["velocity", "speed", "v"];

const POSITIONS: [&str; 2] = ["position", "center"];

/// The motion that an object describes; nothing if it describes none.
///
/// # Errors
/// It describes one that cannot be used: what is wrong with it.
pub(super) fn interpret_motion(
    object: &Object,
    notes: &mut Notes,
) -> Result<Option<TrajectoryAnswer>, String> {
    let said = |value: &&Value| !values::is_nothing(value);
    let points = values::find(object, &POINTS)
        .filter(said)
        .filter(|v| v.is_array() || v.is_object());
    let manoeuvre = values::find(object, &MANOEUVRES).filter(said);
    if points.is_none() && manoeuvre.is_none() {
        return Ok(None);
    }
    let obstacle = values::find(object, &OBSTACLES).ok_or("no obstacle to move is named")?;
    let Id::Is(obstacle) = values::id(obstacle) else {
        return Err(format!(
            "`{}` is not an obstacle id",
            values::short(obstacle)
        ));
    };
    let waypoints = points.map(|v| waypoints(v, notes)).transpose()?;
    let manoeuvre = manoeuvre.map(|v| read_manoeuvre(v, object)).transpose()?;
    let justification = super::parse::justification(object, notes);
    notes.add("read from keys other than those requested");
    Ok(Some(TrajectoryAnswer {
        obstacle,
        waypoints,
        manoeuvre,
        justification,
    }))
}

/// Points as a list; as an object with a list in it, or with times as keys.
pub(super) fn waypoints(value: &Value, notes: &mut Notes) -> Result<Vec<WaypointAnswer>, String> {
    let number_of = |place: usize, error: &str| format!("waypoint {}: {error}", place + 1);
    match value {
        Value::Array(items) if items.iter().all(Value::is_array) => rows(items, notes),
        Value::Array(items) => {
            let read = items.iter().enumerate().map(|(place, item)| {
                let object = item.as_object().ok_or("is not an object")?;
                point(object, None).map_err(|error| number_of(place, &error))
            });
            read.collect()
        }
        Value::Object(object) => {
            if let Some(inner) = values::find(object, &POINTS).filter(|v| v.is_array()) {
                return waypoints(inner, notes);
            }
            notes.add("the keys of the waypoints were read as seconds");
            let read = object.iter().enumerate().map(|(place, (key, value))| {
                let time = values::number(&Value::String(key.clone()))
                    .ok_or_else(|| number_of(place, "its key is not a time"))?;
                let inner = value
                    .as_object()
                    .ok_or_else(|| number_of(place, "is not an object"))?;
                point(inner, Some(time)).map_err(|error| number_of(place, &error))
            });
            read.collect()
        }
        _ => Err("its waypoints are not a list".into()),
    }
}

/// Whether an object is one waypoint.
pub(super) fn is_point(object: &Object) -> bool {
    point(object, None).is_ok()
}

/// One waypoint with names.
fn point(object: &Object, time: Option<f64>) -> Result<WaypointAnswer, String> {
    let number = |names: &[&str]| get(object, names).and_then(values::number);
    let step = number(&STEPS).filter(|_| time.is_none());
    let time = time.or_else(|| number(&TIMES));
    let (x, y) = match get(object, &POSITIONS) {
        Some(Value::Array(pair)) => (
            pair.first().and_then(values::number),
            pair.get(1).and_then(values::number),
        ),
        Some(Value::Object(inner)) => {
            let number = |name: &str| get(inner, &[name]).and_then(values::number);
            (number("x"), number("y"))
        }
        _ => (
            number(&["x", "xposition", "positionx"]),
            number(&["y", "yposition", "positiony"]),
        ),
    };
    let (Some(x), Some(y)) = (x, y) else {
        return Err("no position".into());
    };
    let whole = step
        .filter(|s| s.fract() == 0.0 && s.abs() < 1e15)
        .map(|s| s as i64);
    let time = if whole.is_some() { None } else { time };
    if whole.is_none() && time.is_none() {
        return Err("neither step nor time".into());
    }
    Ok(WaypointAnswer {
        step: whole,
        time,
        x,
        y,
        heading: number(&HEADINGS),
        velocity: number(&SPEEDS),
    })
}

/// Waypoints as `[step or time, x, y, heading, velocity]`: whole numbers in front are steps.
fn rows(items: &[Value], notes: &mut Notes) -> Result<Vec<WaypointAnswer>, String> {
    let read = |(place, item): (usize, &Value)| {
        let row: Option<Vec<f64>> = item.as_array()?.iter().map(values::number).collect();
        let row = row.filter(|row| (3..=5).contains(&row.len()));
        Some((place, row?))
    };
    let rows: Option<Vec<_>> = items.iter().enumerate().map(read).collect();
    let rows = rows.ok_or(
        "a waypoint given as a list needs a step or time, x, y, and optionally heading and velocity",
    )?;
    let steps = rows.iter().all(|(_, row)| row[0].fract() == 0.0);
    notes.add(if steps {
        "whole numbers before the waypoints were read as steps"
    } else {
        "numbers before the waypoints were read as seconds"
    });
    let read = |(_, row): (usize, Vec<f64>)| WaypointAnswer {
        step: steps.then_some(row[0] as i64),
        time: (!steps).then_some(row[0]),
        x: row[1],
        y: row[2],
        heading: row.get(3).copied(),
        velocity: row.get(4).copied(),
    };
    Ok(rows.into_iter().map(read).collect())
}

/// A manoeuvre as an object, or as a word with its numbers beside it.
fn read_manoeuvre(value: &Value, around: &Object) -> Result<Manoeuvre, String> {
    let object = value.as_object().unwrap_or(around);
    let names = ["kind", "type", "name", "manoeuvre", "maneuver"];
    let word = get(object, &names)
        .or(Some(value))
        .and_then(Value::as_str)
        .ok_or("the manoeuvre has no kind")?;
    let kind = kind(word).ok_or_else(|| {
        let known: Vec<_> = ManoeuvreKind::ALL.iter().map(|k| k.name()).collect();
        format!(
            "unknown manoeuvre `{word}`; available: {}",
            known.join(", ")
        )
    })?;
    let number = |names: &[&str]| get(object, names).and_then(values::number);
    let start =
        number(&["start", "starttime", "begin", "time"]).ok_or("the manoeuvre has no start")?;
    let duration = number(&["duration", "length"]).ok_or("the manoeuvre has no duration")?;
    Ok(Manoeuvre {
        kind,
        start,
        duration,
        gap: number(&["gap", "targetgap", "distance"]),
        speed: number(&["speed", "targetspeed", "velocity", "targetvelocity"]),
    })
}

/// The kind that a word means.
fn kind(word: &str) -> Option<ManoeuvreKind> {
    use ManoeuvreKind::{CutIn, DoorToDoor, Drift, HardBrake, LateTurn, PullOut, RunTheLight};
    let word = plain(word);
    let beginnings = [
        ("cutin", CutIn),
        ("hardbrak", HardBrake),
        ("brak", HardBrake),
        ("suddenbrak", HardBrake),
        ("emergencybrak", HardBrake),
        ("drift", Drift),
        ("runthelight", RunTheLight),
        ("runtheredlight", RunTheLight),
        ("runredlight", RunTheLight),
        ("runningtheredlight", RunTheLight),
        ("redlight", RunTheLight),
        ("lateturn", LateTurn),
        ("doortodoor", DoorToDoor),
        ("pullout", PullOut),
        ("pullingout", PullOut),
    ];
    let found = beginnings.iter().find(|(start, _)| word.starts_with(start));
    found.map(|(_, kind)| *kind)
}
