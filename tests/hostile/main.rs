//! Damaged, hostile and foreign input.

mod mutated;
mod recordings;
#[path = "../support/mod.rs"]
mod support;
