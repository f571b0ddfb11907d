//! Measures along the road: gaps and closing speeds in the Frenet frame of the ego's route.

mod body;
pub(super) mod brake_threat;
pub(super) mod crash_potential;
pub(super) mod drac;
mod exposure;
mod following;
pub(super) mod headway;
pub(super) mod integrated;
pub(super) mod lane_ttc;
pub(super) mod lateral_deceleration;
pub(super) mod longitudinal_deceleration;
mod road;
pub(super) mod rss_lateral;
pub(super) mod rss_longitudinal;
pub(super) mod rss_margin;
pub(super) mod steer_threat;
pub(super) mod time_exposed;
pub(super) mod time_gap;
pub(super) mod time_headway;

pub use body::LaneBody;
pub(super) use exposure::Exposure;
pub(super) use following::Following;
pub use road::{LaneSet, Road};
