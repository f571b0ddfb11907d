//! Batches: their questions, stored before anything is sent, so that a batch can be resumed, and every run made for them.

use std::collections::{BTreeMap, BTreeSet};

use rusqlite::{OptionalExtension, params};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::database::now_ms;
use super::items::{STATE, insert};
use super::rows::{self, from_row};
use super::{
    ClaimCounts, Consumed, NewItem, RunId, RunState, Store, StoreError, UnlockRecord, document,
};

/// Identifies a batch; people call it `b7`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, JsonSchema)]
pub struct BatchId(#[schemars(with = "String")] pub i64);

impl Serialize for BatchId {
    fn serialize<S: serde::Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for BatchId {
    fn deserialize<D: serde::Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        #[derive(Deserialize)]
        #[serde(untagged, expecting = "a batch name is b and a number, such as b7")]
        enum Written {
            Number(i64),
            Name(String),
        }
        match Written::deserialize(from)? {
            Written::Number(number) => Ok(Self(number)),
            Written::Name(name) => name.parse().map_err(serde::de::Error::custom),
        }
    }
}

impl std::fmt::Display for BatchId {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "b{}", self.0)
    }
}

impl std::str::FromStr for BatchId {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let digits = text.strip_prefix(['b', 'B']).unwrap_or(text);
        match digits.parse() {
            Ok(id) if id > 0 => Ok(Self(id)),
            _ => Err("a batch name is b and a number, such as b7".into()),
        }
    }
}

/// A batch, without its questions.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Batch {
    /// Name of the batch, such as b7.
    #[serde(rename = "batch", alias = "id")]
    pub id: BatchId,
    /// When it was begun, milliseconds since 1970, UTC.
    pub created_ms: i64,
    /// Time of the last change, milliseconds since 1970, UTC.
    pub updated_ms: i64,
    /// What the batch asks: tasks, frames and other settings.
    #[serde(
        serialize_with = "document::exact",
        deserialize_with = "document::deserialize"
    )]
    #[schemars(with = "serde_json::Value")]
    pub spec: String,
    /// Parts that are here, such as 1/4; null if the batch is whole.
    pub shard: Option<String>,
    /// Looks at the test split before it was complete.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub looks: Vec<UnlockRecord>,
}

/// Progress of a batch: its scenarios, and its questions by state.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
pub struct Progress {
    /// Scenarios that are asked about.
    pub scenarios: u64,
    /// Not answered yet.
    pub waiting: u64,
    /// A whole answer is there.
    pub answered: u64,
    /// The server cut the answer off.
    pub truncated: u64,
    /// No whole answer came.
    pub failed: u64,
    /// No question can be made of the scenario.
    pub unaskable: u64,
}

impl Progress {
    /// All questions.
    #[must_use]
    pub fn all(&self) -> u64 {
        self.waiting + self.answered + self.truncated + self.failed + self.unaskable
    }
}

const COLUMNS: &str = "id, created_ms, updated_ms, spec, shard";

impl Store {
    /// Writes down a batch and its questions, in their order; afterwards they are on the disk.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn begin_batch(
        &self,
        spec: &str,
        shard: Option<&str>,
        items: &[NewItem],
    ) -> Result<BatchId, StoreError> {
        self.durably(|transaction| {
            let now = now_ms();
            transaction.execute(
                "INSERT INTO batches (created_ms, updated_ms, spec, shard) VALUES (?1, ?1, ?2, ?3)",
                params![now, spec, shard],
            )?;
            let id = BatchId(transaction.last_insert_rowid());
            insert(transaction, id, items)?;
            Ok(id)
        })
    }

    /// Appends questions to a batch and replaces its specification.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn extend_batch(
        &self,
        id: BatchId,
        spec: &str,
        items: &[NewItem],
    ) -> Result<(), StoreError> {
        self.durably(|transaction| {
            transaction.execute(
                "UPDATE batches SET spec = ?2, updated_ms = ?3 WHERE id = ?1",
                params![id.0, spec, now_ms()],
            )?;
            insert(transaction, id, items)
        })
    }

    /// A batch; `None` if there is none with this number.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn batch(&self, id: BatchId) -> Result<Option<Batch>, StoreError> {
        let connection = self.lock();
        let sql = format!("SELECT {COLUMNS} FROM batches WHERE id = ?1");
        let found: Option<Batch> = connection.query_row(&sql, [id.0], from_row).optional()?;
        drop(connection);
        found.map(|batch| self.with_looks(batch)).transpose()
    }

    fn with_looks(&self, batch: Batch) -> Result<Batch, StoreError> {
        let looks = self.looks(batch.id)?;
        Ok(Batch { looks, ..batch })
    }

    /// The batch that was begun last.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn last_batch(&self) -> Result<Option<Batch>, StoreError> {
        let connection = self.lock();
        let sql = format!("SELECT {COLUMNS} FROM batches ORDER BY id DESC LIMIT 1");
        let found: Option<Batch> = connection.query_row(&sql, [], from_row).optional()?;
        drop(connection);
        found.map(|batch| self.with_looks(batch)).transpose()
    }

    /// Every batch and how far it is, the newest first.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn batches(&self) -> Result<Vec<(Batch, Progress)>, StoreError> {
        let sql = format!(
            "SELECT {COLUMNS}, count(DISTINCT asked.path) AS scenarios,
                 coalesce(sum(now = 'waiting'), 0) AS waiting, coalesce(sum(now = 'answered'), 0) AS answered,
                 coalesce(sum(now = 'truncated'), 0) AS truncated, coalesce(sum(now = 'failed'), 0) AS failed,
                 coalesce(sum(now = 'unaskable'), 0) AS unaskable
             FROM batches LEFT JOIN (SELECT items.batch, items.path, {STATE} AS now FROM items) AS asked
                 ON asked.batch = batches.id GROUP BY batches.id ORDER BY id DESC"
        );
        let found = self.rows(&sql, [], |row| Ok((from_row(row)?, from_row(row)?)))?;
        let found = found.into_iter();
        found
            .map(|(batch, progress)| Ok((self.with_looks(batch)?, progress)))
            .collect()
    }
}

/// A run that was made for a question, without its texts.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct QuestionRun {
    /// The run.
    pub run: RunId,
    /// Where it stands.
    pub state: RunState,
    /// First and last time step of its window, where known.
    pub window: Option<(i64, i64)>,
    /// The most that it can have cost, US dollars, where that was known when it was asked.
    pub most_usd: Option<f64>,
    /// Time, tokens and cost.
    #[serde(flatten)]
    pub consumed: Consumed,
    /// Claims about obstacles, where they were checked.
    #[serde(flatten)]
    pub claims: ClaimCounts,
}

/// Whether another run counts in the place of one of `runs`: of the same request and sample a whole answer counts
/// before one that was cut or failed, these before what was cancelled or interrupted, and of equals the one that
/// entered the store last. What is arriving is never superseded, and supersedes nothing.
pub const SUPERSEDED: &str = "(runs.state <> 'running' AND runs.deleted_ms IS NULL AND EXISTS (
         SELECT 1 FROM runs AS other WHERE other.key = runs.key AND other.sample = runs.sample
             AND other.id <> runs.id AND other.deleted_ms IS NULL AND CASE other.state
                 WHEN 'answered' THEN runs.state <> 'answered' OR other.id > runs.id
                 WHEN 'truncated' THEN runs.state IN ('cancelled', 'interrupted')
                     OR (runs.state IN ('truncated', 'failed') AND other.id > runs.id)
                 WHEN 'failed' THEN runs.state IN ('cancelled', 'interrupted')
                     OR (runs.state IN ('truncated', 'failed') AND other.id > runs.id)
                 WHEN 'running' THEN 0
                 ELSE runs.state IN ('cancelled', 'interrupted') AND other.id > runs.id END))";

impl Store {
    /// The runs that were made for questions of a batch, by the places of the questions, each in the order in which
    /// they entered the store: of `most` questions from the place `from` on. Deleted runs are left out.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn question_runs(
        &self,
        batch: BatchId,
        from: u64,
        most: Option<u32>,
    ) -> Result<BTreeMap<u64, Vec<QuestionRun>>, StoreError> {
        let connection = self.lock();
        let mut statement = connection.prepare_cached(
            "WITH asked AS MATERIALIZED (
                 SELECT place, key, sample, run FROM items WHERE batch = ?1 AND place >= ?2 ORDER BY place LIMIT ?3),
             made AS MATERIALIZED (
                 SELECT place, runs.id AS run FROM asked
                     JOIN runs ON runs.key = asked.key AND runs.sample = asked.sample
                 UNION SELECT place, run FROM asked WHERE run IS NOT NULL)
             SELECT place, runs.id AS run, state, window_first, window_last, most_usd, input_tokens, output_tokens,
                 reasoning_tokens, cached_tokens, cost_usd, first_chunk_ms, duration_ms,
                 claims_right, claims_wrong, claims_open, claims_check, claims_invented,
                 sentences, sentences_not_understood, sentences_contradictory
             FROM made JOIN runs ON runs.id = made.run WHERE deleted_ms IS NULL ORDER BY place, runs.id",
        )?;
        let most = most.map_or(-1, i64::from); // a negative limit is none
        let mut found: BTreeMap<u64, Vec<QuestionRun>> = BTreeMap::new();
        let rows = statement.query_map(params![batch.0, from, most], |row| {
            Ok((row.get("place")?, rows::from_row(row)?))
        })?;
        for row in rows {
            let (place, run) = row?;
            found.entry(place).or_default().push(run);
        }
        Ok(found)
    }

    /// The runs in whose place another one counts, see [`SUPERSEDED`].
    ///
    /// # Errors
    /// SQLite refused.
    pub fn superseded(&self) -> Result<BTreeSet<RunId>, StoreError> {
        let sql = format!("SELECT id FROM runs WHERE {SUPERSEDED}");
        let found = self.rows(&sql, [], |row| row.get(0).map(RunId))?;
        Ok(found.into_iter().collect())
    }
}

/// Runs of batches, sorted: no table of what is right or wrong counts those of other leads and changed scenes among the
/// others, as they ask something else.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct SecondaryRuns {
    /// About the scenes as they are, at a lead that is not the first one of their batch.
    pub leads: BTreeSet<RunId>,
    /// About changed scenes.
    pub changed: BTreeSet<RunId>,
    /// The others of batches: answers to first questions, whatever else they answer.
    pub first: BTreeSet<RunId>,
    /// The values of the axes of their batches, of those that were asked with some.
    pub settings: BTreeMap<RunId, String>,
    /// Answers to questions of a test split that is not complete, whatever else they answer.
    pub locked: BTreeSet<RunId>,
}

impl Store {
    /// The runs that were made for other leads and changed scenes of batches, and those that answer the same request. A
    /// run that is also the answer to a first question of a batch is none of them.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn asides(&self) -> Result<SecondaryRuns, StoreError> {
        let locked = self.locked_runs()?.into_keys().collect();
        let connection = self.lock();
        // What a batch was begun with comes first: questions without a lead, else the lead that stands first.
        let mut statement = connection.prepare_cached(
            "WITH firsts AS MATERIALIZED (
                 SELECT batch, CASE
                     WHEN max(task = 'safety' AND lead IS NULL AND transform IS NULL) THEN NULL
                     ELSE (SELECT lead FROM items AS one WHERE one.batch = items.batch AND lead IS NOT NULL
                           ORDER BY place LIMIT 1) END AS lead
                 FROM items GROUP BY batch),
             sorted AS MATERIALIZED (
                 SELECT items.run, items.key, items.sample, CASE
                     WHEN items.transform IS NOT NULL THEN 2
                     WHEN items.lead IS NULL OR items.lead IS firsts.lead THEN 0
                     ELSE 1 END AS kind
                 FROM items JOIN firsts ON firsts.batch = items.batch)
             SELECT run, min(kind) FROM (
                 SELECT run, kind FROM sorted WHERE run IS NOT NULL
                 UNION ALL
                 SELECT runs.id, kind FROM sorted JOIN runs ON runs.key = sorted.key AND runs.sample = sorted.sample)
             GROUP BY run",
        )?;
        let rows =
            statement.query_map([], |row| Ok((RunId(row.get(0)?), row.get::<_, i64>(1)?)))?;
        let mut asides = SecondaryRuns {
            locked,
            ..SecondaryRuns::default()
        };
        for row in rows {
            let (run, kind) = row?;
            let runs = match kind {
                0 => &mut asides.first,
                1 => &mut asides.leads,
                _ => &mut asides.changed,
            };
            runs.insert(run);
        }
        let mut statement = connection.prepare_cached(
            "SELECT run, settings FROM items WHERE settings IS NOT NULL AND run IS NOT NULL
             UNION ALL SELECT runs.id, items.settings FROM items
                 JOIN runs ON runs.key = items.key AND runs.sample = items.sample WHERE items.settings IS NOT NULL",
        )?;
        let rows = statement.query_map([], |row| Ok((RunId(row.get(0)?), row.get(1)?)))?;
        for row in rows {
            let (run, settings) = row?;
            asides.settings.insert(run, settings);
        }
        Ok(asides)
    }
}

/// A question without its ground truth and state.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Identity<'a> {
    /// The scenario's file, or the name of a bundled one.
    pub path: &'a str,
    /// Name of the task.
    pub task: &'a str,
    /// `provider/model`.
    pub model: &'a str,
    /// The frame of the description.
    pub frame: Option<&'a str>,
    /// The techniques.
    pub techniques: Option<&'a str>,
    /// The end of its window.
    pub lead: Option<&'a str>,
    /// The change of the scene.
    pub transform: Option<&'a str>,
    /// First and last step of its window, where it was drawn.
    pub window: Option<(i64, i64)>,
    /// Values of the axes of the batch.
    pub settings: Option<&'a str>,
    /// Sample number among several answers.
    pub sample: u32,
}

impl NewItem {
    /// Its identity within the batch.
    #[must_use]
    pub fn identity(&self) -> Identity<'_> {
        Identity {
            path: &self.path,
            task: self.task.name(),
            model: &self.model,
            frame: self.frame.as_deref(),
            techniques: self.techniques.as_deref(),
            lead: self.lead.as_deref(),
            transform: self.transform.as_deref(),
            window: self.window,
            settings: self.settings.as_deref(),
            sample: self.sample,
        }
    }
}
