//! The road as a graph: lanelets under things, lanes, routes, the drivable area, on built and on real maps.
#![allow(clippy::unwrap_used, clippy::expect_used)]

pub mod built;
mod lanes;
mod published;
mod relations;
mod routes;
