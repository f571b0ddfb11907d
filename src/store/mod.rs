//! The store: every run in SQLite, chunk by chunk as it arrives; nothing is lost, nothing is asked twice.

mod asked_templates;
mod batches;
mod claim;
mod cost_bound;
mod database;
mod durable;
mod filter;
mod health;
mod identity;
mod items;
mod key;
mod list;
mod merge;
mod migrate;
mod outcomes;
mod page;
mod provider_batches;
mod ratings;
mod read_only;
mod record;
mod rows;
mod run;
mod secondary_runs;
mod truths;
mod unstored;
mod verdicts;
mod write;

pub use asked_templates::{AskedTemplate, SameQuestion};
pub use batches::{Batch, BatchId, Progress};
pub use claim::{Claim, LEASE, RENEWAL};
pub use database::{Store, StoreError};
pub use filter::{Decision, Filter, FilterError, moment};
pub use health::Health;
pub use identity::Identity;
pub use items::{Item, ItemState, NewItem, NewestAnswer};
pub use key::Key;
pub use list::{MOST_SHOWN, Summary};
pub use merge::MergeCounts;
pub use outcomes::Outcome;
pub use page::{Cursor, Edge, Interrupter, Page};
pub use provider_batches::{
    NewProviderBatch, PendingRequest, ProviderBatch, ProviderBatchId, ProviderBatchState,
    ReadyBatch,
};
pub use ratings::{Choice, NewRating, RatedAnswer, Rating, Unrated};
pub use record::RecordError;
pub use run::{
    AnswerPiece, Consumed, Ending, NewRun, Origin, Run, RunId, RunState, StoredTemplate,
};
pub use secondary_runs::SecondaryRuns;
pub use truths::RunLabel;
pub use unstored::UnstoredAnswer;
pub use verdicts::StoredVerdict;

#[cfg(test)]
mod tests;
