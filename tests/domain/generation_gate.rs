//! The gate for changed motions: what passes it, and that each limit it knows is named when it is broken.
#![allow(clippy::unwrap_used, clippy::expect_used)]

mod built;
mod compared;
mod limits;
mod places;
mod published;
mod python;
mod recorded;
use crate::support;
