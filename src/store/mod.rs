//! The store: every run in SQLite, piece by piece as it arrives; nothing is lost, nothing is asked for twice.

mod claim;
mod database;
mod key;
mod list;
mod migrate;
mod ratings;
mod record;
mod rows;
mod run;
mod write;

pub use claim::{Claim, LEASE, RENEWAL};
pub use database::{Store, StoreError};
pub use key::Key;
pub use list::{Decision, Filter, Summary};
pub use ratings::{Choice, NewRating, RatedAnswer, Rating};
pub use record::RecordError;
pub use run::{Consumed, Ending, NewRun, Origin, Piece, Run, RunId, RunState};

#[cfg(test)]
mod tests;
