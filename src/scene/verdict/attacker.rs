//! Attackers as models name them, and their new motions: points as lists or objects, manoeuvres under other names.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::ObstacleRisk;
use super::critical::{self, Entry};
use super::parsed_answer::Notes;
use super::trajectory::{Manoeuvre, ManoeuvreKind, TrajectoryAnswer, WaypointAnswer};
use super::values::{self, Id, Object, get, plain};

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
