//! The store: every run in SQLite, chunk by chunk as it arrives; nothing is lost, nothing is asked twice.

mod answer_state;
mod attempts;
mod batch_record;
mod batches;
mod claim;
mod claim_counts;
mod cost_bound;
mod database;
mod document;
mod durable;
mod filter;
mod health;
mod identity;
mod images;
mod intake;
mod items;
mod key;
mod list;
mod merge;
mod migrate;
mod model_words;
mod outcomes;
mod page;
mod provider_batches;
mod rating_record;
mod ratings;
mod read_only;
mod record;
mod record_intake;
mod reflections;
mod rounds;
mod rows;
mod run;
mod run_origins;
mod scene_record;
mod secondary_runs;
mod split;
mod truths;
mod unstored;
mod verdicts;
mod write;

pub use answer_state::{AnswerState, CountedAs, TOO_LONG, attempt_rank};
pub use attempts::{QuestionRun, SUPERSEDED};
pub use batch_record::{BatchRecord, QuestionRecord, Record};
pub use batches::{Batch, BatchId, Progress};
pub use claim::{Claim, LEASE, RENEWAL};
pub use claim_counts::ClaimCounts;
pub use database::{Store, StoreError};
pub use filter::{Decision, Filter, FilterError, StateFilter, moment};
pub use health::Health;
pub use identity::Identity;
pub use images::{ImageRecord, StoredImage};
pub use intake::Intake;
pub use items::{Item, ItemState, NewItem, NewestAnswer, WindowFacts};
pub use key::Key;
pub use list::{MOST_SHOWN, Summary};
pub use merge::MergeCounts;
pub use outcomes::Outcome;
pub use page::{Cursor, Edge, Interrupter, Page};
pub use provider_batches::{
    NewProviderBatch, PendingRequest, ProviderBatch, ProviderBatchId, ProviderBatchState,
    ReadyBatch,
};
pub use rating_record::RatingRecord;
pub use ratings::{Choice, NewRating, RatedAnswer, Rating, Unrated};
pub use record::{RecordError, RunRecord, record_line};
pub use record_intake::RecordIntake;
pub use reflections::{NewReflection, Reflection, ReflectionId};
pub use run::{
    AnswerPiece, Consumed, Ending, NewRun, Origin, Run, RunId, RunState, StoredTemplate,
};
pub use run_origins::RunOrigin;
pub use scene_record::SceneRecord;
pub use secondary_runs::SecondaryRuns;
pub use split::{Look, SplitPart, SplitProgress};
pub use truths::{ItemTruth, RunLabel};
pub use unstored::UnstoredAnswer;
pub use verdicts::StoredVerdict;

#[cfg(test)]
mod tests;
