//! What a template must not have from the scenarios it is tuned on: their names, ids, and numbers of their scenes.

use std::collections::BTreeSet;
use std::hash::{DefaultHasher, Hash, Hasher};

use nearmiss_scene::scenario::identity;
use nearmiss_study::evaluation::Question;

/// Names, ids and numbers of the dev scenarios.
#[derive(Debug, Default)]
pub(super) struct Traces {
    /// In small letters.
    names: BTreeSet<String>,
    ids: BTreeSet<u64>,
    /// Hashes of so many numbers in a row.
    runs: BTreeSet<u64>,
}

/// So many numbers in the same order are no chance.
const IN_A_ROW: usize = 5;

/// Shorter names are words of the language, too.
const SHORTEST_NAME: usize = 6;

/// Ids from here on are no quantities of a rule.
const LONG_ID: u64 = 100;

/// What obstacles are called in descriptions, before their ids.
const KINDS: [&str; 14] = [
    "obstacle",
    "vehicle",
    "car",
    "truck",
    "bus",
    "van",
    "bicycle",
    "cyclist",
    "motorcycle",
    "pedestrian",
    "train",
    "id",
    "object",
    "building",
];

impl Traces {
    pub fn new<'a>(scenarios: &[String], questions: impl Iterator<Item = &'a Question>) -> Self {
        let mut found = Self::default();
        for name in scenarios {
            let parts = [name.as_str(), identity::family(name)];
            let long = parts.iter().filter(|name| name.len() >= SHORTEST_NAME);
            found.names.extend(long.map(|name| name.to_lowercase()));
        }
        for question in questions {
            let scene = &question.case.scene;
            let ids = scene.scenario.obstacles.iter().map(|obstacle| obstacle.id);
            found
                .ids
                .extend(ids.filter_map(|id| u64::try_from(id).ok()));
            found.runs.extend(runs(&question.description));
        }
        found
    }

    /// What of the scenarios a text says that `before` does not.
    pub fn found(&self, text: &str, before: &str) -> Option<String> {
        let (small, before_small) = (text.to_lowercase(), before.to_lowercase());
        let name = self
            .names
            .iter()
            .find(|name| small.contains(name.as_str()) && !before_small.contains(name.as_str()));
        if let Some(name) = name {
            return Some(format!("it names a scenario that it was tuned on ({name})"));
        }
        let known = self.named_ids(&before_small);
        if let Some(id) = self.named_ids(&small).difference(&known).next() {
            return Some(format!(
                "it names obstacle {id} of a scene that it was tuned on"
            ));
        }
        let known: BTreeSet<u64> = runs(before).collect();
        runs(text)
            .any(|run| self.runs.contains(&run) && !known.contains(&run))
            .then(|| {
                format!("it copies {IN_A_ROW} numbers in a row of a scene that it was tuned on")
            })
    }

    /// The ids of obstacles in a text of small letters.
    fn named_ids(&self, text: &str) -> BTreeSet<u64> {
        let mut found = BTreeSet::new();
        let mut before = "";
        for word in text.split(|c: char| !(c.is_alphanumeric() || c == '.' || c == '_')) {
            let word = word.trim_matches('.');
            if let Ok(id) = word.parse::<u64>()
                && self.ids.contains(&id)
                && (id >= LONG_ID || KINDS.contains(&before.trim_end_matches('s')))
            {
                found.insert(id);
            }
            if !word.is_empty() {
                before = word;
            }
        }
        found
    }
}

/// A hash of each [`IN_A_ROW`] numbers in a row with a fraction: times and whole numbers repeat in every scene.
fn runs(text: &str) -> impl Iterator<Item = u64> {
    let numbers: Vec<&str> = text
        .split(|c: char| !(c.is_ascii_digit() || c == '.'))
        .map(|number| number.trim_matches('.'))
        .filter(|number| number.contains('.') && !number.trim_matches(['0', '.']).is_empty())
        .collect();
    let hash = |run: &[&str]| {
        let mut hasher = DefaultHasher::new();
        run.hash(&mut hasher);
        hasher.finish()
    };
    let all: Vec<u64> = numbers.windows(IN_A_ROW).map(hash).collect();
    all.into_iter()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_ids_and_numbers_in_a_row_are_traces() {
        let traces = Traces {
            names: BTreeSet::from(["deu_town-7".to_string()]),
            ids: BTreeSet::from([7, 301]),
            runs: runs("car 301: 3.25 m, 1.50 m/s, 0.00 s, 7.75 m, 8.50 m, 9.25 m").collect(),
        };
        let found = |text: &str, before: &str| traces.found(text, before).unwrap_or_default();
        assert!(found("as in DEU_Town-7_1_T-1", "").contains("names a scenario"));
        assert!(found("mind 301 then", "").contains("obstacle 301"));
        assert!(found("mind car 7 then", "").contains("obstacle 7"));
        assert_eq!(found("wait 7 s", ""), "");
        assert_eq!(found("car 301 is far", "Example: car 301"), "");
        let copied = "3.25 and 1.50 and 7.75 and 8.50 and 9.25";
        assert!(found(copied, "").contains("numbers in a row"));
        assert_eq!(found(copied, copied), "");
        assert_eq!(found("3.25 and 1.50 and 7.75 and 8.50 and 9.5", ""), "");
    }
}
