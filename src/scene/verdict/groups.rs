//! Obstacles in the paper's terms: grouped by risk level, as lists, single objects or bare ids.

use serde_json::Value;

use super::ObstacleRisk;
use super::notes::Notes;
use super::values::{self, Id, LEVELS, Object, plain};

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
const LISTS: [&str; 5] = [
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
    if let Some(list) = values::find(object, &LISTS) {
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
    use super::level;

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
