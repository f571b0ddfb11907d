//! Trajectories that a vehicle can drive: the check itself, and the planner's drives held against it.
#![allow(clippy::unwrap_used, clippy::expect_used)]

#[path = "road/built.rs"]
#[allow(dead_code)]
mod built;
#[path = "planner_check/drivability.rs"]
mod drivability;
#[path = "planner_check/driven.rs"]
mod driven;
#[path = "planner_check/ends.rs"]
mod ends;
#[path = "planner_check/feasibility.rs"]
mod feasibility;
#[path = "planner_check/inputs.rs"]
mod inputs;
mod support;
