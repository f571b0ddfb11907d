//! Finds runs: one by number, those on a scenario, and lists by filters and words, whole or in pages.

use nearmiss_scene::verdict::Task;
use rusqlite::types::Value;
use rusqlite::{Connection, InterruptHandle, OptionalExtension, Row, params, params_from_iter};
use serde::{Deserialize, Serialize};

use nearmiss_record::Record;

use super::database::all_rows;
use super::filter::Condition;
use super::{
    AnswerState, Filter, Origin, Run, RunId, RunState, SUPERSEDED, Store, StoreError,
    StoredTemplate, rows,
};

/// Most of each text of a run that is read to be looked at, in bytes: as much as is taken of an answer today. Programs
/// before this one took more.
pub const MOST_SHOWN: usize = 4 << 20;

/// Most of the texts of several runs that are read to be looked at, in bytes; of the runs behind those it is
/// [`MAX_TEXT_BYTES`].
const MOST_TOGETHER: usize = 16 << 20;

/// What is read of each text where there are many long ones, in bytes.
const MAX_TEXT_BYTES: usize = 64 << 10;

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
        let sql = "SELECT id FROM (
                 SELECT id, created_ms FROM runs WHERE scenario_hash = ?1 AND task = ?3 AND deleted_ms IS NULL
                 UNION ALL
                 SELECT id, created_ms FROM runs WHERE scenario_hash IS NULL AND scenario = ?2 AND task = ?3
                     AND deleted_ms IS NULL)
             ORDER BY created_ms DESC, id DESC LIMIT ?4";
        // Numbers first: a sorter would carry all the texts.
        let values = params![scenario_hash, name, task.name(), most];
        let numbers = all_rows(&connection, sql, values, |row| row.get(0).map(RunId))?;
        let (mut runs, mut bytes) = (Vec::with_capacity(numbers.len()), 0);
        for id in numbers {
            let most = if bytes < MOST_TOGETHER {
                MOST_SHOWN
            } else {
                MAX_TEXT_BYTES
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
        all_rows(
            &connection,
            &sql,
            params_from_iter(values),
            Summary::from_row,
        )
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
        let values = params_from_iter(values);
        all_rows(&connection, &sql, values, |row| row.get(0).map(RunId))
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

/// A place in a list of runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Cursor {
    /// When the run there was asked, milliseconds since 1970.
    pub created_ms: i64,
    /// Its number.
    pub run: i64,
}

impl From<&Summary> for Cursor {
    fn from(run: &Summary) -> Self {
        Self {
            created_ms: run.created_ms,
            run: run.run,
        }
    }
}

/// Position of a page in a list.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Edge {
    /// From the newest run on.
    Newest,
    /// Up to the oldest run.
    Oldest,
    /// From this run on to older ones, itself included.
    From(Cursor),
    /// Those that are older than this one.
    Older(Cursor),
    /// Those that are newer than this one, up to it.
    Newer(Cursor),
}

/// A part of a list.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Page {
    /// The newest first. With words to search for in texts, that is the order in which the store got them.
    pub rows: Vec<Summary>,
    /// Whether there are more in the direction in which it was read.
    pub more: bool,
}

/// Stops what a store is reading at the moment, from another thread.
pub struct Interrupter(InterruptHandle);

impl Interrupter {
    /// Stops reading, if any is under way.
    pub fn interrupt(&self) {
        self.0.interrupt();
    }
}

impl std::fmt::Debug for Interrupter {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Interrupter")
    }
}

impl Store {
    /// A part of the list of the runs that fit, of at most `most`. The time it takes does not grow with the number of
    /// runs, unless a filter lets few of them through.
    ///
    /// # Errors
    /// SQLite refused, or was interrupted.
    pub fn page(&self, filter: &Filter, edge: Edge, most: usize) -> Result<Page, StoreError> {
        let connection = self.lock();
        let Condition {
            sql: condition,
            mut values,
            // The index of words gives its rows by number. By time it would have to look at every match first.
            by_words,
        } = filter.condition(|word| self.models_with(&connection, word))?;
        let (place, order) = if by_words {
            ("runs_text.rowid", ["runs_text.rowid"].as_slice())
        } else {
            (
                "(created_ms, runs.id)",
                ["created_ms", "runs.id"].as_slice(),
            )
        };
        let (cursor, sign, older) = match edge {
            Edge::Newest => (None, "", true),
            Edge::Oldest => (None, "", false),
            Edge::From(at) => (Some(at), "<=", true),
            Edge::Older(at) => (Some(at), "<", true),
            Edge::Newer(at) => (Some(at), ">", false),
        };
        let bound = match cursor {
            None => String::new(),
            Some(at) if by_words => {
                values.push(Value::from(at.run));
                format!(" AND {place} {sign} ?")
            }
            Some(at) => {
                values.extend([Value::from(at.created_ms), Value::from(at.run)]);
                format!(" AND {place} {sign} (?, ?)")
            }
        };
        let direction = if older { "DESC" } else { "ASC" };
        let order: Vec<_> = order.iter().map(|c| format!("{c} {direction}")).collect();
        let excerpt = if by_words { EXCERPT } else { "NULL" };
        let one_more = i64::try_from(most).unwrap_or(i64::MAX).saturating_add(1);
        values.push(Value::from(one_more));
        let sql = format!(
            "SELECT {}, {excerpt} AS excerpt FROM {condition}{bound} ORDER BY {} LIMIT ?",
            columns(),
            order.join(", ")
        );
        let values = params_from_iter(values);
        let mut rows = all_rows(&connection, &sql, values, Summary::from_row)?;
        let more = rows.len() > most;
        rows.truncate(most);
        if !older {
            rows.reverse();
        }
        Ok(Page { rows, more })
    }

    /// How many runs fit, counted no further than `most`.
    ///
    /// # Errors
    /// SQLite refused, or was interrupted.
    pub fn count_to(&self, filter: &Filter, most: u64) -> Result<u64, StoreError> {
        let connection = self.lock();
        let mut found = filter.condition(|word| self.models_with(&connection, word))?;
        let most = i64::try_from(most).unwrap_or(i64::MAX);
        found.values.push(Value::from(most));
        let sql = format!("SELECT count(*) FROM (SELECT 1 FROM {} LIMIT ?)", found.sql);
        let values = found.values;
        let mut statement = connection.prepare_cached(&sql)?;
        Ok(statement.query_row(params_from_iter(values), |row| row.get(0))?)
    }

    /// What the built-in judge said of the same scene, task and window, if it was asked about them: dangerous or not.
    /// A collision is one whatever the window.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn verdict_beside(&self, run: &Run, judge: &str) -> Result<Option<bool>, StoreError> {
        let question = &run.question;
        let (Some(hash), window) = (&question.scenario_hash, question.window) else {
            return Ok(None);
        };
        let connection = self.lock();
        let mut statement = connection.prepare_cached(
            "SELECT dangerous FROM runs WHERE scenario_hash = ?1 AND task = ?2 AND model = ?3 AND ego = ?4
                 AND dangerous IS NOT NULL AND deleted_ms IS NULL AND parameters = '{}'
                 AND (?2 = 'collision' OR (window_first = ?5 AND window_last = ?6))
             ORDER BY id DESC LIMIT 1",
        )?;
        let values = rusqlite::params![
            hash,
            question.task.name(),
            judge,
            question.ego,
            window.map(|(first, _)| first),
            window.map(|(_, last)| last),
        ];
        let mut found = statement.query_map(values, |row| row.get(0))?;
        Ok(found.next().transpose()?)
    }

    /// A number that changes when another program, or another [`Store`] of this one, writes to the file.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn version_of_data(&self) -> Result<i64, StoreError> {
        let connection = self.lock();
        let mut statement = connection.prepare_cached("PRAGMA data_version")?;
        Ok(statement.query_row([], |row| row.get(0))?)
    }

    /// What stops a long reading from another thread; it fails then, and [`StoreError::is_interrupted`] tells so.
    #[must_use]
    pub fn interrupter(&self) -> Interrupter {
        Interrupter(self.lock().get_interrupt_handle())
    }
}

impl StoreError {
    /// Whether a reading was stopped by an [`Interrupter`].
    #[must_use]
    pub fn is_interrupted(&self) -> bool {
        matches!(self, Self::Database(error)
            if error.sqlite_error_code() == Some(rusqlite::ErrorCode::OperationInterrupted))
    }
}
