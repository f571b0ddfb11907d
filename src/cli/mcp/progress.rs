//! How far a request is, which clients are told once a second, and whether it is still wanted.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use rmcp::model::{ProgressNotificationParam, ProgressToken};
use rmcp::service::{Peer, RequestContext, RoleServer};
use tokio::runtime::Handle;

/// How often progress is told.
pub const TOLD: Duration = Duration::from_secs(1);

/// The progress of a request.
#[derive(Debug)]
pub struct Progress {
    /// Becomes true when the request is taken back.
    pub cancel: Arc<AtomicBool>,
    client: Peer<RoleServer>,
    /// What the client knows it by, if it wants to know.
    token: Option<ProgressToken>,
    told: Mutex<Instant>,
    runtime: Handle,
}

impl Progress {
    /// That of a request, in a task of the server.
    pub fn new(request: &RequestContext<RoleServer>) -> Self {
        Self {
            cancel: Arc::default(),
            client: request.peer.clone(),
            token: request.meta.get_progress_token(),
            told: Mutex::new(Instant::now()),
            runtime: Handle::current(),
        }
    }

    /// Whether the request was taken back.
    pub fn is_cancelled(&self) -> bool {
        self.cancel.load(Ordering::SeqCst)
    }

    /// Tells the progress in words, once in [`TOLD`], to clients that want to know.
    pub fn tell(&self, done: usize, total: Option<usize>, words: &str) {
        let mut told = self.told.lock().unwrap_or_else(PoisonError::into_inner);
        let Some(token) = self.token.as_ref().filter(|_| told.elapsed() >= TOLD) else {
            return;
        };
        *told = Instant::now();
        let mut progress =
            ProgressNotificationParam::new(token.clone(), done as f64).with_message(words);
        progress.total = total.map(|total| total as f64);
        let client = self.client.clone();
        // A client that has gone is not told.
        self.runtime
            .spawn(async move { client.notify_progress(progress).await });
    }
}
