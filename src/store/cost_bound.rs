//! Upper bounds on a run's cost, stored before it is asked, for runs that break off without reporting one.

use rusqlite::{OptionalExtension, params};

use super::{RunId, Store, StoreError};

impl Store {
    /// Keeps what a run can cost at most, US dollars; nothing where that is not known.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn bound(&self, run: RunId, usd: Option<f64>) -> Result<(), StoreError> {
        self.change(|transaction| {
            let sql = "UPDATE runs SET most_usd = ?2 WHERE id = ?1";
            transaction
                .prepare_cached(sql)?
                .execute(params![run.0, usd])?;
            Ok(())
        })
    }

    /// What a run can have cost at most, US dollars, where that was known when it was asked.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn bound_of(&self, run: RunId) -> Result<Option<f64>, StoreError> {
        let connection = self.lock();
        let found = connection
            .prepare_cached("SELECT most_usd FROM runs WHERE id = ?1")?
            .query_row([run.0], |row| row.get(0))
            .optional()?;
        Ok(found.flatten())
    }
}
