//! Traffic that reacts: obstacles follow their recording until the ego's deviation concerns them, then they drive their
//! recorded path with the Intelligent Driver Model.
//!
//! An obstacle begins to react at the step at which its recorded motion leads into the ego (or into an obstacle that
//! reacts) and comfortable braking would no longer be enough a step later, see `trigger`. From then on it stays on its
//! recorded path, and on the lane beyond its end (`course`), wants to drive as fast as was recorded at each place
//! (`desired`), and keeps its distance to whatever body is on its path or reaches a crossing first (`leader`), within
//! the limits of people ([`HumanLimits`](nearmiss_scene::scenario::HumanLimits)). Nothing is random, and nothing looks into the
//! future of another road user: where it will be is taken from its path and present speed.

use strum::{IntoStaticStr, VariantArray};

mod course;
mod leader;
mod reacting;
#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
mod trigger;
mod world;

pub(super) use world::World;
pub use world::{DrivenTraffic, HitFromBehind, Reaction};

/// What the other road users do while the ego is driven.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "lowercase")]
pub enum TrafficMode {
    /// What was recorded, whatever the ego does.
    #[default]
    Recorded,
    /// What was recorded until the ego's deviation concerns them; then they react.
    Reactive,
}

nearmiss_record::named!(TrafficMode, "traffic");
