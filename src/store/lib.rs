//! The store: every run in SQLite, chunk by chunk as it arrives; nothing is lost, nothing is asked twice.

mod batches;
mod claim;
mod database;
mod document;
mod filter;
mod images;
mod intake;
mod items;
mod list;
mod outcomes;
mod provider_batches;
mod ratings;
mod read_only;
mod record;
mod reflections;
mod rows;
mod run;
mod split;

pub use batches::{Batch, BatchId, Identity, Progress, QuestionRun, SUPERSEDED, SecondaryRuns};
pub use claim::{Claim, Key, LEASE, RENEWAL};
pub use database::{Store, StoreError, now_ms};
pub use filter::{Decision, Filter, FilterError, StateFilter, moment};
pub use images::{ImageRecord, StoredImage};
pub use intake::{Intake, MergeCounts, UnstoredAnswer};
pub use items::{
    ClaimCounts, Item, ItemState, ItemTruth, NewItem, NewestAnswer, RunLabel, WindowFacts,
};
pub use list::{Cursor, Edge, Interrupter, MOST_SHOWN, Page, Summary};
pub use outcomes::{
    AnswerState, CountedAs, Outcome, RunOrigin, StoredVerdict, TOO_LONG, attempt_rank,
};
pub use provider_batches::{
    NewProviderBatch, PendingRequest, ProviderBatch, ProviderBatchId, ProviderBatchState,
    ReadyBatch,
};
pub use ratings::{Choice, NewRating, RatedAnswer, Rating, Unrated};
pub use read_only::Health;
pub use record::{
    BatchRecord, QuestionRecord, RatingRecord, Record, RecordError, RecordIntake, RunRecord,
    SceneRecord, record_line,
};
pub use reflections::{NewReflection, Reflection, ReflectionId};
pub use run::{
    AnswerPiece, Consumed, Ending, NewRun, Origin, Run, RunId, RunState, StoredTemplate,
};
pub use split::{SplitPart, SplitProgress, UnlockRecord};

#[cfg(test)]
mod tests;
