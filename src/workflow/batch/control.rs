//! Cancels a running batch, and limits how many requests of all batches run at once.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use tokio::sync::{Semaphore, watch};

/// Stops or cancels a batch; its clones are the same control.
#[derive(Debug, Clone)]
pub struct BatchControl(Arc<watch::Sender<Phase>>);

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd)]
enum Phase {
    Asking,
    Stopped,
    Cancelled,
}

impl Default for BatchControl {
    fn default() -> Self {
        Self(Arc::new(watch::Sender::new(Phase::Asking)))
    }
}

impl BatchControl {
    /// Begins no further question; what was sent is waited for.
    pub fn stop(&self) {
        self.advance(Phase::Stopped);
    }

    /// Cancels also requests already sent, and records that in the store.
    pub fn cancel(&self) {
        self.advance(Phase::Cancelled);
    }

    /// Whether no further question is begun.
    #[must_use]
    pub fn is_stopped(&self) -> bool {
        *self.0.borrow() >= Phase::Stopped
    }

    /// Waits until the batch is cancelled.
    pub(super) async fn cancelled(&self) {
        // This holds the sender, so the channel stays open.
        let _ = self
            .0
            .subscribe()
            .wait_for(|phase| *phase == Phase::Cancelled)
            .await;
    }

    fn advance(&self, phase: Phase) {
        self.0.send_if_modified(|now| {
            let further = *now < phase;
            if further {
                *now = phase;
            }
            further
        });
    }
}

/// Requests to each provider that are on their way at once, over all batches of the program.
#[derive(Debug, Default)]
pub struct ProviderSlots(Mutex<HashMap<String, Arc<Semaphore>>>);

impl ProviderSlots {
    /// The slots of a provider, `most` where it has none yet.
    pub(super) fn of_provider(&self, provider: &str, most: usize) -> Arc<Semaphore> {
        let mut slots = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let slots = slots.entry(provider.to_string());
        Arc::clone(slots.or_insert_with(|| Arc::new(Semaphore::new(most))))
    }
}
