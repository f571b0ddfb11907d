//! What provenance and tables over axes need of each run, without its texts.

use serde::Deserialize;

use super::rows::from_row;
use super::{RunId, Store, StoreError};

/// When and of what a run was asked.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
pub struct RunOrigin {
    /// Its number.
    pub run: RunId,
    /// When it was asked, milliseconds since 1970, UTC.
    pub created_ms: i64,
    /// `provider/model`, as asked for.
    pub model: String,
    /// The model as the server named it.
    pub model_returned: Option<String>,
    /// File name of the template.
    pub template: String,
    /// SHA-256 of its text.
    pub template_hash: String,
    /// SHA-256 of the scenario file.
    pub scenario_hash: Option<String>,
    /// The parameters that were sent, as JSON.
    pub parameters: String,
}

impl Store {
    /// The origins of all runs that are not deleted, oldest number first.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn origins(&self) -> Result<Vec<RunOrigin>, StoreError> {
        let connection = self.lock();
        let mut statement = connection.prepare_cached(
            "SELECT id AS run, created_ms, model, model_returned, template, template_hash, scenario_hash,
                 parameters
             FROM runs WHERE deleted_ms IS NULL ORDER BY id",
        )?;
        let rows = statement.query_map([], from_row)?;
        Ok(rows.collect::<Result<_, _>>()?)
    }
}
