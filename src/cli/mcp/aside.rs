//! What a request is answered with beside its parameters: whether it was taken back, and how its progress is told.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use super::lines::Wire;

/// How often progress is told.
pub const TOLD: Duration = Duration::from_secs(1);

/// Beside a request.
#[derive(Debug)]
pub struct Aside<'a> {
    /// Becomes true when it is taken back.
    pub cancel: &'a Arc<AtomicBool>,
    wire: &'a Wire,
    /// What the client knows its progress by.
    token: Option<Value>,
    told: Mutex<Instant>,
}

impl<'a> Aside<'a> {
    /// Beside a request with these parameters.
    pub fn new(cancel: &'a Arc<AtomicBool>, wire: &'a Wire, parameters: &Value) -> Self {
        let token = parameters.pointer("/_meta/progressToken").cloned();
        let is_token = |token: &Value| token.is_string() || token.is_i64() || token.is_u64();
        Self {
            cancel,
            wire,
            token: token.filter(is_token),
            told: Mutex::new(Instant::now()),
        }
    }

    /// Whether the request was taken back.
    pub fn is_cancelled(&self) -> bool {
        self.cancel.load(Ordering::SeqCst)
    }

    /// Tells the progress in words, once in [`TOLD`], to clients that want to know.
    pub fn tell(&self, progress: usize, total: Option<usize>, words: &str) {
        let mut told = self.told.lock().unwrap_or_else(PoisonError::into_inner);
        let Some(token) = self.token.as_ref().filter(|_| told.elapsed() >= TOLD) else {
            return;
        };
        *told = Instant::now();
        let mut parameters =
            json!({"progressToken": token, "progress": progress, "message": words});
        if let Some(total) = total {
            parameters["total"] = total.into();
        }
        self.wire.send(&json!({
            "jsonrpc": "2.0", "method": "notifications/progress", "params": parameters,
        }));
    }
}
