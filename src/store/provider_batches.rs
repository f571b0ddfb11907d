//! Batches submitted to providers: their questions, provider ids and collected results.

use rusqlite::{OptionalExtension, Transaction, params};
use serde::Deserialize;
use strum::{IntoStaticStr, VariantArray};

use super::claim::{FOR_EVER, hold_until, interrupt_abandoned, there};
use super::database::{all_rows, now_ms};
use super::rows::from_row;
use super::{AnswerPiece, Claim, Ending, Key, NewRun, RunId, Store, StoreError, run};

/// Identifies a batch in its store; the provider uses a separate id.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Deserialize)]
pub struct ProviderBatchId(pub i64);

impl std::fmt::Display for ProviderBatchId {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}", self.0)
    }
}

/// State of a submitted batch, as far as this store knows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "snake_case")]
pub enum ProviderBatchState {
    /// It is about to be sent, or it is unknown whether it arrived.
    Submitting,
    /// The provider has it.
    Submitted,
    /// The provider was asked to stop.
    Cancelling,
    /// Its results are in the store.
    Ended,
    /// The same; it was cancelled.
    Cancelled,
    /// The same; the provider's time was over.
    Expired,
    /// The provider could not use it.
    Failed,
    /// It never reached the provider.
    NotSent,
}

nearmiss_record::named!(ProviderBatchState, "state");

impl ProviderBatchState {
    /// Whether the provider may still return something.
    #[must_use]
    pub fn is_open(self) -> bool {
        matches!(self, Self::Submitting | Self::Submitted | Self::Cancelling)
    }
}

/// Data known before a batch is sent.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NewProviderBatch {
    /// `provider/model`.
    pub model: String,
    /// The server's address, without user, password and query.
    pub address: String,
}

/// A batch that may be sent now.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ReadyBatch {
    /// Its number.
    pub id: ProviderBatchId,
    /// What it is recognised by.
    pub tag: String,
    /// For each question its run and the id used at the provider; `None` if another run has the answer or is asking for
    /// it.
    pub requests: Vec<Option<(RunId, String)>>,
}

/// A batch as it is kept.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
pub struct ProviderBatch {
    /// Its number.
    pub id: ProviderBatchId,
    /// What it is recognised by.
    pub tag: String,
    /// When it was written down, milliseconds since 1970, UTC.
    pub created_ms: i64,
    /// When it was about to be sent.
    pub submitted_ms: i64,
    /// `provider/model`.
    pub model: String,
    /// The server's address.
    pub address: String,
    /// The provider's id; `None` until it arrived.
    pub remote_id: Option<String>,
    /// Where it stands.
    pub state: ProviderBatchState,
    /// Why it has no answers.
    pub problem: Option<String>,
    /// Questions in it.
    pub requests: u64,
    /// Those whose results are in the store.
    pub done: u64,
}

/// A question of a batch whose result is not in the store yet.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
pub struct PendingRequest {
    /// Its run.
    pub run: RunId,
    /// What the provider calls it.
    pub custom_id: String,
}

const LISTED: &str = "SELECT *,
    (SELECT count(*) FROM provider_requests WHERE batch = provider_batches.id) AS requests,
    (SELECT coalesce(sum(done), 0) FROM provider_requests WHERE batch = provider_batches.id) AS done
    FROM provider_batches";

impl Store {
    /// Whether any question is with a provider.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn any_handed(&self) -> Result<bool, StoreError> {
        let sql = "SELECT EXISTS (SELECT 1 FROM provider_requests WHERE done = 0)";
        Ok(self.lock().query_row(sql, [], |row| row.get(0))?)
    }

    /// Whether this request and sample is with a provider.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn is_handed(&self, key: &Key, sample: u32) -> Result<bool, StoreError> {
        let connection = self.lock();
        let mut statement = connection.prepare_cached(
            "SELECT EXISTS (SELECT 1 FROM runs JOIN provider_requests ON provider_requests.run = runs.id
                 WHERE key = ?1 AND sample = ?2 AND done = 0)",
        )?;
        Ok(statement.query_row(params![key.as_str(), sample], |row| row.get(0))?)
    }

    /// Records, before anything is sent, that these questions go to a provider: each in its own run, claimed until its
    /// result arrives. Writes nothing if all of them are answered or in progress.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn open_provider_batch(
        &self,
        batch: &NewProviderBatch,
        runs: &[NewRun],
    ) -> Result<Option<ReadyBatch>, StoreError> {
        self.durably(|transaction| {
            interrupt_abandoned(transaction)?;
            let mut fresh = Vec::with_capacity(runs.len());
            for run in runs {
                let found = match run.key() {
                    Some(key) => there(transaction, &key, run.sample)?,
                    None => None,
                };
                let granted = match found {
                    Some(Claim::Stored(_) | Claim::Taken(_)) => None,
                    Some(Claim::Granted(run)) => Some(run),
                    None => {
                        let id = run::insert_new(transaction, run, now_ms())?;
                        // No program has to be alive while the provider works.
                        hold_until(transaction, id, FOR_EVER)?;
                        Some(id)
                    }
                };
                fresh.push(granted);
            }
            if fresh.iter().all(Option::is_none) {
                return Ok(None);
            }
            let (id, tag) = insert(transaction, batch)?;
            let mut requests = Vec::with_capacity(fresh.len());
            for run in fresh {
                requests.push(match run {
                    Some(run) => {
                        let custom_id = format!("{tag}-{run}");
                        let sql = "INSERT INTO provider_requests (run, batch, custom_id) VALUES (?1, ?2, ?3)";
                        let mut statement = transaction.prepare_cached(sql)?;
                        statement.execute(params![run.0, id.0, custom_id])?;
                        Some((run, custom_id))
                    }
                    None => None,
                });
            }
            Ok(Some(ReadyBatch { id, tag, requests }))
        })
    }

    /// Takes note that a batch is sent now; whether it still may be: another program may have given it up.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn about_to_submit(&self, batch: ProviderBatchId) -> Result<bool, StoreError> {
        self.durably(|transaction| {
            let sql = "UPDATE provider_batches SET submitted_ms = ?2, updated_ms = ?2
                WHERE id = ?1 AND state = 'submitting'";
            Ok(transaction.execute(sql, params![batch.0, now_ms()])? == 1)
        })
    }

    /// Keeps the provider's id of a batch; afterwards it is on the disk.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn submitted(&self, batch: ProviderBatchId, remote_id: &str) -> Result<(), StoreError> {
        self.durably(|transaction| {
            // Whatever was believed of it meanwhile: the provider has it.
            let sql =
                "UPDATE provider_batches SET remote_id = ?2, state = 'submitted', updated_ms = ?3
                WHERE id = ?1 AND state IN ('submitting', 'not_sent')";
            transaction.execute(sql, params![batch.0, remote_id, now_ms()])?;
            Ok(())
        })
    }

    /// Takes note that the provider was asked to stop.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn cancelling(&self, batch: ProviderBatchId) -> Result<(), StoreError> {
        self.durably(|transaction| {
            let sql = "UPDATE provider_batches SET state = 'cancelling', updated_ms = ?2
                WHERE id = ?1 AND state = 'submitted'";
            transaction.execute(sql, params![batch.0, now_ms()])?;
            Ok(())
        })
    }

    /// Writes the result of one question into its run, once: whether it was the first time.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn settle(
        &self,
        run: RunId,
        pieces: &[AnswerPiece<'_>],
        ending: &Ending,
    ) -> Result<bool, StoreError> {
        self.durably(|transaction| settle(transaction, run, pieces, ending))
    }

    /// Ends a batch of which nothing more comes: questions without a result end in this way, in the same transaction.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn close_provider_batch(
        &self,
        batch: ProviderBatchId,
        state: ProviderBatchState,
        problem: Option<&str>,
        rest: &Ending,
    ) -> Result<u64, StoreError> {
        self.durably(|transaction| {
            let mut ended = 0;
            for handed in open_requests(transaction, batch)? {
                ended += u64::from(settle(transaction, handed.run, &[], rest)?);
            }
            let sql = "UPDATE provider_batches SET state = ?2, problem = ?3, updated_ms = ?4 WHERE id = ?1";
            transaction.execute(sql, params![batch.0, state.name(), problem, now_ms()])?;
            Ok(ended)
        })
    }

    /// The questions of a batch whose results are not in the store.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn handed(&self, batch: ProviderBatchId) -> Result<Vec<PendingRequest>, StoreError> {
        self.change(|transaction| open_requests(transaction, batch))
    }

    /// All batches that were handed to providers, newest first.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn provider_batches(&self) -> Result<Vec<ProviderBatch>, StoreError> {
        self.rows(&format!("{LISTED} ORDER BY id DESC"), [], from_row)
    }

    /// One batch.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn provider_batch(&self, id: ProviderBatchId) -> Result<Option<ProviderBatch>, StoreError> {
        let connection = self.lock();
        let mut statement = connection.prepare_cached(&format!("{LISTED} WHERE id = ?1"))?;
        Ok(statement.query_row([id.0], from_row).optional()?)
    }
}

fn insert(
    transaction: &Transaction<'_>,
    batch: &NewProviderBatch,
) -> Result<(ProviderBatchId, String), StoreError> {
    let sql = "INSERT INTO provider_batches (tag, created_ms, updated_ms, submitted_ms, model, address, state)
        VALUES (lower(hex(randomblob(10))), ?1, ?1, ?1, ?2, ?3, 'submitting') RETURNING id, tag";
    let values = params![now_ms(), batch.model, batch.address];
    Ok(transaction.query_row(sql, values, |row| {
        Ok((ProviderBatchId(row.get(0)?), row.get(1)?))
    })?)
}

fn settle(
    transaction: &Transaction<'_>,
    run: RunId,
    pieces: &[AnswerPiece<'_>],
    ending: &Ending,
) -> Result<bool, StoreError> {
    let sql = "UPDATE provider_requests SET done = 1 WHERE run = ?1 AND done = 0";
    if transaction.prepare_cached(sql)?.execute([run.0])? == 0 {
        return Ok(false);
    }
    run::conclude(transaction, run, pieces, ending)?;
    Ok(true)
}

fn open_requests(
    transaction: &Transaction<'_>,
    batch: ProviderBatchId,
) -> Result<Vec<PendingRequest>, StoreError> {
    let sql =
        "SELECT run, custom_id FROM provider_requests WHERE batch = ?1 AND done = 0 ORDER BY run";
    all_rows(transaction, sql, [batch.0], from_row)
}

#[cfg(test)]
#[path = "provider_batches_tests.rs"]
mod tests;
