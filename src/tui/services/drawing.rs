//! Pictures that are being drawn: counted, and stopped at the end of the program.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Pictures that are being drawn. What is stopped leaves nothing behind.
#[derive(Debug, Default)]
pub struct Drawing {
    stop: Arc<AtomicBool>,
    /// Each drawing task holds one.
    held: Arc<()>,
}

/// A guard for a picture being drawn.
#[derive(Debug)]
pub struct DrawGuard {
    stop: Arc<AtomicBool>,
    _held: Arc<()>,
}

impl DrawGuard {
    /// Set once it shall end.
    pub fn stop(&self) -> &AtomicBool {
        &self.stop
    }
}

impl Drawing {
    /// Another one begins.
    pub fn begin(&self) -> DrawGuard {
        DrawGuard {
            stop: Arc::clone(&self.stop),
            _held: Arc::clone(&self.held),
        }
    }

    /// All shall end.
    pub fn stop(&self) {
        self.stop.store(true, Ordering::Relaxed);
    }

    /// Whether the drawing thread has ended.
    pub fn ended(&self) -> bool {
        Arc::strong_count(&self.held) == 1
    }
}
