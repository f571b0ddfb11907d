//! Paginated run lists: opened at once at any length, with only the visible pages in memory.

use rusqlite::types::Value;
use rusqlite::{InterruptHandle, params_from_iter};

use super::filter::Condition;
use super::list::{EXCERPT, columns};
use super::{Filter, Run, Store, StoreError, Summary};

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
        let mut statement = connection.prepare_cached(&sql)?;
        let found = statement.query_map(params_from_iter(values), Summary::from_row)?;
        let mut rows = found.collect::<Result<Vec<_>, _>>()?;
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
