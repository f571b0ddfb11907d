//! Critical obstacles and probabilities, as models write them, singly or grouped by risk level.

use std::collections::HashSet;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::ObstacleRisk;
use super::parsed_answer::Notes;
use super::values::{self, Id, LEVELS, Object, plain};

/// An obstacle that a verdict calls critical.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct CriticalObstacle {
    /// Its id in the scenario.
    pub id: i64,
    /// The probability that this obstacle and the ego touch, 0 to 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "f64", range(min = 0.0, max = 1.0))]
    pub probability: Option<f64>,
}

impl CriticalObstacle {
    /// One whose probability is not stated.
    #[must_use]
    pub fn new(id: i64) -> Self {
        Self {
            id,
            probability: None,
        }
    }
}

const LISTS: [&str; 3] = [
    "criticalobstacle",
    "criticalobstacleid",
    "safetycriticalobstacle",
];
const PROBABILITIES: [&str; 4] = [
    "probability",
    "collisionprobability",
    "contactprobability",
    "probabilityofcontact",
];

/// The critical obstacles that an object lists; `None` without such a list.
pub(super) fn critical_obstacles(
    object: &Object,
    notes: &mut Notes,
) -> Option<Vec<CriticalObstacle>> {
    let list = values::find(object, &LISTS)?;
    let mut seen = HashSet::new();
    let mut found = Vec::new();
    for (id, probability) in critical_entries(list, notes) {
        match id {
            Id::Is(id) if seen.insert(id) => found.push(CriticalObstacle { id, probability }),
            Id::Is(_) => {}
            Id::Unclear(text) => notes.add(format!(
                "`{text}` is not the id of one critical obstacle and was left out"
            )),
        }
    }
    Some(found)
}

/// The probability of a yes that an object states, itself or in what it is wrapped in.
pub(super) fn probability(object: &Object, notes: &mut Notes) -> Option<f64> {
    let of = |object: &Object| values::get(object, &PROBABILITIES).cloned();
    let inner = || {
        // Those of obstacles are not that of the answer.
        let others = object.iter().filter(|(key, _)| {
            let key = values::plain(key);
            !key.contains("obstacle")
        });
        others
            .filter_map(|(_, value)| value.as_object())
            .find_map(of)
    };
    read(&of(object).or_else(inner)?, notes)
}

fn critical_entries(value: &Value, notes: &mut Notes) -> Vec<(Id, Option<f64>)> {
    if values::is_nothing(value) {
        return Vec::new();
    }
    match value {
        Value::Array(items) => items
            .iter()
            .flat_map(|v| critical_entries(v, notes))
            .collect(),
        Value::Object(object) => {
            let stated = values::get(object, &PROBABILITIES).and_then(|v| read(v, notes));
            if let Some(ids) = values::get(object, &IDS) {
                let ids = critical_entries(ids, notes).into_iter();
                return ids.map(|(id, own)| (id, own.or(stated))).collect();
            }
            let by_id = |(key, value): (&String, &Value)| {
                let id = values::id(&Value::String(key.clone()));
                let inner = value
                    .as_object()
                    .and_then(|o| values::get(o, &PROBABILITIES));
                (id, read(inner.unwrap_or(value), notes))
            };
            object.iter().map(by_id).collect()
        }
        other => vec![(values::id(other), None)],
    }
}

/// A probability from 0 to 1, also as text and in per cent.
fn read(value: &Value, notes: &mut Notes) -> Option<f64> {
    if value.is_null() {
        return None;
    }
    let text = value.as_str().map(str::trim);
    let per_cent = text.and_then(|t| t.strip_suffix('%'));
    let number = match per_cent {
        Some(bare) => bare.trim().parse().ok(),
        None => values::number(value),
    };
    let shown = values::short(value);
    let found = number.and_then(|n: f64| match (n, per_cent) {
        (0.0..=100.0, Some(_)) => Some(n / 100.0),
        (0.0..=1.0, None) => Some(n),
        // Nothing else can be meant.
        (2.0..=100.0, None) if n.fract() == 0.0 => Some(n / 100.0),
        _ => None,
    });
    match found {
        Some(p) if value.as_f64() != Some(p) => {
            notes.add(format!("the probability {p} was read from `{shown}`"));
        }
        Some(_) => {}
        None => notes.add(format!("`{shown}` is no probability and was left out")),
    }
    found
}

/// The obstacles of one level.
#[derive(Debug, Clone, Copy)]
pub(super) struct Group<'a> {
    /// Its key, as written.
    pub name: &'a str,
    /// 0 (collision) to 5 (negligible); what is only predicted to be of a level counts as one level less dangerous.
    pub level: u8,
    value: &'a Value,
}

impl Group<'_> {
    /// Whether it has an entry, with a readable id or not.
    pub(super) fn names_someone(&self) -> bool {
        !entries(self.value).is_empty()
    }
}

/// An obstacle in a list.
pub(super) struct Entry {
    pub id: Id,
    pub score: Option<u8>,
    pub reason: String,
}

/// Keys of ids.
pub(super) const IDS: [&str; 6] = [
    "id",
    "obstacleid",
    "obstacle",
    "vehicleid",
    "vehicle",
    "agentid",
];
const SCORES: [&str; 6] = [
    "riskscore",
    "overallriskscore",
    "overallrisk",
    "risk",
    "score",
    "risklevel",
];
const REASONS: [&str; 6] = [
    "reason",
    "reasoning",
    "attackreason",
    "justification",
    "explanation",
    "description",
];
const GROUP_LISTS: [&str; 5] = [
    "obstacle",
    "ranking",
    "riskassessment",
    "obstacleanalysis",
    "riskscore",
];

/// The groups in an object and those inside it, the most dangerous first.
pub(super) fn groups(object: &Object) -> Vec<Group<'_>> {
    let levels = values::levels(object);
    let pairs = levels.iter().flatten().flat_map(|o| o.iter());
    let mut found: Vec<_> = pairs
        .filter_map(|(name, value)| level(name).map(|level| Group { name, level, value }))
        .collect();
    found.sort_by_key(|group| group.level);
    found
}

/// The level in a key such as `CollisionObstacles`, `high_risk_obstacle` or `PredictedCollisionObstacleID`.
fn level(key: &str) -> Option<u8> {
    let key = plain(key);
    let (base, rest) = key.split_once("obstacle")?;
    if !["", "s", "id", "ids"].contains(&rest) {
        return None;
    }
    let (base, later) = match base.strip_prefix("predicted") {
        Some(base) => (base, 1),
        None => (base, 0),
    };
    let base = base.strip_suffix("risk").unwrap_or(base);
    let (_, level) = LEVELS.iter().find(|(name, _)| *name == base)?;
    Some((level + later).min(5))
}

/// Whether an object is about one obstacle: it has an id and a score.
pub(super) fn is_entry(object: &Object) -> bool {
    let has = |names: &[&str]| {
        values::get(object, names).is_some_and(|v| !v.is_object() && !v.is_array())
    };
    has(&IDS[..2]) && has(&SCORES)
}

/// Ids, scores and reasons in a list of objects, one object, an object with ids as keys, or bare ids.
pub(super) fn entries(value: &Value) -> Vec<Entry> {
    if values::is_nothing(value) {
        return Vec::new();
    }
    match value {
        Value::Array(items) => items.iter().flat_map(entries).collect(),
        Value::Object(object) => of_object(object),
        other => vec![Entry {
            id: values::id(other),
            score: None,
            reason: String::new(),
        }],
    }
}

fn of_object(object: &Object) -> Vec<Entry> {
    let reason = values::get(object, &REASONS)
        .and_then(values::text)
        .unwrap_or_default();
    let score = values::get(object, &SCORES).and_then(values::score);
    if let Some(ids) = values::get(object, &IDS) {
        let mut found = entries(ids);
        for entry in &mut found {
            entry.score = entry.score.or(score);
            if entry.reason.is_empty() {
                entry.reason.clone_from(&reason);
            }
        }
        return found;
    }
    let by_key = |(key, value): (&String, &Value)| match values::id(&Value::String(key.clone())) {
        id @ Id::Is(_) => {
            let inner = value.as_object();
            let get = |names: &[&str]| inner.and_then(|o| values::get(o, names));
            vec![Entry {
                id,
                score: values::score(value).or_else(|| get(&SCORES).and_then(values::score)),
                reason: get(&REASONS).and_then(values::text).unwrap_or_default(),
            }]
        }
        Id::Unclear(_) if value.is_object() || value.is_array() => entries(value),
        Id::Unclear(_) => Vec::new(),
    };
    object.iter().flat_map(by_key).collect()
}

/// Every obstacle that an object lists with a score, then those in its groups; each once.
pub(super) fn obstacles(object: &Object, notes: &mut Notes) -> Vec<ObstacleRisk> {
    let mut found = Vec::new();
    if let Some(list) = values::find(object, &GROUP_LISTS) {
        for entry in entries(list) {
            add(&mut found, entry, None, notes);
        }
    }
    for group in groups(object) {
        for entry in entries(group.value) {
            add(&mut found, entry, Some(&group), notes);
        }
    }
    let mut seen = std::collections::HashSet::new();
    found.retain(|o| seen.insert(o.id));
    found
}

/// Adds an obstacle; the group it is in counts more than a score that says otherwise: by it the paper counts whom an
/// answer names.
pub(super) fn add(
    found: &mut Vec<ObstacleRisk>,
    entry: Entry,
    group: Option<&Group<'_>>,
    notes: &mut Notes,
) {
    let id = match entry.id {
        Id::Is(id) => id,
        Id::Unclear(text) => {
            return notes.add(format!("`{text}` is not an obstacle id and was left out"));
        }
    };
    // What is only predicted to be of a level is graded one level less dangerous.
    let written_score = match group {
        Some(group) => entry.score.filter(|score| *score != group.level),
        None => None,
    };
    let risk_score = match (group, entry.score) {
        (Some(group), score) => {
            notes.add(format!("obstacle {id} was read from `{}`", group.name));
            if score.is_some_and(|score| score != group.level)
                && !group.name.to_lowercase().contains("predicted")
            {
                notes.add(format!(
                    "the score of obstacle {id} differs from that of its group, which is used"
                ));
            }
            group.level
        }
        (None, Some(score)) => score,
        (None, None) => {
            return notes.add(format!(
                "obstacle {id} has no score from 0 to 5 and was left out"
            ));
        }
    };
    found.push(ObstacleRisk {
        id,
        risk_score,
        reason: entry.reason,
        written_score,
    });
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::super::ParseQuality;
    use super::{level, *};
    use serde_json::json;

    fn noted(notes: Notes) -> usize {
        match notes.how() {
            ParseQuality::Strict => 0,
            ParseQuality::Repaired(notes) => notes.len(),
        }
    }

    #[test]
    fn probabilities_in_many_forms() {
        for (value, wanted, repairs) in [
            (json!(0.8), Some(0.8), 0),
            (json!(1), Some(1.0), 0),
            (json!("0.8"), Some(0.8), 1),
            (json!("80 %"), Some(0.8), 1),
            (json!("80%"), Some(0.8), 1),
            (json!(80), Some(0.8), 1),
            (json!(1.5), None, 1),
            (json!(-0.1), None, 1),
            (json!("high"), None, 1),
            (json!("200 %"), None, 1),
            (json!(null), None, 0),
        ] {
            let mut notes = Notes::default();
            assert_eq!(read(&value, &mut notes), wanted, "{value}");
            assert_eq!(noted(notes), repairs, "{value}");
        }
    }

    #[test]
    fn lists_in_many_forms() {
        for (list, wanted) in [
            (json!([]), &[][..]),
            (json!(null), &[]),
            (json!([7, "car 8"]), &[(7, None), (8, None)]),
            (json!({"id": "7", "probability": "90 %"}), &[(7, Some(0.9))]),
            (
                json!({"7": 0.9, "8": {"probability": 0.5}}),
                &[(7, Some(0.9)), (8, Some(0.5))],
            ),
            (
                json!([{"id": 7, "probability": 0.9}, {"id": 7, "probability": 0.1}, {"id": "7, 8"}]),
                &[(7, Some(0.9))],
            ),
        ] {
            let object = json!({"Critical_Obstacles": list, "obstacles": [{"id": 1}]});
            let found =
                critical_obstacles(object.as_object().unwrap(), &mut Notes::default()).unwrap();
            let found: Vec<_> = found.iter().map(|c| (c.id, c.probability)).collect();
            assert_eq!(found, wanted, "{list}");
        }
        let without = json!({"obstacles": []});
        assert_eq!(
            critical_obstacles(without.as_object().unwrap(), &mut Notes::default()),
            None
        );
    }

    #[test]
    fn the_probability_of_an_obstacle_is_not_that_of_the_answer() {
        let of = |object: Value| probability(object.as_object().unwrap(), &mut Notes::default());
        assert_eq!(of(json!({"answer": {"probability": 0.4}})), Some(0.4));
        assert_eq!(
            of(json!({"critical_obstacles": {"probability": 0.4}})),
            None
        );
    }

    #[test]
    fn levels_of_keys() {
        for (key, wanted) in [
            ("CollisionObstacles", Some(0)),
            ("collision_obstacle", Some(0)),
            ("ExtremeRiskObstacle", Some(1)),
            ("PredictedCollisionObstacle", Some(1)),
            ("Predicted_Extreme_Risk_Obstacle", Some(2)),
            ("HighRiskObstacleIDs", Some(2)),
            ("negligibleObstacles", Some(5)),
            ("Obstacles", None),
            ("CollisionObstacleCount", None),
            ("ObstacleID", None),
            ("collision", None),
        ] {
            assert_eq!(level(key), wanted, "{key}");
        }
    }
}
