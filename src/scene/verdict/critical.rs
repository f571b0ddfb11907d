//! Critical obstacles and probabilities, as models write them.

use std::collections::HashSet;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::groups::IDS;
use super::notes::Notes;
use super::values::{self, Id, Object};

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
pub(super) fn obstacles(object: &Object, notes: &mut Notes) -> Option<Vec<CriticalObstacle>> {
    let list = values::find(object, &LISTS)?;
    let mut seen = HashSet::new();
    let mut found = Vec::new();
    for (id, probability) in entries(list, notes) {
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

fn entries(value: &Value, notes: &mut Notes) -> Vec<(Id, Option<f64>)> {
    if values::is_nothing(value) {
        return Vec::new();
    }
    match value {
        Value::Array(items) => items.iter().flat_map(|v| entries(v, notes)).collect(),
        Value::Object(object) => {
            let stated = values::get(object, &PROBABILITIES).and_then(|v| read(v, notes));
            if let Some(ids) = values::get(object, &IDS) {
                let ids = entries(ids, notes).into_iter();
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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::super::ParseQuality;
    use super::*;
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
            let found = obstacles(object.as_object().unwrap(), &mut Notes::default()).unwrap();
            let found: Vec<_> = found.iter().map(|c| (c.id, c.probability)).collect();
            assert_eq!(found, wanted, "{list}");
        }
        let without = json!({"obstacles": []});
        assert_eq!(
            obstacles(without.as_object().unwrap(), &mut Notes::default()),
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
}
