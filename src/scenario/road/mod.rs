//! The lanelet network as a road: what lies where, lanes, the graph, routes, the drivable area.

mod candidates;
mod drivable;
mod error;
mod goal;
mod graph;
mod index;
mod lane;
mod matching;
mod merge;
mod reference;
mod route;

pub use drivable::DrivableArea;
pub use error::RouteError;
pub use graph::{Direction, Driven, LaneGraph, Side};
pub(super) use index::Index;
pub use lane::Lane;
pub use merge::{MergeLimits, MergedLanes};
pub use route::{Destination, Leg, Route};
