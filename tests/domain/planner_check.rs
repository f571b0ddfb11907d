//! Trajectories that a vehicle can drive: the check itself, and the planner's drives held against it.
#![allow(clippy::unwrap_used, clippy::expect_used)]

use crate::road::built;
mod drivability;
mod driven;
mod ends;
mod feasibility;
mod inputs;
use crate::support;
