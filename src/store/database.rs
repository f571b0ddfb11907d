//! The SQLite database behind the store.

use std::path::Path;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use rusqlite::{Connection, OptionalExtension, Row, params};

use super::{Consumed, Ending, NewRun, Piece, Run, RunId, RunState};
use crate::system;
use crate::verdict::Task;

/// All runs. Several threads and several programs may use one store at once.
#[derive(Debug)]
pub struct Store {
    connection: Mutex<Connection>,
}

/// Why something is not in the store.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// The folder cannot be made.
    #[error(
        "{folder}: {}; set NEARMISS_DATA to a folder that can be written",
        system::words(source)
    )]
    Folder {
        /// Which folder.
        folder: String,
        /// What the system said.
        source: std::io::Error,
    },
    /// The file is not a store, or cannot be used as one.
    #[error("{file}: {source}; move it away, or set NEARMISS_DATA to another folder")]
    File {
        /// Which file.
        file: String,
        /// What SQLite said.
        source: rusqlite::Error,
    },
    /// SQLite refused.
    #[error("the store of runs: {0}")]
    Database(#[from] rusqlite::Error),
    /// The file was written by a newer program.
    #[error(
        "the store of runs has version {found}, this program knows {known}; use a newer nearmiss, or set NEARMISS_DATA to another folder"
    )]
    Newer {
        /// Version of the file.
        found: i64,
        /// Newest version known.
        known: i64,
    },
    /// A verdict cannot be written as JSON.
    #[error("a verdict cannot be stored: {0}")]
    Json(#[from] serde_json::Error),
}

const VERSION: i64 = 1;

impl Store {
    /// Opens the store in a file, making it and its folder where they are missing.
    ///
    /// # Errors
    /// The file cannot be used, or is newer than the program.
    pub fn open(path: &Path) -> Result<Self, StoreError> {
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder).map_err(|source| StoreError::Folder {
                folder: folder.display().to_string(),
                source,
            })?;
        }
        Connection::open(path)
            .map_err(StoreError::from)
            .and_then(Self::prepare)
            .map_err(|error| match error {
                StoreError::Database(source) => StoreError::File {
                    file: path.display().to_string(),
                    source,
                },
                other => other,
            })
    }

    /// A store that lasts as long as the program.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn in_memory() -> Result<Self, StoreError> {
        Self::prepare(Connection::open_in_memory()?)
    }

    fn prepare(mut connection: Connection) -> Result<Self, StoreError> {
        connection.busy_timeout(Duration::from_secs(10))?;
        connection.pragma_update(None, "journal_mode", "wal")?;
        // Pieces outlive a killed program as they are; whole answers outlive a power cut (see `finish`).
        connection.pragma_update(None, "synchronous", "normal")?;
        connection.pragma_update(None, "foreign_keys", true)?;
        let transaction =
            connection.transaction_with_behavior(rusqlite::TransactionBehavior::Immediate)?;
        let found: i64 = transaction.query_row("PRAGMA user_version", [], |row| row.get(0))?;
        if found > VERSION {
            return Err(StoreError::Newer {
                found,
                known: VERSION,
            });
        }
        if found < 1 {
            transaction.execute_batch(include_str!("schema.sql"))?;
        }
        transaction.pragma_update(None, "user_version", VERSION)?;
        transaction.commit()?;
        Ok(Self {
            connection: Mutex::new(connection),
        })
    }

    fn lock(&self) -> MutexGuard<'_, Connection> {
        // A panic elsewhere leaves SQLite itself sound: its transactions roll back.
        self.connection
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }

    /// Writes down that a judge is about to be asked.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn begin(&self, run: &NewRun) -> Result<RunId, StoreError> {
        let connection = self.lock();
        connection.execute(
            "INSERT INTO runs (created_ms, updated_ms, scenario, scenario_hash, ego, task, frame, techniques,
                 window_first, window_last, model, endpoint, template, template_hash, messages, parameters, state)
             VALUES (?1, ?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11, ?12, ?13, ?14, ?15, 'running')",
            params![
                now_ms(),
                run.scenario,
                run.scenario_hash,
                run.ego,
                run.task.name(),
                run.frame,
                run.techniques,
                run.window.0,
                run.window.1,
                run.model,
                run.endpoint,
                run.template,
                run.template_hash,
                run.messages,
                run.parameters,
            ],
        )?;
        Ok(RunId(connection.last_insert_rowid()))
    }

    /// Adds a piece of the answer.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn append(&self, run: RunId, piece: Piece<'_>) -> Result<(), StoreError> {
        let (reasoning, text) = match piece {
            Piece::Reasoning(text) => (true, text),
            Piece::Answer(text) => (false, text),
        };
        self.lock().execute(
            "INSERT INTO pieces (run, reasoning, text) VALUES (?1, ?2, ?3)",
            params![run.0, reasoning, text],
        )?;
        Ok(())
    }

    /// Writes down how a run ended and puts its pieces together.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn finish(&self, run: RunId, ending: &Ending) -> Result<(), StoreError> {
        let verdict = ending
            .verdict
            .as_ref()
            .map(serde_json::to_string)
            .transpose()?;
        let mut connection = self.lock();
        connection.pragma_update(None, "synchronous", "full")?;
        let transaction = connection.transaction()?;
        let (answer, reasoning) = pieces(&transaction, run)?;
        let consumed = &ending.consumed;
        transaction.execute(
            "UPDATE runs SET updated_ms = ?2, state = ?3, model_returned = ?4, finish = ?5, verdict = ?6,
                 reading = ?7, error = ?8, input_tokens = ?9, output_tokens = ?10, reasoning_tokens = ?11,
                 cached_tokens = ?12, cost_usd = ?13, first_chunk_ms = ?14, duration_ms = ?15,
                 answer = answer || ?16, reasoning = reasoning || ?17
             WHERE id = ?1",
            params![
                run.0,
                now_ms(),
                ending.state.name(),
                ending.model_returned,
                ending.finish,
                verdict,
                ending.reading,
                ending.error,
                consumed.input_tokens,
                consumed.output_tokens,
                consumed.reasoning_tokens,
                consumed.cached_tokens,
                consumed.cost_usd,
                consumed.first_chunk_ms,
                consumed.duration_ms,
                answer,
                reasoning,
            ],
        )?;
        transaction.execute("DELETE FROM pieces WHERE run = ?1", [run.0])?;
        transaction.commit()?;
        connection.pragma_update(None, "synchronous", "normal")?;
        Ok(())
    }

    /// One run.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn run(&self, id: RunId) -> Result<Option<Run>, StoreError> {
        let connection = self.lock();
        let found = connection
            .query_row("SELECT * FROM runs WHERE id = ?1", [id.0], read)
            .optional()?;
        found.map(|run| with_pieces(&connection, run)).transpose()
    }

    /// The newest runs on a scenario (by the hash of its file) and a task, newest first.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn of_scenario(
        &self,
        scenario_hash: &str,
        task: Task,
        most: usize,
    ) -> Result<Vec<Run>, StoreError> {
        let connection = self.lock();
        let mut statement = connection.prepare_cached(
            "SELECT * FROM runs WHERE scenario_hash = ?1 AND task = ?2 ORDER BY id DESC LIMIT ?3",
        )?;
        let rows = statement.query_map(params![scenario_hash, task.name(), most], read)?;
        rows.map(|run| with_pieces(&connection, run?)).collect()
    }
}

/// The texts of the pieces that have not been put together: answer and reasoning.
fn pieces(connection: &Connection, run: RunId) -> Result<(String, String), rusqlite::Error> {
    let mut statement = connection
        .prepare_cached("SELECT reasoning, text FROM pieces WHERE run = ?1 ORDER BY id")?;
    let mut rows = statement.query([run.0])?;
    let (mut answer, mut reasoning) = (String::new(), String::new());
    while let Some(row) = rows.next()? {
        let text: String = row.get(1)?;
        if row.get(0)? {
            &mut reasoning
        } else {
            &mut answer
        }
        .push_str(&text);
    }
    Ok((answer, reasoning))
}

fn with_pieces(connection: &Connection, mut run: Run) -> Result<Run, StoreError> {
    let (answer, reasoning) = pieces(connection, run.id)?;
    run.answer.push_str(&answer);
    run.reasoning.push_str(&reasoning);
    Ok(run)
}

fn read(row: &Row<'_>) -> Result<Run, rusqlite::Error> {
    let text = |name: &str| row.get::<_, String>(name);
    let verdict: Option<String> = row.get("verdict")?;
    Ok(Run {
        id: RunId(row.get("id")?),
        created_ms: row.get("created_ms")?,
        question: NewRun {
            scenario: text("scenario")?,
            scenario_hash: text("scenario_hash")?,
            ego: text("ego")?,
            task: Task::parse(&text("task")?).unwrap_or(Task::Collision),
            frame: text("frame")?,
            techniques: text("techniques")?,
            window: (row.get("window_first")?, row.get("window_last")?),
            model: text("model")?,
            endpoint: text("endpoint")?,
            template: text("template")?,
            template_hash: text("template_hash")?,
            messages: text("messages")?,
            parameters: text("parameters")?,
        },
        answer: text("answer")?,
        reasoning: text("reasoning")?,
        ending: Ending {
            state: RunState::parse(&text("state")?).unwrap_or(RunState::Failed),
            model_returned: row.get("model_returned")?,
            finish: row.get("finish")?,
            verdict: verdict.and_then(|json| serde_json::from_str(&json).ok()),
            reading: row.get("reading")?,
            error: row.get("error")?,
            consumed: Consumed {
                input_tokens: row.get("input_tokens")?,
                output_tokens: row.get("output_tokens")?,
                reasoning_tokens: row.get("reasoning_tokens")?,
                cached_tokens: row.get("cached_tokens")?,
                cost_usd: row.get("cost_usd")?,
                first_chunk_ms: row.get("first_chunk_ms")?,
                duration_ms: row.get("duration_ms")?,
            },
        },
    })
}

fn now_ms() -> i64 {
    let since = SystemTime::now()
        .duration_since(UNIX_EPOCH)
        .unwrap_or_default();
    i64::try_from(since.as_millis()).unwrap_or(i64::MAX)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::verdict::{Said, Verdict};

    fn question() -> NewRun {
        let text = |s: &str| s.to_string();
        NewRun {
            scenario: text("ZAM_A-1"),
            scenario_hash: text("h"),
            ego: text("1"),
            task: Task::Collision,
            frame: text("ego"),
            techniques: text("base"),
            window: (3, 12),
            model: text("local/x"),
            endpoint: text("http://127.0.0.1"),
            template: text("t.md"),
            template_hash: text("th"),
            messages: text("[]"),
            parameters: text("{}"),
        }
    }

    #[test]
    fn pieces_are_there_at_once_and_put_together_at_the_end() {
        let store = Store::in_memory().unwrap();
        let id = store.begin(&question()).unwrap();
        store.append(id, Piece::Reasoning("think ")).unwrap();
        store.append(id, Piece::Answer("a")).unwrap();
        store.append(id, Piece::Answer("b")).unwrap();
        let running = store.run(id).unwrap().unwrap();
        assert_eq!(
            (running.answer.as_str(), running.ending.state),
            ("ab", RunState::Running)
        );
        let ending = Ending {
            verdict: Some(Said::Verdict(Verdict {
                task: Task::Collision,
                dangerous: true,
                obstacles: vec![],
                justification: "j".into(),
            })),
            ..Ending::bare(RunState::Answered)
        };
        store.finish(id, &ending).unwrap();
        let done = store.run(id).unwrap().unwrap();
        assert_eq!(
            (done.answer.as_str(), done.reasoning.as_str()),
            ("ab", "think ")
        );
        assert_eq!(done.ending, ending);
        assert_eq!(done.question, question());
        assert_eq!(store.of_scenario("h", Task::Collision, 5).unwrap().len(), 1);
        assert!(store.of_scenario("h", Task::Safety, 5).unwrap().is_empty());
    }

    #[test]
    fn two_programs_share_a_file_and_a_newer_one_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("deep/runs.sqlite");
        let (a, b) = (Store::open(&path).unwrap(), Store::open(&path).unwrap());
        let id = a.begin(&question()).unwrap();
        assert!(b.run(id).unwrap().is_some());
        a.lock().pragma_update(None, "user_version", 99).unwrap();
        assert!(matches!(
            Store::open(&path),
            Err(StoreError::Newer { found: 99, .. })
        ));
    }
}
