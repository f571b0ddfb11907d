//! What the built-in judge says about safety: built scenes, the future, and the published scenarios.
#![allow(clippy::unwrap_used, clippy::expect_used)]

#[path = "road/built.rs"]
#[allow(dead_code)]
mod built;
#[path = "safety/future.rs"]
mod future;
#[path = "safety/hostile.rs"]
mod hostile;
#[path = "safety/published.rs"]
mod published;
#[path = "safety/scenes.rs"]
mod scenes;
#[path = "safety/stage.rs"]
mod stage;
mod support;
