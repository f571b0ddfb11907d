//! Asking a model for attacks: as whom, and how that is stopped.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use tokio::sync::{Notify, oneshot};

use super::super::super::loaded::Writer;
use super::super::Tasks;
use crate::evaluation::generating::{Author, RETRIES, SAMPLES};

/// Tells work that it shall end, whether it waits or works.
#[derive(Debug, Default)]
pub struct Stop {
    asked: AtomicBool,
    woken: Notify,
}

impl Stop {
    /// It shall end.
    pub fn ask(&self) {
        self.asked.store(true, Ordering::Relaxed);
        self.woken.notify_one();
    }

    /// Whether it shall end.
    pub fn is_asked(&self) -> bool {
        self.asked.load(Ordering::Relaxed)
    }

    /// Waits for some work, or gives nothing as soon as it shall end; the work is dropped then.
    pub async fn or<T>(&self, work: impl Future<Output = T>) -> Option<T> {
        tokio::select! {
            biased;
            () = self.woken.notified() => None,
            done = work => Some(done),
        }
    }
}

impl Tasks {
    /// The author that a model is; nothing is asked yet.
    ///
    /// # Errors
    /// No such model is known: in words.
    pub(in crate::tui::tasks) fn author(
        &self,
        writer: &Writer,
        only: Option<i64>,
    ) -> Result<Author, String> {
        Ok(Author {
            name: writer.name.clone(),
            judge: self.judge(&writer.model)?,
            store: self.store.clone(),
            library: writer.library.clone(),
            thresholds: Arc::clone(&self.thresholds),
            settings: writer.settings,
            frame: None,
            samples: SAMPLES,
            retries: RETRIES,
            at_once: usize::try_from(self.concurrency.get()).unwrap_or(1),
            attacker: only,
            obey: false,
            fresh: writer.fresh,
            batch: None,
        })
    }

    /// Whoever ends the program waits until this is dropped: a request that was cancelled is written down by then.
    pub(in crate::tui::tasks) fn held(&mut self) -> oneshot::Sender<()> {
        let (held, dropped) = oneshot::channel();
        self.ending.retain(|handle| !handle.is_finished());
        let until = tokio::spawn(async { drop(dropped.await) });
        self.ending.push(until.abort_handle());
        held
    }
}
