//! Measures: published values, and that no measure depends on where, which way and when a scene is.
#![allow(clippy::unwrap_used, clippy::expect_used)]

mod contacts;
mod definitions;
mod encounters;
mod events;
mod expected;
mod impacts;
mod invariance;
pub mod random;
pub mod scenes;
mod severity;
mod thresholds;
mod transform;
