//! Writes runs: their start, chunks, rounds of tool calls, end, and later edits by people.

use rusqlite::{Connection, OptionalExtension, params};

use super::claim::renew;
use super::database::now_ms;
use super::rows::{self, Columns};
use super::{AnswerPiece, Ending, NewRun, Origin, Run, RunId, RunState, Store, StoreError};

impl Store {
    /// Adds pieces of the answer, in one transaction, and renews the claim.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn append(&self, run: RunId, pieces: &[AnswerPiece<'_>]) -> Result<(), StoreError> {
        self.change(|transaction| {
            insert(transaction, run, pieces)?;
            renew(transaction, run)
        })
    }

    /// Writes down how a run ended and puts its pieces together; afterwards it is on the disk.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn finish(&self, run: RunId, ending: &Ending) -> Result<(), StoreError> {
        self.conclude(run, &[], ending)
    }

    /// [`Store::append`]s the last pieces and [`Store::finish`]es, in one transaction: no program can be killed between
    /// an answer's last piece and its end, so that a whole answer is never taken for an interrupted one.
    ///
    /// # Errors
    /// SQLite refused; neither pieces nor end are written then.
    pub fn conclude(
        &self,
        run: RunId,
        pieces: &[AnswerPiece<'_>],
        ending: &Ending,
    ) -> Result<(), StoreError> {
        self.durably(|transaction| conclude(transaction, run, pieces, ending))
    }

    /// Adds whole runs of another store or of a publication, in one transaction, unless they are there already; says
    /// how many were added. Their numbers are given anew.
    ///
    /// A run that was asked is there already if one with the same key, sample and time of asking is; a recorded one if
    /// one with the same key is, as its key holds its answer.
    ///
    /// # Errors
    /// SQLite refused. None is added then.
    pub fn add(&self, runs: &[Run]) -> Result<usize, StoreError> {
        self.durably(|transaction| {
            let mut added = 0;
            for run in runs {
                if there(transaction, run)?.is_some() {
                    continue;
                }
                insert_whole(transaction, run)?;
                added += 1;
            }
            Ok(added)
        })
    }

    /// Deletes a run, so that it is neither listed nor used as an answer; or restores it.
    ///
    /// # Errors
    /// There is no such run; it is pinned; SQLite refused.
    pub fn delete(&self, run: RunId, deleted: bool) -> Result<(), StoreError> {
        self.durably(|transaction| {
            let changed = transaction.execute(
                "UPDATE runs SET deleted_ms = ?2 WHERE id = ?1 AND pinned = 0",
                params![run.0, deleted.then(now_ms)],
            )?;
            if changed == 1 {
                return Ok(());
            }
            Err(if is_known(transaction, run)? {
                StoreError::Pinned(run)
            } else {
                StoreError::NoRun(run)
            })
        })
    }

    /// Keeps a run from being deleted, or no longer.
    ///
    /// # Errors
    /// There is no such run; SQLite refused.
    pub fn pin(&self, run: RunId, pinned: bool) -> Result<(), StoreError> {
        self.set(run, "UPDATE runs SET pinned = ?2 WHERE id = ?1", pinned)
    }

    /// Writes what a person has to say about a run.
    ///
    /// # Errors
    /// There is no such run; SQLite refused.
    pub fn note(&self, run: RunId, notes: &str) -> Result<(), StoreError> {
        self.set(run, "UPDATE runs SET notes = ?2 WHERE id = ?1", notes)
    }

    fn set(&self, run: RunId, sql: &str, value: impl rusqlite::ToSql) -> Result<(), StoreError> {
        self.durably(
            |transaction| match transaction.execute(sql, params![run.0, value])? {
                1 => Ok(()),
                _ => Err(StoreError::NoRun(run)),
            },
        )
    }
}

/// Writes the last pieces of a run and how it ended.
pub(super) fn conclude(
    transaction: &Connection,
    run: RunId,
    pieces: &[AnswerPiece<'_>],
    ending: &Ending,
) -> Result<(), StoreError> {
    let verdict = ending
        .verdict
        .as_ref()
        .map(serde_json::to_string)
        .transpose()?;
    insert(transaction, run, pieces)?;
    let (answer, reasoning) = rows::pieces(transaction, run)?;
    // Without its texts and its verdict: those are written together, as they are searched together.
    let columns = Columns::from_fields(ending)?.with("updated_ms", now_ms());
    columns.update(transaction, run)?;
    transaction.execute(
        "UPDATE runs SET answer = answer || ?2, reasoning = reasoning || ?3, verdict = ?4 WHERE id = ?1",
        params![run.0, answer, reasoning, verdict],
    )?;
    transaction.execute("DELETE FROM pieces WHERE run = ?1", [run.0])?;
    transaction.execute("DELETE FROM claims WHERE run = ?1", [run.0])?;
    Ok(())
}

fn insert(
    connection: &Connection,
    run: RunId,
    pieces: &[AnswerPiece<'_>],
) -> Result<(), StoreError> {
    let mut statement = connection
        .prepare_cached("INSERT INTO pieces (run, reasoning, text) VALUES (?1, ?2, ?3)")?;
    for piece in pieces {
        let (reasoning, text) = match piece {
            AnswerPiece::Reasoning(text) => (true, text),
            AnswerPiece::Answer(text) => (false, text),
        };
        statement.execute(params![run.0, reasoning, text])?;
    }
    Ok(())
}

fn is_known(connection: &Connection, run: RunId) -> Result<bool, StoreError> {
    let sql = "SELECT EXISTS (SELECT 1 FROM runs WHERE id = ?1)";
    Ok(connection.query_row(sql, [run.0], |row| row.get(0))?)
}

/// The run that is the same one, as [`Store::add`] says.
pub(super) fn there(connection: &Connection, run: &Run) -> Result<Option<RunId>, StoreError> {
    let key = run.key.as_ref().map(super::Key::as_str);
    let question = &run.question;
    let number = |row: &rusqlite::Row<'_>| row.get(0).map(RunId);
    if let (Origin::Recorded, Some(key)) = (run.origin, key) {
        let sql = "SELECT id FROM runs WHERE key = ?1 AND origin = 'recorded' LIMIT 1";
        let mut statement = connection.prepare_cached(sql)?;
        return Ok(statement.query_row([key], number).optional()?);
    }
    // Without a key, what it would have been made of.
    let sql = "SELECT id FROM runs WHERE created_ms = ?1 AND sample = ?2 AND key IS ?3
        AND (?3 IS NOT NULL OR (model = ?4 AND scenario_hash IS ?5 AND ego = ?6 AND task = ?7
            AND messages = ?8 AND answer = ?9)) LIMIT 1";
    let values = params![
        run.created_ms,
        question.sample,
        key,
        question.model,
        question.scenario_hash,
        question.ego,
        question.task.name(),
        question.messages,
        run.answer,
    ];
    let mut statement = connection.prepare_cached(sql)?;
    Ok(statement.query_row(values, number).optional()?)
}

/// Inserts a run of which only the question is known.
pub(super) fn insert_new(
    connection: &Connection,
    run: &NewRun,
    created_ms: i64,
) -> Result<RunId, StoreError> {
    for image in &run.images {
        super::images::keep(connection, image)?;
    }
    let columns = with_documents(Columns::from_fields(run)?, run)
        .with("created_ms", created_ms)
        .with("updated_ms", created_ms)
        .with("key", run.key().map(|key| key.as_str().to_string()))
        .with("state", RunState::Running.name().to_string());
    Ok(columns.insert(connection)?)
}

/// Inserts a whole run; its number is given anew.
pub(super) fn insert_whole(connection: &Connection, run: &Run) -> Result<RunId, StoreError> {
    let columns = with_documents(Columns::from_fields(run)?, &run.question)
        .without("run")
        .with("verdict", run.verdict_json.clone())
        .with("tool_rounds", run.tool_rounds.clone());
    Ok(columns.insert(connection)?)
}

/// The texts that are JSON in records, letter by letter.
fn with_documents(columns: Columns, run: &NewRun) -> Columns {
    columns
        .with("messages", run.messages.clone())
        .with("parameters", run.parameters.clone())
        .with("answer_schema", run.answer_schema.clone())
}

/// Moves the pieces of a run into it.
pub(super) fn join_pieces(connection: &Connection, run: RunId) -> Result<(), StoreError> {
    let (answer, reasoning) = rows::pieces(connection, run)?;
    connection.execute(
        "UPDATE runs SET answer = answer || ?2, reasoning = reasoning || ?3 WHERE id = ?1",
        params![run.0, answer, reasoning],
    )?;
    connection.execute("DELETE FROM pieces WHERE run = ?1", [run.0])?;
    Ok(())
}

impl Store {
    /// Keeps the rounds of a run so far, a JSON array; afterwards they are on the disk. Renews the claim.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn keep_rounds(&self, run: RunId, json: &str) -> Result<(), StoreError> {
        self.durably(|transaction| {
            transaction
                .prepare_cached("UPDATE runs SET tool_rounds = ?2 WHERE id = ?1")?
                .execute(params![run.0, json])?;
            renew(transaction, run)
        })
    }

    /// The rounds of the newest earlier run of the same question and sample that broke off: they are paid, and `run`
    /// goes on after them. Nothing if that run answered, or was deleted.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn unfinished_rounds(
        &self,
        question: &NewRun,
        run: RunId,
    ) -> Result<Option<(RunId, String)>, StoreError> {
        let Some(key) = question.key() else {
            return Ok(None);
        };
        let connection = self.lock();
        let sql = "SELECT id, state, tool_rounds FROM runs WHERE key = ?1 AND sample = ?2 AND id < ?3
            AND deleted_ms IS NULL AND (tool_rounds IS NOT NULL OR state IN ('answered', 'truncated'))
            ORDER BY id DESC LIMIT 1";
        let found = connection
            .prepare_cached(sql)?
            .query_row(params![key.as_str(), question.sample, run.0], |row| {
                let (id, state): (i64, String) = (row.get(0)?, row.get(1)?);
                let rounds: Option<String> = row.get(2)?;
                Ok((RunId(id), state, rounds))
            })
            .optional()?;
        let broken = |state: &str| ["interrupted", "failed", "cancelled"].contains(&state);
        Ok(found.and_then(|(id, state, rounds)| Some((id, rounds.filter(|_| broken(&state))?))))
    }
}

impl Store {
    /// Keeps what a run can cost at most, US dollars; nothing where that is not known.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn bound(&self, run: RunId, usd: Option<f64>) -> Result<(), StoreError> {
        self.change(|transaction| {
            let sql = "UPDATE runs SET most_usd = ?2 WHERE id = ?1";
            transaction
                .prepare_cached(sql)?
                .execute(params![run.0, usd])?;
            Ok(())
        })
    }

    /// What a run can have cost at most, US dollars, where that was known when it was asked.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn bound_of(&self, run: RunId) -> Result<Option<f64>, StoreError> {
        let connection = self.lock();
        let found = connection
            .prepare_cached("SELECT most_usd FROM runs WHERE id = ?1")?
            .query_row([run.0], |row| row.get(0))
            .optional()?;
        Ok(found.flatten())
    }
}
