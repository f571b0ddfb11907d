//! What decides what is made of a scenario, as manifests record it: a variant made with the same settings is reused.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::output;
use nearmiss_drive::simulation::ExternalPlanner;
use nearmiss_study::evaluation::generating::Method;
use nearmiss_workflow::journal::{RunSettings, SettingDifference};

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
    /// Reaction time of the good driver who has to survive, seconds.
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
        found.iter().filter_map(words).collect()
    }
}

/// A difference in words; nothing where it makes none.
fn words(difference: &SettingDifference) -> Option<String> {
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
