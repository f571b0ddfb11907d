//! Reads the index of a corpus, with which of its windows were asked about.

use std::path::PathBuf;
use std::sync::Arc;

use super::super::message::{JobEvent, JobId};
use super::Tasks;
use nearmiss_scene::judge;
use nearmiss_workflow::read_index;

/// Rows between two messages on progress.
const ROWS_A_MESSAGE: u64 = 65_536;

impl Tasks {
    /// Reads the index in a folder.
    pub(super) fn read_index(&mut self, id: JobId, folder: PathBuf) {
        let store = self.store.clone();
        self.run(id, JobEvent::Index, move |cancel, tell| {
            // Without a store nothing was asked.
            let answers = store
                .map(|store| store.verdicts(judge::MODEL, None))
                .transpose()
                .map_err(|error| error.to_string())?;
            let mut told = 0;
            let index = read_index(
                &folder,
                &answers.unwrap_or_default(),
                cancel,
                &mut |rows, all| {
                    if rows >= told + ROWS_A_MESSAGE || rows == all {
                        told = rows;
                        tell((rows, all));
                    }
                },
            )
            .map_err(|error| error.to_string())?;
            Ok(index.map(Arc::new))
        });
    }
}
