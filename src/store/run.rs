//! Runs: their stored data, and how they are written: start, chunks, rounds of tool calls, end, later edits by people.

use nearmiss_scene::verdict::{ParsedAnswer, Task};
use rusqlite::{Connection, OptionalExtension, params};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use strum::{IntoStaticStr, VariantArray};

use super::claim::{self, renew};
use super::database::now_ms;
use super::rows::{self, Columns};
use super::{ClaimCounts, Key, Store, StoreError, StoredImage, document};

/// Identifies a run in its store.
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Eq,
    Hash,
    PartialOrd,
    Ord,
    Default,
    Serialize,
    Deserialize,
    JsonSchema,
)]
pub struct RunId(pub i64);

impl std::fmt::Display for RunId {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}", self.0)
    }
}

/// Data known before a judge is asked.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct NewRun {
    /// Number of the sample among answers to the same request, from 0.
    pub sample: u32,
    /// Name of the batch that it belongs to, such as b7.
    pub batch: Option<String>,
    /// Name of the scenario: its file name without the ending.
    pub scenario: String,
    /// SHA-256 of its file, hexadecimal; null if an answer is known and the file is not.
    pub scenario_hash: Option<String>,
    /// The ego, and where its motion comes from.
    pub ego: String,
    /// The question: collision, safety, recording, attacker or trajectory.
    #[schemars(with = "String")]
    pub task: Task,
    /// Frame of the description.
    pub frame: String,
    /// Prompting techniques: cp, cot and icl joined by +, or base.
    pub techniques: String,
    /// First and last time step of the window; null if an answer is known and its window is not.
    pub window: Option<(i64, i64)>,
    /// Model asked, as provider/model.
    pub model: String,
    /// The provider of the model.
    pub provider: String,
    /// Wire protocol; null if no request is sent.
    pub dialect: Option<String>,
    /// Provider and address of the server, for people, without any key.
    pub endpoint: String,
    /// The address alone, without user, password and query; null if no request is sent.
    pub address: Option<String>,
    /// File name of the prompt template.
    pub template: String,
    /// Version that the template states; null for a draft.
    pub template_version: Option<String>,
    /// SHA-256 of the text of the template.
    pub template_hash: String,
    /// The messages: role and content of each, and its images by hash, if it has some.
    #[serde(with = "document")]
    #[schemars(with = "Value")]
    pub messages: String,
    /// Sampling parameters.
    #[serde(with = "document")]
    #[schemars(with = "Value")]
    pub parameters: String,
    /// JSON schema that the answer was asked in; null where there is none.
    #[serde(default, with = "document")]
    #[schemars(with = "Value")]
    pub answer_schema: Option<String>,
    /// The images that its messages name, to be kept with it; empty where a run is read.
    #[serde(skip)]
    pub images: Vec<StoredImage>,
}

/// The template that a run was asked with.
#[derive(
    Debug, Clone, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
pub struct StoredTemplate {
    /// Its file name; empty where it is not known.
    pub template: String,
    /// Its version, as it says itself; `None` for a draft.
    pub template_version: Option<String>,
    /// SHA-256 of its text.
    pub template_hash: String,
}

impl NewRun {
    /// The template it is asked with.
    #[must_use]
    pub fn template(&self) -> StoredTemplate {
        StoredTemplate {
            template: self.template.clone(),
            template_version: self.template_version.clone(),
            template_hash: self.template_hash.clone(),
        }
    }

    /// The key of the request; `None` if none is sent, or where not all of it is known.
    ///
    /// Two runs with the same key and sample are the same question: everything that the server is sent is the same.
    #[must_use]
    pub fn key(&self) -> Option<Key> {
        let json = |text: &str| serde_json::from_str::<Value>(text).ok();
        let schema = match &self.answer_schema {
            Some(text) => json(text)?,
            None => Value::Null,
        };
        let name = self
            .model
            .split_once('/')
            .map_or(self.model.as_str(), |(_, name)| name);
        Some(Key::digest(&json!({
            "address": self.address.as_ref()?,
            "dialect": self.dialect.as_ref()?,
            "model": name,
            "messages": json(&self.messages)?,
            "parameters": json(&self.parameters)?,
            "schema": schema,
        })))
    }
}

/// Origin of a run's answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "lowercase")]
pub enum Origin {
    /// This store's program asked a judge.
    #[default]
    Asked,
    /// The answer was published.
    Recorded,
    /// Another store's program asked a judge.
    Replayed,
}

nearmiss_record::named!(Origin, "origin");

/// A piece of an answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AnswerPiece<'a> {
    /// Of the reasoning.
    Reasoning(&'a str),
    /// Of the answer itself.
    Answer(&'a str),
}

/// State of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "lowercase")]
pub enum RunState {
    /// The answer is arriving.
    Running,
    /// The program ended while the answer was arriving.
    Interrupted,
    /// The answer is whole; it may still hold no verdict.
    Answered,
    /// The server cut the answer off: it ran into the token limit or a filter.
    Truncated,
    /// There is no whole answer.
    Failed,
    /// It was cancelled.
    Cancelled,
}

nearmiss_record::named!(RunState, "state");

/// Consumption of an answer, where known.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
pub struct Consumed {
    /// Tokens of the prompt, as the server counts.
    pub input_tokens: Option<u64>,
    /// Tokens of the answer, reasoning included, as the server counts.
    pub output_tokens: Option<u64>,
    /// Tokens of the reasoning, as the server counts.
    pub reasoning_tokens: Option<u64>,
    /// Prompt tokens that the server had cached.
    pub cached_tokens: Option<u64>,
    /// Cost in US dollars; null if unknown.
    pub cost_usd: Option<f64>,
    /// Time to the first token, milliseconds.
    pub first_chunk_ms: Option<u64>,
    /// Time to the end of the answer, milliseconds.
    pub duration_ms: Option<u64>,
}

/// Data known when a run ends.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Ending {
    /// State of the run.
    pub state: RunState,
    /// Model that the server says has answered.
    pub model_returned: Option<String>,
    /// Why the server ended the answer.
    pub finish: Option<String>,
    /// What it says.
    #[serde(skip)]
    pub verdict: Option<ParsedAnswer>,
    /// How the verdict was read from the answer: strict or repaired, or why it could not be read.
    pub reading: Option<String>,
    /// Why asking failed.
    pub error: Option<String>,
    /// What it consumed.
    #[serde(flatten)]
    pub consumed: Consumed,
    /// Source of the price.
    pub price_source: Option<String>,
    /// Its claims about obstacles, where they were checked.
    #[serde(flatten)]
    pub claims: ClaimCounts,
}

impl Ending {
    /// An ending of which nothing more is known.
    #[must_use]
    pub fn bare(state: RunState) -> Self {
        Self {
            state,
            model_returned: None,
            finish: None,
            verdict: None,
            reading: None,
            error: None,
            consumed: Consumed::default(),
            price_source: None,
            claims: ClaimCounts::default(),
        }
    }
}

/// A run as it is kept. In JSON and in the database its fields, and those of its parts, are the columns of `runs`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Run {
    /// Number of the run in the store.
    #[serde(default, rename = "run", alias = "id")]
    pub id: RunId,
    /// When it began, milliseconds since 1970, UTC; of a recorded one, when it was read.
    pub created_ms: i64,
    /// Time of the last change, milliseconds since 1970, UTC.
    pub updated_ms: i64,
    /// Key of the request: SHA-256 of everything that is sent; null if nothing was sent.
    #[serde(default, deserialize_with = "claim::deserialize_key")]
    pub key: Option<Key>,
    /// Where the answer comes from: asked, recorded or replayed.
    pub origin: Origin,
    /// File that a recorded answer was read from.
    pub source: Option<String>,
    /// The question and its judge.
    #[serde(flatten)]
    pub question: NewRun,
    /// Text of the answer.
    pub answer: String,
    /// Reasoning of the model.
    pub reasoning: String,
    /// How it ended, or where it stands.
    #[serde(flatten)]
    pub ending: Ending,
    /// The structured verdict; null if there is none.
    // As it is kept, for programs that know more than [`Ending::verdict`] can say.
    #[serde(default, rename = "verdict", with = "document")]
    #[schemars(with = "Value")]
    pub verdict_json: Option<String>,
    /// Tools that the model called, by round: calls with id, name and arguments, and results in the same order;
    /// missing where none was called.
    #[serde(default, skip_serializing_if = "Option::is_none", with = "document")]
    #[schemars(with = "Value")]
    pub tool_rounds: Option<String>,
    /// Maximum cost in US dollars; null if unknown when it was asked.
    #[serde(default)]
    pub most_usd: Option<f64>,
    /// Notes of a person.
    pub notes: String,
    /// Whether the run is protected from deletion.
    pub pinned: bool,
    /// Time of deletion, milliseconds since 1970, UTC; it can be restored.
    pub deleted_ms: Option<i64>,
}

impl Run {
    /// The same with its verdict read from [`Run::verdict_json`].
    pub(super) fn with_verdict(mut self) -> Self {
        let json = self.verdict_json.as_deref();
        self.ending.verdict = json.and_then(|json| serde_json::from_str(json).ok());
        self
    }
}

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
