//! A cancellation token for planning.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// A wish that planning ends early, shared between the planner and the code that waits for it.
#[derive(Debug, Clone, Default)]
pub struct Cancel(Arc<AtomicBool>);

impl Cancel {
    /// The wish that `flag` stands for.
    #[must_use]
    pub fn from_flag(flag: &Arc<AtomicBool>) -> Self {
        Self(Arc::clone(flag))
    }

    /// Asks for it.
    pub fn ask(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether planning is to end: what comes out of it then is not whole, and is to be dropped.
    #[must_use]
    #[inline]
    pub fn is_asked(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}
