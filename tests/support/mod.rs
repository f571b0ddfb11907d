//! Helpers that several test files share.
#![allow(dead_code, clippy::unwrap_used)]

pub mod program;
pub mod server;
