//! How much memory reading and filling take at most. The tests measure the whole process, so they run one after the other.
#![allow(clippy::unwrap_used)]

mod reading;
#[path = "../support/mod.rs"]
mod support;
mod template_limits;

use std::sync::{Mutex, MutexGuard, PoisonError};

use peak_alloc::PeakAlloc;

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

static TURN: Mutex<()> = Mutex::new(());

/// Waits until no other test measures.
fn alone() -> MutexGuard<'static, ()> {
    TURN.lock().unwrap_or_else(PoisonError::into_inner)
}
