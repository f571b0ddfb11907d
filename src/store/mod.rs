//! The store: every run in SQLite, piece by piece as it arrives; nothing is lost, nothing is asked for twice.

mod bound;
mod claim;
mod database;
mod filter;
mod health;
mod key;
mod list;
mod migrate;
mod outcomes;
mod page;
mod ratings;
mod record;
mod rows;
mod run;
mod verdicts;
mod write;

pub use claim::{Claim, LEASE, RENEWAL};
pub use database::{Store, StoreError};
pub use filter::{Decision, Filter, FilterError, moment};
pub use health::Health;
pub use key::Key;
pub use list::Summary;
pub use outcomes::Outcome;
pub use page::{Cursor, Edge, Interrupter, Page};
pub use ratings::{Choice, NewRating, RatedAnswer, Rating};
pub use record::RecordError;
pub use run::{Consumed, Ending, NewRun, Origin, Piece, Run, RunId, RunState};
pub use verdicts::StoredVerdict;

#[cfg(test)]
mod tests;
