//! Reads the index of a corpus, with which of its windows were asked about.

use std::path::PathBuf;
use std::sync::Arc;

use crate::message::Effect;
use crate::model::{Job, JobId, JobKind, Model, Update};
use crate::request::{Replies, Request};
use crate::services::Services;
use crate::update::{index, jobs};
use nearmiss_base::system::shown_path;
use nearmiss_scene::corpus::CorpusIndex;
use nearmiss_scene::judge;
use nearmiss_workflow::read_index;

/// Rows between two messages on progress.
const ROWS_A_MESSAGE: u64 = 65_536;

/// Reads the index in a folder.
#[derive(Debug)]
pub struct ReadIndex {
    /// Its number.
    pub id: JobId,
    /// The folder.
    pub folder: PathBuf,
}

/// Rows of an index, and rows in all; then the index.
pub type IndexUpdate = Update<(u64, u64), Arc<CorpusIndex>>;

impl Request for ReadIndex {
    type Reply = (JobId, IndexUpdate);

    fn sent(&self, model: &mut Model) {
        let title = format!("the index {}", shown_path(&self.folder));
        let job = Job::new(self.id, JobKind::Index, title, 1, model.uptime);
        model.jobs.add(job);
    }

    fn perform(self, services: &mut Services, replies: Replies<Self>) {
        let store = services.store.clone();
        services.run(self.id, replies, move |cancel, progress| {
            // Without a store nothing was asked.
            let answers = store
                .map(|store| store.verdicts(judge::MODEL, None))
                .transpose()
                .map_err(|error| error.to_string())?;
            let mut reported = 0;
            let index = read_index(
                &self.folder,
                &answers.unwrap_or_default(),
                cancel,
                &mut |rows, all| {
                    if rows >= reported + ROWS_A_MESSAGE || rows == all {
                        reported = rows;
                        progress((rows, all));
                    }
                },
            )
            .map_err(|error| error.to_string())?;
            Ok(index.map(Arc::new))
        });
    }

    fn reply(model: &mut Model, (id, update): Self::Reply) -> Vec<Effect> {
        if jobs::note(model, id, |job, now| index::note(job, &update, now)) {
            index::on_update(model, id, update);
        }
        Vec::new()
    }
}
