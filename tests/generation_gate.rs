//! The gate for changed motions: what passes it, and that each limit it knows is named when it is broken.
#![allow(clippy::unwrap_used, clippy::expect_used)]

#[path = "generation_gate/built.rs"]
mod built;
#[path = "generation_gate/compared.rs"]
mod compared;
#[path = "generation_gate/limits.rs"]
mod limits;
#[path = "generation_gate/places.rs"]
mod places;
#[path = "generation_gate/published.rs"]
mod published;
#[path = "generation_gate/python.rs"]
mod python;
#[path = "generation_gate/recorded.rs"]
mod recorded;
mod support;
