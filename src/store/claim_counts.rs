//! How many claims of an answer about obstacles are right, wrong and open, as kept with its run.

use rusqlite::params;
use serde::{Deserialize, Serialize};

use super::{RunId, Store, StoreError};

/// Counts of claims. All are `None` where the answer was not checked, as its scenario was not at hand.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, schemars::JsonSchema,
)]
pub struct ClaimCounts {
    /// Claims about obstacles in the answer that hold; null if they were not checked.
    pub claims_right: Option<u32>,
    /// Claims that do not hold.
    pub claims_wrong: Option<u32>,
    /// Claims that cannot be decided.
    pub claims_open: Option<u32>,
    /// Version of the check that counted the claims.
    pub claims_check: Option<u32>,
}

impl ClaimCounts {
    /// Right, wrong and open; `None` if the answer was not checked.
    #[must_use]
    pub fn known(self) -> Option<[u32; 3]> {
        Some([self.claims_right?, self.claims_wrong?, self.claims_open?])
    }
}

impl Store {
    /// Keeps counts of claims with their runs; runs that are gone are left out.
    ///
    /// # Errors
    /// SQLite refused; nothing is kept then.
    pub fn keep_claims(&self, counted: &[(RunId, ClaimCounts)]) -> Result<(), StoreError> {
        self.durably(|transaction| {
            let mut statement = transaction.prepare_cached(
                "UPDATE runs SET claims_right = ?2, claims_wrong = ?3, claims_open = ?4, claims_check = ?5
                 WHERE id = ?1",
            )?;
            for (run, counts) in counted {
                statement.execute(params![
                    run.0,
                    counts.claims_right,
                    counts.claims_wrong,
                    counts.claims_open,
                    counts.claims_check
                ])?;
            }
            Ok(())
        })
    }
}
