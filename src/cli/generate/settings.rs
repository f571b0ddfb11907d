//! What `generate` starts from: scenarios to attack, settings, and what of them decides what is made, so that it is reused.

use std::collections::{BTreeMap, HashSet};
use std::io::Read;
use std::path::{Path, PathBuf};

use nearmiss_base::system::{self, unknown};
use nearmiss_drive::generation::MARK;
use nearmiss_drive::simulation::ExternalPlanner;
use nearmiss_formats::{Entry, EntryLocation};
use nearmiss_record::fields::{Fields, Layers};
use nearmiss_settings::{Config, Planning};
use nearmiss_study::evaluation::generating::{Method, RETRIES, Ranking, SAMPLES, VOTES};
use nearmiss_workflow::journal::{RunSettings, SettingDifference};
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::{Failure, knobs, output, plan};

nearmiss_record::fields! {
    /// How a model is asked.
    pub struct AskSettings {
        "model" {
            /// Votes for the attacker.
            votes: u32 = VOTES, Takes::Whole(1, 1000);
            /// The model chooses the attacker within this distance; by default as the configuration says.
            within: Option<f64>, Takes::Above(0.0, 1e6), "m";
            /// Motions.
            samples: u32 = SAMPLES, Takes::Whole(1, 1000);
            /// How often a motion goes back to the model.
            retries: u32 = RETRIES, Takes::Whole(0, 100);
            /// Whether what came of the drive goes back to the model.
            feedback: bool = true;
            /// Whether the model grades its motions.
            grades: bool = true;
            /// What decides between its motions.
            rank: Ranking;
            /// Whether nothing is generated where the model names no possible attacker.
            obey: bool;
        }
    }
}

/// Every key.
pub fn keys() -> impl Iterator<Item = String> {
    Planning::keys().chain(AskSettings::rows().iter().map(|row| row.key.into()))
}

/// What is set.
pub fn read(set: &[(String, String)], config: &Config) -> Result<(Planning, AskSettings), Failure> {
    let keys: Vec<String> = keys().collect();
    if let Some((key, _)) = set.iter().find(|(key, _)| !keys.contains(key)) {
        let keys = keys.iter().map(String::as_str);
        return Err(Failure::input(unknown("key", key, keys)));
    }
    let (asking, planning): (Vec<_>, Vec<_>) =
        { set.iter().cloned() }.partition(|(key, _)| AskSettings::row(key).is_ok());
    let asking = knobs::read(Layers::default(), &asking)?;
    Ok((plan::planning(&planning, config)?, asking))
}

impl AskSettings {
    /// How a model is asked.
    pub fn method(&self, config: &Config) -> Method {
        Method {
            votes: self.votes,
            within: self.within.unwrap_or(config.attack_within),
            samples: self.samples,
            retries: self.retries,
            feedback: self.feedback,
            grades: self.grades,
            rank: self.rank,
        }
    }
}

/// All settings of a variant but for the content of its original.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct GenerationSettings {
    /// Id of the planning problem.
    pub problem: i64,
    /// The planner's settings by key, without the traffic, which is as recorded.
    pub planning: BTreeMap<String, Value>,
    /// The obstacles that may attack; any where none is named.
    pub attacker: Vec<i64>,
    /// How many attack together at most.
    pub attackers: usize,
    /// Reaction time of the ideal driver who has to survive, seconds.
    pub survive: f64,
    /// Whose limits attackers keep.
    pub style: String,
    /// The search, where no model writes the attack.
    pub search: Option<SearchSettings>,
    /// The model that writes it.
    pub model: Option<WriterSettings>,
    /// What attacks are wished to be.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wish: Option<String>,
    /// The planner that is attacked, where that is a process.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub planner: Option<PlannerProcess>,
}

/// How far a search goes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SearchSettings {
    /// Motions tried at most.
    pub candidates: usize,
    /// See [`nearmiss_drive::generation::Effort`].
    pub rounds: usize,
    /// See there.
    pub drives: usize,
    /// See there.
    pub attackers: usize,
    /// Of the search.
    pub seed: u64,
}

/// How a model is asked.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct WriterSettings {
    /// Its id.
    pub id: String,
    /// How often, and what for.
    pub method: Method,
    /// Whether its choice of no attacker counts.
    pub obey: bool,
    /// Parameters of its requests.
    pub parameters: Value,
    /// Templates by name, each with its hash.
    pub templates: BTreeMap<String, String>,
    /// Changes to the shipped thresholds.
    pub thresholds: Vec<String>,
}

/// A planner's process, and what it says of itself.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PlannerProcess {
    command: Vec<String>,
    /// To get ready, and for a cycle.
    seconds: [f64; 2],
    predictions: bool,
    history: usize,
    clock: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    name: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    version: Option<String>,
}

impl PlannerProcess {
    /// That of a planner that has not run yet.
    pub fn new(planner: &ExternalPlanner) -> Self {
        let options = planner.options();
        Self {
            command: options.command.clone(),
            seconds: [options.start.as_secs_f64(), options.cycle.as_secs_f64()],
            predictions: options.predictions,
            history: options.history,
            clock: options.clock.name().into(),
            name: None,
            version: None,
        }
    }

    fn command(&self) -> String {
        format!("`{}`", self.command.join(" "))
    }
}

/// How a difference of prompts begins.
pub const PROMPTS: &str = "model.templates";

/// How a search goes about it: no option sets these, and what another version found stays found.
const SEARCH: [&str; 3] = ["search.rounds", "search.drives", "search.attackers"];

/// What a planner's process says of itself.
const IDENTITY: [&str; 2] = ["planner.name", "planner.version"];

impl GenerationSettings {
    /// The same with name and version of the planner's process, where one is attacked.
    pub fn with_identity(mut self, identity: Option<(String, String)>) -> Self {
        if let Some(planner) = &mut self.planner {
            (planner.name, planner.version) = identity.unzip();
        }
        self
    }

    /// Where these are others than those asked for now: `key then, now`.
    pub fn differences(&self, now: &Self) -> Vec<String> {
        if self.planner.is_some() != now.planner.is_some() {
            // Of a planner in place of another kind of planner the command says all.
            let named = |settings: &Self| match &settings.planner {
                Some(planner) => planner.command(),
                None => "the built-in one".into(),
            };
            let words = format!("planner {}, now {}", named(self), named(now));
            return vec![output::visible(&words)];
        }
        let of = |settings: &Self| RunSettings::new(settings).unwrap_or_default();
        let found = of(self).differences(&of(now));
        found.iter().filter_map(difference_note).collect()
    }
}

/// A difference in words; nothing where it makes none.
fn difference_note(difference: &SettingDifference) -> Option<String> {
    let key = difference.key.as_str();
    // A planner that does not get ready is found out when it drives.
    let unknown = difference.now.is_none() && IDENTITY.contains(&key);
    if unknown || SEARCH.contains(&key) {
        return None;
    }
    Some(if key.starts_with(PROMPTS) {
        format!("{key}, another version")
    } else {
        output::visible(&difference.to_string())
    })
}

/// The attributes of the root element, and with them its `source`, lie within so many bytes.
const HEAD: u64 = 1 << 16;

/// More variants are not named each.
const MAX_VARIANTS_LISTED: usize = 5;

/// What of `entries`, found at `paths`, is to be attacked.
///
/// # Errors
/// Nothing but variants was found.
pub fn originals(mut entries: Vec<Entry>, paths: &[PathBuf]) -> Result<Vec<Entry>, Failure> {
    let mut seen = HashSet::new();
    // The same file by two ways: `a.xml` and `./a.xml`.
    entries.retain(|entry| match &entry.place {
        EntryLocation::File(path) => path.canonicalize().map_or(true, |real| seen.insert(real)),
        EntryLocation::Bundled(_) => true,
    });
    let mut variants = Vec::new();
    entries.retain(|entry| {
        let EntryLocation::File(path) = &entry.place else {
            return true;
        };
        let kept = paths.contains(path) || !is_variant(path);
        if !kept {
            variants.push(entry.name.clone());
        }
        kept
    });
    if variants.is_empty() {
        return Ok(entries);
    }
    let mut words = variants[..variants.len().min(MAX_VARIANTS_LISTED)].join(", ");
    if variants.len() > MAX_VARIANTS_LISTED {
        words = format!("{words} and {} more", variants.len() - MAX_VARIANTS_LISTED);
    }
    if entries.is_empty() {
        return Err(Failure::input(format!(
            "all scenarios are variants made by nearmiss ({words}); name a file to use it as an original"
        )));
    }
    let (count, are) = match variants.len() {
        1 => ("1 variant".into(), "is"),
        n => (format!("{n} variants"), "are"),
    };
    output::say(&format!(
        "nearmiss: {count} of earlier runs {are} skipped: {words}; name a file to use it as an original"
    ));
    Ok(entries)
}

/// Whether the head of a file says that nearmiss has made it. One that cannot be read is named when it is its turn.
fn is_variant(path: &Path) -> bool {
    let Ok(file) = system::open_file(path) else {
        return false;
    };
    let mut head = Vec::new();
    let read = file.take(HEAD).read_to_end(&mut head);
    read.is_ok() && head.windows(MARK.len()).any(|part| part == MARK.as_bytes())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use nearmiss_formats::find;

    #[test]
    fn variants_in_a_folder_are_left_out_unless_they_are_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        let variant = format!("<commonRoad source=\"a field; {MARK}1.0: b\"/>");
        std::fs::write(path("original.xml"), "<commonRoad/>").unwrap();
        std::fs::write(path("variant.xml"), variant).unwrap();
        let names = |paths: &[PathBuf]| {
            let kept = originals(find(paths).unwrap().entries, paths);
            kept.map(|kept| kept.into_iter().map(|e| e.name).collect::<Vec<_>>())
        };
        let all = [folder.path().to_path_buf()];
        assert_eq!(names(&all).unwrap(), ["original"]);
        let both = [folder.path().to_path_buf(), path("variant.xml")];
        assert_eq!(names(&both).unwrap(), ["original", "variant"]);
        // The same file by another way is there once.
        let twice = [path("original.xml"), folder.path().join("./original.xml")];
        assert_eq!(names(&twice).unwrap(), ["original"]);
        std::fs::remove_file(path("original.xml")).unwrap();
        let failure = names(&all).unwrap_err();
        assert_eq!(failure.status, 2);
        assert!(failure.message.contains("all scenarios are variants"));
    }
}
