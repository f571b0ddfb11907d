//! Helpers that several test files share.
#![allow(dead_code, clippy::unwrap_used)]

pub mod batches;
#[cfg(unix)]
pub mod browser;
pub mod dialects;
pub mod drives;
pub mod planted;
pub mod program;
#[cfg(unix)]
pub mod python;
pub mod recorded;
pub mod secret;
pub mod server;
#[cfg(unix)]
pub mod session;
