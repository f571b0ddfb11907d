//! Provenance: which program, answers, templates, scenarios and thresholds stand behind an export.

use std::collections::{BTreeMap, BTreeSet};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::batch::Spec;
use nearmiss_store::{BatchId, Item, RunId, Store, StoreError};

/// What an export was made from.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
pub struct Provenance {
    /// The program with its version.
    pub program: String,
    /// The commit that it was built from, where that is known.
    pub commit: Option<String>,
    /// The batch, such as `b7`; null if the export is not of one.
    pub batch: Option<String>,
    /// The day of the first answer, UTC.
    pub answered_from: Option<String>,
    /// The day of the last answer, UTC.
    pub answered_until: Option<String>,
    /// The models as they were asked for, each with the names that servers returned.
    pub models: BTreeMap<String, Vec<String>>,
    /// The templates by file name, each with the hash of its text and fragments; several of one name are joined by `+`.
    pub templates: BTreeMap<String, String>,
    /// Scenario files that are known by their hash.
    pub scenarios: usize,
    /// SHA-256 of the sorted hashes of the scenario files, one a line; null without one.
    pub scenarios_sha256: Option<String>,
    /// Changes to the shipped thresholds; null where none are used.
    pub thresholds: Option<Vec<String>>,
    /// SHA-256 of these changes, one a line.
    pub thresholds_sha256: Option<String>,
}

impl Provenance {
    /// This program, and nothing else.
    #[must_use]
    pub fn of_program() -> Self {
        Self {
            program: format!("nearmiss {}", env!("CARGO_PKG_VERSION")),
            commit: option_env!("NEARMISS_COMMIT").map(str::to_string),
            ..Self::default()
        }
    }

    /// That of stored runs.
    ///
    /// # Errors
    /// The store cannot be read.
    pub fn of_runs(store: &Store, runs: &BTreeSet<RunId>) -> Result<Self, StoreError> {
        let mut found = Self::of_program();
        let mut hashes = BTreeSet::new();
        let mut models: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
        let mut templates: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
        let (mut first, mut last) = (None::<i64>, None::<i64>);
        for one in store.origins()? {
            if !runs.contains(&one.run) {
                continue;
            }
            first = Some(first.map_or(one.created_ms, |ms| ms.min(one.created_ms)));
            last = last.max(Some(one.created_ms));
            let returned = models.entry(one.model).or_default();
            returned.extend(one.model_returned);
            if !one.template.is_empty() && !one.template_hash.is_empty() {
                let of_name = templates.entry(one.template).or_default();
                of_name.insert(one.template_hash);
            }
            hashes.extend(one.scenario_hash);
        }
        (found.answered_from, found.answered_until) = (first.and_then(day), last.and_then(day));
        found.models = models
            .into_iter()
            .map(|(model, returned)| (model, returned.into_iter().collect()))
            .collect();
        found.templates = templates
            .into_iter()
            .map(|(file, hashes)| (file, hashes.into_iter().collect::<Vec<_>>().join("+")))
            .collect();
        found.set_scenarios(&hashes);
        Ok(found)
    }

    /// That of a batch and the runs that count of it.
    ///
    /// # Errors
    /// The store cannot be read.
    pub fn of_batch(
        store: &Store,
        (id, spec, items): (BatchId, &Spec, &[Item]),
        runs: &BTreeSet<RunId>,
    ) -> Result<Self, StoreError> {
        let mut found = Self::of_runs(store, runs)?;
        found.batch = Some(id.to_string());
        found.templates.clone_from(&spec.templates);
        let hashes = items.iter().filter_map(|i| i.asked.scenario_hash.clone());
        found.set_scenarios(&hashes.collect());
        found.set_thresholds(spec.thresholds.clone());
        Ok(found)
    }

    /// Notes the scenario files by their hashes.
    pub fn set_scenarios(&mut self, hashes: &BTreeSet<String>) {
        self.scenarios = hashes.len();
        let some = !hashes.is_empty();
        self.scenarios_sha256 = some.then(|| lines_hash(hashes.iter().map(String::as_str)));
    }

    /// Notes the changes to the shipped thresholds.
    pub fn set_thresholds(&mut self, changes: Vec<String>) {
        self.thresholds_sha256 = Some(lines_hash(changes.iter().map(String::as_str)));
        self.thresholds = Some(changes);
    }

    /// In one sentence, for people.
    #[must_use]
    pub fn summary(&self) -> String {
        let mut parts = vec![match &self.commit {
            Some(commit) => format!("{} ({commit})", self.program),
            None => self.program.clone(),
        }];
        parts.extend(self.batch.as_ref().map(|batch| format!("batch {batch}")));
        parts.extend(match (&self.answered_from, &self.answered_until) {
            (Some(first), Some(last)) if first == last => Some(format!("answers of {first}")),
            (Some(first), Some(last)) => Some(format!("answers of {first} to {last}")),
            _ => None,
        });
        if !self.models.is_empty() {
            let models = self.models.iter().map(|(asked, returned)| {
                let returned = if returned.is_empty() {
                    "not named by the server".into()
                } else {
                    returned.join(", ")
                };
                format!("{asked} ({returned})")
            });
            let models: Vec<String> = models.collect();
            parts.push(format!("models as returned: {}", models.join(", ")));
        }
        if !self.templates.is_empty() {
            let templates = self.templates.iter();
            let named: Vec<_> = templates
                .map(|(f, hash)| format!("{f} {}", short(hash)))
                .collect();
            parts.push(format!("templates {}", named.join(", ")));
        }
        if let Some(hash) = &self.scenarios_sha256 {
            let files = if self.scenarios == 1 { "file" } else { "files" };
            parts.push(format!(
                "{} scenario {files}, {}",
                self.scenarios,
                short(hash)
            ));
        }
        if let (Some(changes), Some(hash)) = (&self.thresholds, &self.thresholds_sha256) {
            parts.push(if changes.is_empty() {
                "shipped thresholds".into()
            } else {
                format!("thresholds {} ({})", short(hash), changes.join(", "))
            });
        }
        format!("Provenance: {}.", parts.join("; "))
    }
}

fn short(hash: &str) -> &str {
    hash.get(..12).unwrap_or(hash)
}

/// The day of a time in milliseconds since 1970, UTC.
fn day(ms: i64) -> Option<String> {
    let time = jiff::Timestamp::from_millisecond(ms).ok()?;
    Some(time.strftime("%Y-%m-%d").to_string())
}

fn lines_hash<'a>(lines: impl Iterator<Item = &'a str>) -> String {
    let mut digest = Sha256::new();
    for line in lines {
        digest.update(line.as_bytes());
        digest.update(b"\n");
    }
    digest
        .finalize()
        .iter()
        .map(|b| format!("{b:02x}"))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hashes_do_not_depend_on_order_and_words_name_everything() {
        let mut one = Provenance::of_program();
        one.set_scenarios(&["b", "a"].map(String::from).into());
        let mut other = Provenance::of_program();
        other.set_scenarios(&["a", "b"].map(String::from).into());
        assert_eq!(one, other);
        one.batch = Some("b7".into());
        one.set_thresholds(vec!["limit tau 2 s".into()]);
        one.models.insert("lab/a".into(), vec!["a-1".into()]);
        (one.answered_from, one.answered_until) = (day(0), day(86_400_000));
        let words = one.summary();
        for part in [
            "batch b7",
            "1970-01-01 to 1970-01-02",
            "lab/a (a-1)",
            "2 scenario files",
            "limit tau 2 s",
        ] {
            assert!(words.contains(part), "{words}");
        }
    }
}
