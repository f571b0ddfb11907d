//! What reports, tables over axes and lists need of many runs, without their texts.

use nearmiss_scene::verdict::Task;
use rusqlite::{params, params_from_iter};
use serde::Deserialize;

use super::rows::{self, from_row};
use super::{
    ClaimCounts, Consumed, Filter, Key, Origin, RunId, RunState, SUPERSEDED, Store, StoreError,
    StoredTemplate, claim,
};

/// Outcome of one run.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Outcome {
    /// Its number.
    pub run: RunId,
    /// The key of the request; `None` if none was sent.
    #[serde(deserialize_with = "claim::deserialize_key")]
    pub key: Option<Key>,
    /// Name of the scenario.
    pub scenario: String,
    /// SHA-256 of its file; `None` if only its name is known.
    pub scenario_hash: Option<String>,
    /// The ego, and where its motion comes from.
    pub ego: String,
    /// Where the answer comes from.
    pub origin: Origin,
    /// The file that a recorded answer was read from.
    pub source: Option<String>,
    /// The task.
    pub task: Task,
    /// From where the scene was described.
    pub frame: String,
    /// Prompting techniques in use.
    pub techniques: String,
    /// The template.
    #[serde(flatten)]
    pub template: StoredTemplate,
    /// First and last time step of the window, where known.
    pub window: Option<(i64, i64)>,
    /// `provider/model`, as asked for.
    pub model: String,
    /// Which of several answers to the same request.
    pub sample: u32,
    /// Whether the model could call tools.
    pub with_tools: bool,
    /// Where it stands.
    pub state: RunState,
    /// Why the model stopped, where it said so.
    pub finish: Option<String>,
    /// The verdict as JSON, where there is one.
    pub verdict: Option<String>,
    /// How the verdict was read, or why there is none.
    pub reading: Option<String>,
    /// Why there is no answer.
    pub error: Option<String>,
    /// The most that it can have cost, US dollars, where that was known when it was asked.
    pub most_usd: Option<f64>,
    /// What it consumed.
    #[serde(flatten)]
    pub consumed: Consumed,
    /// Its claims about obstacles, where they were checked.
    #[serde(flatten)]
    pub claims: ClaimCounts,
}

impl Store {
    /// Outcomes of all matching runs, oldest first. Their texts are not read.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn outcomes(&self, filter: &Filter) -> Result<Vec<Outcome>, StoreError> {
        let connection = self.lock();
        let found = filter.condition(|word| self.models_with(&connection, word))?;
        let (condition, values) = (found.sql, found.values);
        let sql = format!(
            "SELECT runs.id AS run, runs.scenario AS scenario, scenario_hash, ego, origin, source, task, frame, techniques,
                 template, template_version, template_hash, window_first, window_last, model, sample,
                 json_valid(parameters) AND json_extract(parameters, '$.tools') IS NOT NULL AS with_tools, state, finish, verdict, reading, error, most_usd, input_tokens, output_tokens,
                 reasoning_tokens, cached_tokens, cost_usd, first_chunk_ms, duration_ms, key,
                 claims_right, claims_wrong, claims_open, claims_check
             FROM {condition} ORDER BY created_ms, runs.id"
        );
        let mut statement = connection.prepare_cached(&sql)?;
        let found = statement.query_map(params_from_iter(values), rows::from_row)?;
        Ok(found.collect::<Result<_, _>>()?)
    }
}

/// When and of what a run was asked.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
pub struct RunOrigin {
    /// Its number.
    pub run: RunId,
    /// When it was asked, milliseconds since 1970, UTC.
    pub created_ms: i64,
    /// `provider/model`, as asked for.
    pub model: String,
    /// The model as the server named it.
    pub model_returned: Option<String>,
    /// File name of the template.
    pub template: String,
    /// SHA-256 of its text.
    pub template_hash: String,
    /// SHA-256 of the scenario file.
    pub scenario_hash: Option<String>,
    /// The parameters that were sent, as JSON.
    pub parameters: String,
}

impl Store {
    /// The origins of all runs that are not deleted, oldest number first.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn origins(&self) -> Result<Vec<RunOrigin>, StoreError> {
        let connection = self.lock();
        let mut statement = connection.prepare_cached(
            "SELECT id AS run, created_ms, model, model_returned, template, template_hash, scenario_hash,
                 parameters
             FROM runs WHERE deleted_ms IS NULL ORDER BY id",
        )?;
        let rows = statement.query_map([], from_row)?;
        Ok(rows.collect::<Result<_, _>>()?)
    }
}

/// Verdict of a stored answer.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
pub struct StoredVerdict {
    /// SHA-256 of the scenario's file; `None` if only its name is known.
    pub scenario_hash: Option<String>,
    /// Name of the scenario.
    pub scenario: String,
    /// The ego, and where its motion comes from.
    pub ego: String,
    /// Where the answer comes from.
    pub origin: Origin,
    /// The task.
    pub task: Task,
    /// First and last time step of the window, where known.
    pub window: Option<(i64, i64)>,
    /// Yes or no.
    pub dangerous: bool,
}

impl Store {
    /// The verdicts in all whole answers, whatever template they were asked with, without those in whose place another
    /// answer to the same request counts ([`SUPERSEDED`]) and those of the model `but`; all of them, or those about one
    /// scenario, by hash and name as in [`Store::of_scenario`].
    ///
    /// # Errors
    /// SQLite refused.
    pub fn verdicts(
        &self,
        but: &str,
        of: Option<(&str, &str)>,
    ) -> Result<Vec<StoredVerdict>, StoreError> {
        let connection = self.lock();
        let which = match of {
            None => "?2 IS NULL AND ?3 IS NULL",
            Some(_) => "(scenario_hash = ?2 OR (scenario_hash IS NULL AND scenario = ?3))",
        };
        let sql = format!(
            "SELECT scenario_hash, scenario, ego, origin, task, window_first, window_last, dangerous
             FROM runs
             WHERE deleted_ms IS NULL AND state = 'answered' AND dangerous IS NOT NULL AND model <> ?1 AND {which}
                 AND NOT {SUPERSEDED}"
        );
        let mut statement = connection.prepare_cached(&sql)?;
        let (hash, name) = of.unzip();
        let found = statement.query_map(params![but, hash, name], rows::from_row)?;
        Ok(found.collect::<Result<_, _>>()?)
    }
}
