//! What decides what is made of a scenario, so that it is made again, or reused.

use std::collections::BTreeMap;
use std::sync::Arc;

use nearmiss_drive::generation::{AttackStyle, DELAYS, Effort, MOST_ATTACKERS, Wish};
use nearmiss_drive::simulation::{ExternalPlanner, Settings};
use nearmiss_scene::description::visible;
use nearmiss_settings::Planning;
use nearmiss_study::evaluation::generating::Method;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use crate::journal::{RunSettings, SettingDifference};

/// A reaction time of an ideal driver that is looked at, seconds.
///
/// # Errors
/// It is another one.
pub fn reaction_time(word: &str) -> Result<f64, String> {
    let said = word.parse::<f64>().ok();
    let known = DELAYS.into_iter().find(|delay| Some(*delay) == said);
    known.ok_or_else(|| {
        let known = DELAYS.map(|delay| format!("{delay:.1}"));
        format!("expected one of {}", known.join(", "))
    })
}

/// A number of motions that are tried.
///
/// # Errors
/// It is none, or too large.
pub fn candidate_count(word: &str) -> Result<usize, String> {
    match word.parse() {
        Ok(n) if (1..=100_000).contains(&n) => Ok(n),
        _ => Err("expected a number from 1 to 100000".into()),
    }
}

/// A number of attackers.
///
/// # Errors
/// It is none, or too large.
pub fn attacker_count(word: &str) -> Result<usize, String> {
    match word.parse() {
        Ok(n) if (1..=MOST_ATTACKERS).contains(&n) => Ok(n),
        _ => Err(format!("expected a number from 1 to {MOST_ATTACKERS}")),
    }
}

/// The obstacles that may attack, each once: their order makes no difference.
#[must_use]
pub fn distinct_attackers(ids: &[i64]) -> Vec<i64> {
    let mut ids = ids.to_vec();
    ids.sort_unstable();
    ids.dedup();
    ids
}

/// How many obstacles attack together at most, where `asked` were asked for, `named` may attack (0: any), and the
/// configuration says `usual`. Messages begin with `options`: that of the number, with what stands before it, and that of
/// the obstacles.
///
/// # Errors
/// More than are named.
pub fn attackers_together(
    asked: Option<usize>,
    named: usize,
    usual: Option<usize>,
    options: (&str, &str),
) -> Result<usize, String> {
    match (asked, named) {
        (Some(n), ids) if ids > 0 && n > ids => Err(format!(
            "{}{n}: {} names {}; name at least {n}, or none",
            options.0,
            options.1,
            if ids == 1 {
                "1 obstacle".into()
            } else {
                format!("{ids} obstacles")
            }
        )),
        (Some(n), _) => Ok(n),
        (None, 0) => Ok(usual.unwrap_or(1)),
        (None, ids) => Ok(ids.min(MOST_ATTACKERS)),
    }
}

/// What decides what is made of a scenario, but for its content.
#[derive(Debug, Clone)]
pub struct AttackRequest {
    /// How the ego is planned.
    pub settings: Settings,
    /// The planner that is attacked; the built-in one where none is named.
    pub planner: Option<Arc<ExternalPlanner>>,
    /// How far the search goes, its seed, and the reaction time of the ideal driver who has to survive.
    pub effort: Effort,
    /// Whose limits attackers keep.
    pub style: AttackStyle,
    /// The obstacles that may attack, each once and in order; any where none is named.
    pub only: Vec<i64>,
    /// What attacks are wished to be.
    pub wish: Option<Wish>,
}

impl AttackRequest {
    /// The author where the search is it: the search with its settings.
    #[must_use]
    pub fn search_in_words(&self) -> String {
        let Self { effort, style, .. } = self;
        match &self.wish {
            Some(wish) => format!("{effort}, wish: {wish}, style {style}"),
            None => format!("{effort}, style {style}"),
        }
    }

    /// All that decides what is made of a scenario but for its content, where its planning problem is that one and
    /// `writer` writes the attack, else the search: two runs with the same make the same.
    #[must_use]
    pub fn settings(&self, problem: i64, writer: Option<WriterSettings>) -> GenerationSettings {
        let effort = &self.effort;
        // Attacks are always judged in recorded traffic.
        let planning = Planning::values(&self.settings)
            .into_iter()
            .filter(|(key, _)| key != "traffic")
            .map(|(key, value)| (key, json!(value)));
        GenerationSettings {
            problem,
            planning: planning.collect(),
            attacker: self.only.clone(),
            attackers: effort.together,
            survive: effort.delay,
            style: self.style.name().into(),
            search: writer.is_none().then_some(SearchSettings {
                candidates: effort.candidates,
                rounds: effort.rounds,
                drives: effort.drives,
                attackers: effort.attackers,
                seed: effort.seed,
            }),
            model: writer,
            wish: self.wish.as_ref().map(ToString::to_string),
            planner: self
                .planner
                .as_ref()
                .map(|planner| PlannerProcess::new(planner)),
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
    #[must_use]
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
    #[must_use]
    pub fn with_identity(mut self, identity: Option<(String, String)>) -> Self {
        if let Some(planner) = &mut self.planner {
            (planner.name, planner.version) = identity.unzip();
        }
        self
    }

    /// Where these are others than those asked for now: `key then, now`.
    #[must_use]
    pub fn differences(&self, now: &Self) -> Vec<String> {
        if self.planner.is_some() != now.planner.is_some() {
            // Of a planner in place of another kind of planner the command says all.
            let named = |settings: &Self| match &settings.planner {
                Some(planner) => planner.command(),
                None => "the built-in one".into(),
            };
            let words = format!("planner {}, now {}", named(self), named(now));
            return vec![visible(&words).into_owned()];
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
        visible(&difference.to_string()).into_owned()
    })
}
