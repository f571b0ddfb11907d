//! Connections to the server: a bounded number, in which those that say nothing give way.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use tokio::task::AbortHandle;

/// Connections at once.
const MOST: usize = 64;

/// The open ones, the oldest first.
#[derive(Debug, Default)]
pub struct Connections(Mutex<Vec<Connection>>);

#[derive(Debug)]
struct Connection {
    task: AbortHandle,
    /// Whether a request with the token came on it.
    admitted: Arc<AtomicBool>,
}

impl Connections {
    /// Serves a new connection by the task that `serve` starts; it is given the flag for a request with the token. Where
    /// there are too many, the oldest without such a request is closed; where all have one, the new one is.
    pub fn add(&self, serve: impl FnOnce(Arc<AtomicBool>) -> AbortHandle) {
        let mut open = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        open.retain(|connection| !connection.task.is_finished());
        if open.len() >= MOST {
            let silent = |one: &Connection| !one.admitted.load(Ordering::SeqCst);
            let Some(oldest) = open.iter().position(silent) else {
                return;
            };
            open.remove(oldest).task.abort();
        }
        let admitted = Arc::new(AtomicBool::new(false));
        let task = serve(Arc::clone(&admitted));
        open.push(Connection { task, admitted });
    }
}
