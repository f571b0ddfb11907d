//! Measures along the road: gaps and closing speeds in the Frenet frame of the ego's route.

pub(super) mod exposure;
pub(super) mod following;
pub(super) mod required_acceleration;
mod road;
pub(super) mod rss;

pub(super) use exposure::Exposure;
pub(super) use following::Following;
pub use road::{LaneBody, LaneSet, Road};
