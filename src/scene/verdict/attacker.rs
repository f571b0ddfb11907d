//! Attacker selection: obstacles ranked by risk, and the chosen one.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::ObstacleRisk;
use super::groups::{self, Entry};
use super::notes::Notes;
use super::values::{self, Id, Object};

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
    let groups = groups::groups(object);
    let by_groups = groups.iter().any(|group| group.level <= 1);
    let mut of_candidates: Vec<Entry> = candidates.map(groups::entries).unwrap_or_default();
    of_candidates.extend(
        chosen
            .filter(|v| v.is_array() || v.is_object())
            .map(groups::entries)
            .unwrap_or_default(),
    );
    let first = of_candidates.iter().find_map(|entry| known(&entry.id));
    let mut obstacles = Vec::new();
    for entry in of_candidates {
        groups::add(&mut obstacles, entry, None, notes);
    }
    obstacles.extend(groups::obstacles(object, notes));
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
