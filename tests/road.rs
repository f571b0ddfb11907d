//! The road as a graph: lanelets under things, lanes, routes, the drivable area, on built and on real maps.
#![allow(clippy::unwrap_used, clippy::expect_used)]

#[path = "road/built.rs"]
mod built;
#[path = "road/lanes.rs"]
mod lanes;
#[path = "road/published.rs"]
mod published;
#[path = "road/relations.rs"]
mod relations;
#[path = "road/routes.rs"]
mod routes;
mod support;
