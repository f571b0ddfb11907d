//! Measures: published values, and that no measure depends on where, which way and when a scene is.
#![allow(clippy::unwrap_used, clippy::expect_used)]

#[path = "measures/contacts.rs"]
mod contacts;
#[path = "measures/definitions.rs"]
mod definitions;
#[path = "measures/expected.rs"]
mod expected;
#[path = "measures/invariance.rs"]
mod invariance;
#[path = "measures/random.rs"]
mod random;
#[path = "measures/scenes.rs"]
mod scenes;
#[path = "measures/severity.rs"]
mod severity;
#[path = "measures/thresholds.rs"]
mod thresholds;
#[path = "measures/transform.rs"]
mod transform;
