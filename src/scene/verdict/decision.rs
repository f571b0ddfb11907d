//! Reads yes or no from an object: by the requested key, by synonyms, or by the obstacles named.

use super::critical::{self, Group};
use super::lenient::JsonPiece;
use super::parse::NoVerdict;
use super::parsed_answer::Notes;
use super::values::{self, Object};
use super::{ObstacleRisk, Task};

/// A yes or no and where it is from.
#[derive(Debug, Clone)]
pub(super) struct Decision {
    pub dangerous: bool,
    /// Whether the requested key itself answers, plainly and in its place.
    pub as_asked: bool,
    /// Whether it was read from the obstacles named.
    from_groups: bool,
    /// Description of the source.
    pub note: String,
}

const COLLISION: [&str; 7] = [
    "collision",
    "iscollision",
    "iscollisionscenario",
    "collisionscenario",
    "collisiondetected",
    "collisionoccurred",
    "hascollision",
];
const SAFETY: [&str; 7] = [
    "safetycritical",
    "issafetycritical",
    "safetycriticalscenario",
    "issafetycriticalscenario",
    "safetycriticality",
    "critical",
    "iscritical",
];

const RECORDING: [&str; 6] = [
    "highrisk",
    "ishighrisk",
    "highriskrecording",
    "ishighriskrecording",
    "highriskscenario",
    "ishighriskscenario",
];
/// Keys whose value says in words which of the two a recording is.
const CLASSES: [&str; 3] = ["classification", "class", "label"];

/// Yes or no in the value of a key of a task.
fn stated_answer(task: Task, key: &str, value: &serde_json::Value) -> Option<bool> {
    let key = values::plain(key);
    let names = match task {
        Task::Collision => &COLLISION[..],
        Task::Safety => &SAFETY,
        Task::Recording => &RECORDING,
        Task::Attacker | Task::Trajectory => return None,
    };
    if names.contains(&key.as_str()) {
        return values::truth(value);
    }
    if task != Task::Recording || !CLASSES.contains(&key.as_str()) {
        return None;
    }
    match values::plain(value.as_str()?).as_str() {
        "highrisk" | "unsafe" => Some(true),
        "safe" | "lowrisk" => Some(false),
        _ => None,
    }
}

/// The decision in an object, the nearest level first; `None` without one.
///
/// # Errors
/// Two keys of one level contradict each other.
pub(super) fn read_decision(task: Task, object: &Object) -> Result<Option<Decision>, NoVerdict> {
    if !Task::VERDICTS.contains(&task) {
        return Ok(None);
    }
    for (depth, level) in values::levels(object).into_iter().enumerate() {
        let pairs = level.iter().flat_map(|o| o.iter());
        let mut said = pairs.filter_map(|(key, value)| {
            Some((key, value.is_boolean(), stated_answer(task, key, value)?))
        });
        let Some((key, plainly, dangerous)) = said.next() else {
            continue;
        };
        if let Some((other, ..)) = said.find(|(.., other)| *other != dangerous) {
            return Err(NoVerdict::Contradictory(key.clone(), other.clone()));
        }
        return Ok(Some(Decision {
            dangerous,
            as_asked: depth == 0 && key == task.key() && plainly,
            from_groups: false,
            note: format!("the decision was read from `{key}`"),
        }));
    }
    Ok(of_groups(task, object))
}

/// Whether an object answers one of the yes-or-no tasks in so many words.
pub(super) fn is_stated(object: &Object) -> bool {
    Task::VERDICTS
        .iter()
        .any(|task| match read_decision(*task, object) {
            Ok(decision) => decision.is_some_and(|d| !d.from_groups),
            Err(_) => true,
        })
}

/// The paper's prompts ask for obstacles that collide or will: naming one is a yes, leaving all of them out a no.
fn of_groups(task: Task, object: &Object) -> Option<Decision> {
    let groups = critical::groups(object);
    let decisive = groups.iter().filter(|g| decides(task, g));
    let mut present = decisive.peekable();
    present.peek()?;
    Some(Decision {
        dangerous: present.any(Group::names_someone),
        as_asked: false,
        from_groups: true,
        note: "the decision was read from the obstacles named".into(),
    })
}

fn decides(task: Task, group: &Group<'_>) -> bool {
    let worst = if task == Task::Collision { 0 } else { 1 };
    group.level <= worst
}

/// One object out of several that belong together: one for each obstacle or group, and perhaps one with the decision.
/// Nothing where the last object stands alone.
pub(super) fn merge(
    task: Task,
    objects: &[(&JsonPiece, &Object)],
    notes: &mut Notes,
) -> Option<Object> {
    let ((_, last), before) = objects.split_last()?;
    let says_who =
        |o: &Object| !critical::groups(o).is_empty() || values::find(o, &["obstacle"]).is_some();
    let alone = read_decision(task, last)
        .ok()
        .flatten()
        .is_some_and(|d| !d.from_groups)
        && says_who(last);
    if alone {
        return None;
    }
    let mut merged = (*last).clone();
    let mut listed = Vec::new();
    for (piece, object) in before.iter().rev() {
        if critical::is_entry(object) {
            notes.note_repairs(piece);
            listed.push(serde_json::Value::Object((*object).clone()));
        } else if says_who(object) && object.keys().all(|key| !merged.contains_key(key)) {
            notes.note_repairs(piece);
            let entries = object.iter().map(|(k, v)| (k.clone(), v.clone()));
            merged.extend(entries);
        } else if read_decision(task, object).ok().flatten().is_some() {
            // A draft of the same answer.
            break;
        }
    }
    listed.reverse();
    if merged.len() == last.len() && listed.is_empty() {
        return None;
    }
    notes.add("several objects were merged");
    if !listed.is_empty() && !merged.contains_key("obstacles") {
        merged.insert("obstacles".into(), listed.into());
    }
    Some(merged)
}

/// The obstacles that an object names.
pub(super) fn obstacles(
    object: &Object,
    decision: &Decision,
    notes: &mut Notes,
) -> Vec<ObstacleRisk> {
    let found = critical::obstacles(object, notes);
    if decision.from_groups && decision.dangerous && found.is_empty() {
        notes.add("an obstacle is named without an id");
    }
    found
}
