//! Finds runs: one by number, those on a scenario, and lists by filters and words.

use rusqlite::types::Value;
use rusqlite::{Connection, OptionalExtension, Row, params, params_from_iter};
use serde::{Deserialize, Serialize};

use super::{
    AnswerState, Filter, Origin, Run, RunId, RunState, SUPERSEDED, Store, StoreError,
    StoredTemplate, rows,
};
use nearmiss_record::Record;
use nearmiss_scene::verdict::Task;

/// Most of each text of a run that is read to be looked at, in bytes: as much as is taken of an answer today. Programs
/// before this one took more.
pub const MOST_SHOWN: usize = 4 << 20;

/// Most of the texts of several runs that are read to be looked at, in bytes; of the runs behind those it is
/// [`LITTLE`].
const MOST_TOGETHER: usize = 16 << 20;

/// What is read of each text where there are many long ones, in bytes.
const LITTLE: usize = 64 << 10;

/// A run in a list.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Summary {
    /// Number of the run in the store.
    pub run: i64,
    /// When it was asked, milliseconds since 1970, UTC; of a recorded one, when it was read.
    pub created_ms: i64,
    /// Where the answer comes from: asked, recorded or replayed.
    pub origin: Origin,
    /// State of the run.
    pub state: RunState,
    /// What the answer counts as: answered, unparsed, truncated, filtered, failed, cancelled, interrupted, waiting or
    /// superseded.
    #[serde(skip_deserializing)]
    pub answer_state: AnswerState,
    /// Name of the scenario: its file name without the ending.
    pub scenario: String,
    /// The question: collision, safety, recording, attacker or trajectory.
    #[schemars(with = "String")]
    pub task: Task,
    /// Frame of the description.
    pub frame: String,
    /// Prompting techniques: cp, cot and icl joined by +, or base.
    pub techniques: String,
    /// The template.
    #[serde(flatten)]
    pub template: StoredTemplate,
    /// Model asked, as provider/model.
    pub model: String,
    /// Number of the sample among answers to the same request, from 0.
    pub sample: u32,
    /// The decision of the verdict: true for a collision, a critical window or a recording of high risk; null without
    /// a yes or no.
    pub dangerous: Option<bool>,
    /// Cost in US dollars; null if unknown.
    pub cost_usd: Option<f64>,
    /// Maximum cost in US dollars; null if unknown when it was asked.
    pub most_usd: Option<f64>,
    /// Tokens of the answer, as the server counts.
    pub output_tokens: Option<u64>,
    /// Why the server ended the answer.
    pub finish: Option<String>,
    /// Whether another run counts in its place: a newer or better answer to the same request and sample.
    pub superseded: bool,
    /// Whether the run is protected from deletion.
    pub pinned: bool,
    /// Where words were searched for: a place where they occur, with `[` and `]` around them.
    pub excerpt: Option<String>,
}

impl Record for Summary {
    const NAME: &'static str = "runs-list";
    const TITLE: &'static str = "`runs list --format json`: one run a line, in short";
}

impl Summary {
    /// A row of [`columns`] with an excerpt.
    pub(super) fn from_row(row: &Row<'_>) -> Result<Self, rusqlite::Error> {
        let run: Self = rows::from_row(row)?;
        Ok(Self {
            answer_state: if run.superseded {
                AnswerState::Superseded
            } else {
                run.own_state()
            },
            ..run
        })
    }

    /// What its answer counts as where no other run counts in its place.
    #[must_use]
    pub fn own_state(&self) -> AnswerState {
        AnswerState::of_run(self.state, self.finish.as_deref(), self.dangerous.is_some())
    }
}

/// The columns of a summary, but for the excerpt.
pub(super) fn columns() -> String {
    format!(
        "runs.id AS run, created_ms, origin, state, runs.scenario AS scenario, task, frame, techniques,
         template, template_version, template_hash, model, sample,
         dangerous, cost_usd, most_usd, output_tokens, finish, {SUPERSEDED} AS superseded, pinned"
    )
}

/// A place where the words that are searched for occur.
pub(super) const EXCERPT: &str = "snippet(runs_text, -1, '[', ']', '…', 12)";

impl Store {
    /// One run, with what has arrived of it so far.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn run(&self, id: RunId) -> Result<Option<Run>, StoreError> {
        let connection = self.lock();
        let found = connection
            .prepare_cached("SELECT * FROM runs WHERE id = ?1")?
            .query_row([id.0], rows::run)
            .optional()?;
        found
            .map(|run| rows::with_pieces(&connection, run))
            .transpose()
    }

    /// The same with at most [`MOST_SHOWN`] bytes of each of its texts, for people to look at.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn run_shown(&self, id: RunId) -> Result<Option<Run>, StoreError> {
        let connection = self.lock();
        let found = shown(&connection, id, MOST_SHOWN)?;
        found
            .map(|run| rows::with_pieces(&connection, run))
            .transpose()
    }

    /// The newest runs on a scenario and a task, newest first: by the hash of its file, and those that are known by
    /// its name alone. Their texts are shortened as in [`Store::run_shown`], and more where there are many long ones.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn of_scenario(
        &self,
        scenario_hash: &str,
        name: &str,
        task: Task,
        most: usize,
    ) -> Result<Vec<Run>, StoreError> {
        let connection = self.lock();
        let mut statement = connection.prepare_cached(
            "SELECT id FROM (
                 SELECT id, created_ms FROM runs WHERE scenario_hash = ?1 AND task = ?3 AND deleted_ms IS NULL
                 UNION ALL
                 SELECT id, created_ms FROM runs WHERE scenario_hash IS NULL AND scenario = ?2 AND task = ?3
                     AND deleted_ms IS NULL)
             ORDER BY created_ms DESC, id DESC LIMIT ?4",
        )?;
        // Numbers first: a sorter would carry all the texts.
        let values = params![scenario_hash, name, task.name(), most];
        let numbers = statement.query_map(values, |row| Ok(RunId(row.get(0)?)))?;
        let numbers: Vec<RunId> = numbers.collect::<Result<_, _>>()?;
        let (mut runs, mut bytes) = (Vec::with_capacity(numbers.len()), 0);
        for id in numbers {
            let most = if bytes < MOST_TOGETHER {
                MOST_SHOWN
            } else {
                LITTLE
            };
            let Some(run) = shown(&connection, id, most)? else {
                continue;
            };
            let run = rows::with_pieces(&connection, run)?;
            bytes += run.answer.len() + run.reasoning.len();
            runs.push(run);
        }
        Ok(runs)
    }

    /// The newest runs that fit, newest first, without their texts; at most `most` of them.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn list(&self, filter: &Filter, most: usize) -> Result<Vec<Summary>, StoreError> {
        let connection = self.lock();
        let found = filter.condition(|word| self.models_with(&connection, word))?;
        let (condition, mut values) = (found.sql, found.values);
        let excerpt = if found.by_words { EXCERPT } else { "NULL" };
        values.push(Value::from(i64::try_from(most).unwrap_or(i64::MAX)));
        let sql = format!(
            "SELECT {}, {excerpt} AS excerpt
             FROM {condition} ORDER BY created_ms DESC, runs.id DESC LIMIT ?",
            columns()
        );
        let mut statement = connection.prepare_cached(&sql)?;
        let found = statement.query_map(params_from_iter(values), Summary::from_row)?;
        Ok(found.collect::<Result<_, _>>()?)
    }

    /// The numbers of all runs that fit, oldest first.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn numbers(&self, filter: &Filter) -> Result<Vec<RunId>, StoreError> {
        let connection = self.lock();
        let found = filter.condition(|word| self.models_with(&connection, word))?;
        let (condition, values) = (found.sql, found.values);
        let sql = format!("SELECT runs.id FROM {condition} ORDER BY created_ms, runs.id");
        let mut statement = connection.prepare_cached(&sql)?;
        let found = statement.query_map(params_from_iter(values), |row| Ok(RunId(row.get(0)?)))?;
        Ok(found.collect::<Result<_, _>>()?)
    }

    /// How many runs there are, deleted ones aside.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn count(&self) -> Result<u64, StoreError> {
        let connection: &Connection = &self.lock();
        let sql = "SELECT count(*) FROM runs WHERE deleted_ms IS NULL";
        Ok(connection.query_row(sql, [], |row| row.get(0))?)
    }
}

/// One run with at most so much of each of its texts.
fn shown(connection: &Connection, id: RunId, most: usize) -> Result<Option<Run>, StoreError> {
    let mut statement = connection.prepare_cached("SELECT * FROM runs WHERE id = ?1")?;
    let found = statement.query_row([id.0], |row| rows::shown(row, most));
    Ok(found.optional()?)
}
