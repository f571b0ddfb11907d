//! The store: every run in SQLite, chunk by chunk as it arrives; nothing is lost, nothing is asked twice.

mod answer_state;
mod batches;
mod bundle_record;
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
mod truths;
mod unstored;
mod version;
mod write;

pub use answer_state::{AnswerState, CountedAs, TOO_LONG, attempt_rank};
pub use batches::{Batch, BatchId, Identity, Progress, QuestionRun, SUPERSEDED, SecondaryRuns};
pub use bundle_record::{BatchRecord, QuestionRecord, RatingRecord, Record, SceneRecord};
pub use claim::{Claim, Key, LEASE, RENEWAL};
pub use database::{Store, StoreError};
pub use filter::{Decision, Filter, FilterError, StateFilter, moment};
pub use images::{ImageRecord, StoredImage};
pub use intake::{Intake, MergeCounts};
pub use items::{Item, ItemState, NewItem, NewestAnswer, WindowFacts};
pub use list::{Cursor, Edge, Interrupter, MOST_SHOWN, Page, Summary};
pub use outcomes::{Outcome, RunOrigin, StoredVerdict};
pub use provider_batches::{
    NewProviderBatch, PendingRequest, ProviderBatch, ProviderBatchId, ProviderBatchState,
    ReadyBatch,
};
pub use ratings::{Choice, NewRating, RatedAnswer, Rating, Unrated};
pub use read_only::Health;
pub use record::{RecordError, RecordIntake, RunRecord, record_line};
pub use reflections::{NewReflection, Reflection, ReflectionId};
pub use run::{
    AnswerPiece, Consumed, Ending, NewRun, Origin, Run, RunId, RunState, StoredTemplate,
};
pub use split::{SplitPart, SplitProgress, UnlockRecord};
pub use truths::{ClaimCounts, ItemTruth, RunLabel};
pub use unstored::UnstoredAnswer;

#[cfg(test)]
mod tests;
