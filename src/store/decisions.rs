//! Outcomes of all yes-or-no questions in one query, for overall figures.

use serde::Deserialize;

use super::{RunId, RunState, Store, StoreError, rows};
use crate::verdict::Task;

/// Outcome of a question, without its texts.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
pub struct StoredOutcome {
    /// The run's number.
    pub run: RunId,
    /// SHA-256 of the scenario's file; `None` if only its name is known.
    pub scenario_hash: Option<String>,
    /// Name of the scenario.
    pub scenario: String,
    /// The ego, and where its motion comes from.
    pub ego: String,
    /// The task.
    pub task: Task,
    /// The frame of the description.
    pub frame: String,
    /// The prompting techniques.
    pub techniques: String,
    /// The model, `provider/model`.
    pub model: String,
    /// Sample number among answers to the same question.
    pub sample: u32,
    /// First and last time step of the window, where known.
    pub window: Option<(i64, i64)>,
    /// Its state.
    pub state: RunState,
    /// Yes or no; `None` if no verdict was parsed.
    pub dangerous: Option<bool>,
    /// For a yes to the safety task: the obstacles it names, with their risk scores.
    #[serde(deserialize_with = "named")]
    pub named: Vec<(i64, u8)>,
}

impl Store {
    /// Outcomes of all ended runs with a task of [`Task::VERDICTS`], newest first, without deleted and cancelled ones.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn decisions(&self) -> Result<Vec<StoredOutcome>, StoreError> {
        let connection = self.lock();
        let mut statement = connection.prepare_cached(
            "SELECT id AS run, scenario_hash, scenario, ego, task, frame, techniques, model, sample,
                 window_first, window_last, state, dangerous,
                 CASE WHEN task = 'safety' AND dangerous = 1 THEN verdict END AS named
             FROM runs
             WHERE deleted_ms IS NULL AND task IN (?1, ?2) AND state NOT IN (?3, ?4)
             ORDER BY created_ms DESC, id DESC",
        )?;
        let [first, second] = Task::VERDICTS.map(Task::name);
        let left_out = [RunState::Running.name(), RunState::Cancelled.name()];
        let wanted = [first, second, left_out[0], left_out[1]];
        let found = statement.query_map(wanted, rows::from_row)?;
        Ok(found.collect::<Result<_, _>>()?)
    }
}

/// The obstacles of a stored verdict, with their scores.
fn named<'de, D: serde::Deserializer<'de>>(from: D) -> Result<Vec<(i64, u8)>, D::Error> {
    let verdict = Option::<String>::deserialize(from)?;
    let read = verdict.and_then(|json| serde_json::from_str::<serde_json::Value>(&json).ok());
    let all = read.as_ref().and_then(|v| v["obstacles"].as_array());
    let one = |o: &serde_json::Value| {
        let score = u8::try_from(o["risk_score"].as_u64()?).ok()?;
        Some((o["id"].as_i64()?, score))
    };
    Ok(all.into_iter().flatten().filter_map(one).collect())
}
