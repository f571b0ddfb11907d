//! Asking a model for attacks: as whom, and that its answers are kept.

use std::sync::Arc;

use tokio::sync::oneshot;

use super::super::super::loaded::Writer;
use super::super::Tasks;
use nearmiss_study::evaluation::generating::Author;

impl Tasks {
    /// The author that a model is; nothing is asked yet.
    ///
    /// # Errors
    /// No such model is known: in words.
    pub(in crate::tasks) fn author(
        &self,
        writer: &Writer,
        only: Option<i64>,
    ) -> Result<Author, String> {
        Ok(Author {
            name: writer.name.clone(),
            // As `generate` asks.
            judge: self.judge(&writer.model, None)?,
            store: self.store.clone(),
            library: writer.library.clone(),
            thresholds: Arc::clone(&self.thresholds),
            settings: writer.settings,
            frame: None,
            method: writer.method,
            at_once: usize::try_from(self.concurrency.get()).unwrap_or(1),
            attacker: only,
            obey: false,
            fresh: writer.fresh,
            batch: None,
        })
    }

    /// The end of the program waits until this is dropped: a cancelled request is written down by then.
    pub(in crate::tasks) fn held(&mut self) -> oneshot::Sender<()> {
        let (held, dropped) = oneshot::channel();
        let until = tokio::spawn(async { drop(dropped.await) });
        self.jobs.wait_for(until.abort_handle());
        held
    }
}
