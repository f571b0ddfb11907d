//! What the built-in judge says about safety: built scenes, the future, and the published scenarios.
#![allow(clippy::unwrap_used, clippy::expect_used)]

use crate::road::built;
mod future;
mod hostile;
mod published;
mod scenes;
mod stage;
