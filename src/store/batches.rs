//! Batches: their questions, stored before anything is sent, so that a batch can be resumed.

use rusqlite::{OptionalExtension, params};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::database::now_ms;
use super::items::{STATE, insert};
use super::rows::from_row;
use super::{Look, NewItem, Store, StoreError, document};
use nearmiss_scene::verdict::Task;

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
    pub looks: Vec<Look>,
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

    /// Appends questions to a batch and replaces its specification. With a `lead`, safety questions without one get it.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn extend_batch(
        &self,
        id: BatchId,
        spec: &str,
        items: &[NewItem],
        lead: Option<&str>,
    ) -> Result<(), StoreError> {
        self.durably(|transaction| {
            transaction.execute(
                "UPDATE batches SET spec = ?2, updated_ms = ?3 WHERE id = ?1",
                params![id.0, spec, now_ms()],
            )?;
            if let Some(lead) = lead {
                let sql =
                    "UPDATE items SET lead = ?2 WHERE batch = ?1 AND task = ?3 AND lead IS NULL";
                transaction.execute(sql, params![id.0, lead, Task::Safety.name()])?;
            }
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
        let connection = self.lock();
        let sql = format!(
            "SELECT {COLUMNS}, count(DISTINCT asked.path) AS scenarios,
                 coalesce(sum(now = 'waiting'), 0) AS waiting, coalesce(sum(now = 'answered'), 0) AS answered,
                 coalesce(sum(now = 'truncated'), 0) AS truncated, coalesce(sum(now = 'failed'), 0) AS failed,
                 coalesce(sum(now = 'unaskable'), 0) AS unaskable
             FROM batches LEFT JOIN (SELECT items.batch, items.path, {STATE} AS now FROM items) AS asked
                 ON asked.batch = batches.id GROUP BY batches.id ORDER BY id DESC"
        );
        let mut statement = connection.prepare(&sql)?;
        let rows = statement.query_map([], |row| Ok((from_row(row)?, from_row(row)?)))?;
        let found: Vec<(Batch, Progress)> = rows.collect::<Result<_, _>>()?;
        drop(statement);
        drop(connection);
        let found = found.into_iter();
        found
            .map(|(batch, progress)| Ok((self.with_looks(batch)?, progress)))
            .collect()
    }
}
