//! Writes runs: their start, chunks, end, and later edits by people.

use rusqlite::{Connection, OptionalExtension, params};

use super::claim::renew;
use super::database::now_ms;
use super::{AnswerPiece, Ending, NewRun, Origin, Run, RunId, Store, StoreError, rows};

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
                let id = insert_new(transaction, &run.question, run.created_ms)?;
                insert_rest(transaction, id, run)?;
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
            Err(match is_known(transaction, run)? {
                true => StoreError::Pinned(run),
                false => StoreError::NoRun(run),
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
    end(transaction, run, ending, now_ms())?;
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
    let key = run.key();
    connection
        .prepare_cached(
            "INSERT INTO runs (created_ms, updated_ms, key, sample, batch, scenario, scenario_hash, ego, task, frame,
                 techniques, window_first, window_last, model, provider, dialect, endpoint, address, template,
                 template_version, template_hash, messages, parameters, answer_schema, state)
             VALUES (?1, ?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11, ?12, ?13, ?14, ?15, ?16, ?17, ?18, ?19, ?20,
                 ?21, ?22, ?23, 'running')",
        )?
        .execute(params![
            created_ms,
            key.as_ref().map(super::Key::as_str),
            run.sample,
            run.batch,
            run.scenario,
            run.scenario_hash,
            run.ego,
            run.task.name(),
            run.frame,
            run.techniques,
            run.window.map(|(first, _)| first),
            run.window.map(|(_, last)| last),
            run.model,
            run.provider,
            run.dialect,
            run.endpoint,
            run.address,
            run.template,
            run.template_version,
            run.template_hash,
            run.messages,
            run.parameters,
            run.answer_schema,
        ])?;
    Ok(RunId(connection.last_insert_rowid()))
}

/// How a run ended, without its texts and its verdict: those are written together, as they are searched together.
fn end(
    connection: &Connection,
    run: RunId,
    ending: &Ending,
    updated_ms: i64,
) -> Result<(), StoreError> {
    let consumed = &ending.consumed;
    connection
        .prepare_cached(
            "UPDATE runs SET updated_ms = ?2, state = ?3, model_returned = ?4, finish = ?5, reading = ?6, error = ?7,
                 input_tokens = ?8, output_tokens = ?9, reasoning_tokens = ?10, cached_tokens = ?11, cost_usd = ?12,
                 price_source = ?13, first_chunk_ms = ?14, duration_ms = ?15
             WHERE id = ?1",
        )?
        .execute(params![
            run.0,
            updated_ms,
            ending.state.name(),
            ending.model_returned,
            ending.finish,
            ending.reading,
            ending.error,
            storable(consumed.input_tokens),
            storable(consumed.output_tokens),
            storable(consumed.reasoning_tokens),
            storable(consumed.cached_tokens),
            consumed.cost_usd.filter(|usd| usd.is_finite()),
            ending.price_source,
            storable(consumed.first_chunk_ms),
            storable(consumed.duration_ms),
        ])?;
    Ok(())
}

/// A count as SQLite has them. No number is worth losing an answer: what does not fit is not known.
fn storable(count: Option<u64>) -> Option<i64> {
    count.and_then(|count| i64::try_from(count).ok())
}

/// Everything of a run beside its question.
pub(super) fn insert_rest(connection: &Connection, id: RunId, run: &Run) -> Result<(), StoreError> {
    end(connection, id, &run.ending, run.updated_ms)?;
    connection
        .prepare_cached(
            "UPDATE runs SET key = ?2, origin = ?3, source = ?4, answer = ?5, reasoning = ?6, verdict = ?7, notes = ?8,
                 pinned = ?9, deleted_ms = ?10
             WHERE id = ?1",
        )?
        .execute(params![
            id.0,
            run.key.as_ref().map(super::Key::as_str),
            run.origin.name(),
            run.source,
            run.answer,
            run.reasoning,
            run.verdict_json,
            run.notes,
            run.pinned,
            run.deleted_ms,
        ])?;
    Ok(())
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
