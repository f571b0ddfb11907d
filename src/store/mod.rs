//! The store: every run in SQLite, piece by piece as it arrives.

mod database;
mod run;

pub use database::{Store, StoreError};
pub use run::{Consumed, Ending, NewRun, Piece, Run, RunId, RunState};
