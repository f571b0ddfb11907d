//! Whether a vehicle could have driven a finished trajectory: checked step by step, independent of how it was made.
//!
//! From each state to the next a kinematic single-track vehicle must get with one steering rate and one acceleration
//! that keep its limits, as `commonroad-drivability-checker` asks it.

use super::{Limit, Limits};
use crate::geometry::{Pose, Vector, angle_between};
use crate::scenario::{Motion, Track};

/// One limit that a trajectory breaks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Broken {
    /// The time step at whose beginning the limit is broken.
    pub step: i64,
    /// Which.
    pub limit: Limit,
    /// The value that was needed, in the limit's unit.
    pub value: f64,
    /// The most that is allowed.
    pub most: f64,
}

/// A trajectory that can be driven.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Feasible {
    /// Steps that were checked.
    pub steps: usize,
    /// The largest share of the friction circle that was used, 0 to 1.
    pub friction: f64,
}

/// What a trajectory breaks.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{} limits are broken", .0.len())]
pub struct FeasibilityError(pub Vec<Broken>);
