//! Planner settings: horizon, samples, cost weights.

use strum::{IntoStaticStr, VariantArray};

use super::Limits;
use nearmiss_scene::scenario::VehicleType;

/// Planner settings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// The vehicle that is planned for.
    pub vehicle: VehicleType,
    /// How far ahead, seconds.
    pub horizon: f64,
    /// What is sampled.
    pub sampling: Sampling,
    /// What the costs weigh.
    pub weights: Weights,
    /// Share of the vehicle's forces and steering that plans use, 0 to 1.
    pub share: f64,
    /// Below this speed (m/s) the offset is planned over the length of the way instead of time.
    pub low_speed: f64,
    /// What is kept free around predicted bodies, metres.
    pub margin: f64,
    /// Deceleration that stopping distances are worked out with, m/s².
    pub braking: f64,
    /// Reaction time that stopping distances are worked out with, seconds.
    pub reaction: f64,
    /// Whether lights, signs and right of way are obeyed.
    pub rules: RuleMode,
}

/// What the planner makes of the rules of the road.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "lowercase")]
pub enum RuleMode {
    /// It obeys lights, stop signs, right of way and speed limits, as far as the map has them.
    #[default]
    Obey,
    /// It does not know them.
    Off,
}

nearmiss_record::named!(RuleMode);

/// Density of the samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sampling {
    /// Durations of manoeuvres, evenly spread up to the horizon.
    pub durations: usize,
    /// Final speeds for each duration.
    pub speeds: usize,
    /// Final offsets, an odd number: the path itself is one of them.
    pub offsets: usize,
    /// Times in which the offset is changed, evenly spread up to the horizon.
    pub changes: usize,
    /// The largest offset to either side, metres.
    pub widest: f64,
    /// Refinements of all samples if no candidate is left.
    pub refinements: usize,
}

impl Sampling {
    /// Fewer final speeds and offsets, and no refinement where no candidate is left: a fraction of the time, for drives
    /// that only select what is driven with all samples.
    #[must_use]
    pub fn coarse(self) -> Self {
        Self {
            speeds: self.speeds.div_ceil(2),
            offsets: self.offsets.div_ceil(2),
            refinements: 0,
            ..self
        }
    }
}

/// Weights of the terms of the cost; each term is a mean over the horizon.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Weights {
    /// Squared jerk along the path, (m/s³)².
    pub longitudinal_jerk: f64,
    /// Squared jerk across the path, (m/s³)².
    pub lateral_jerk: f64,
    /// Squared acceleration, along and across, (m/s²)².
    pub acceleration: f64,
    /// Squared difference from the wanted speed, (m/s)².
    pub speed: f64,
    /// Squared offset from the path, m².
    pub offset: f64,
    /// Closeness to predicted bodies, 0 to 1 squared.
    pub clearance: f64,
    /// What is missing to a stopping distance behind an obstacle that is in front, 0 to 1 squared.
    pub following: f64,
    /// Likelihood of contact times the squared speed at it, (m/s)².
    pub risk: f64,
}

/// Steps that a plan has at most: memory and time grow with them.
pub const MOST_STEPS: usize = 1000;

impl Default for Settings {
    fn default() -> Self {
        Self {
            vehicle: VehicleType::Bmw320i,
            horizon: 4.0,
            sampling: Sampling {
                durations: 4,
                speeds: 9,
                offsets: 9,
                changes: 2,
                widest: 3.5,
                refinements: 2,
            },
            weights: Weights {
                longitudinal_jerk: 0.02,
                lateral_jerk: 0.05,
                acceleration: 0.1,
                speed: 1.0,
                offset: 2.0,
                clearance: 40.0,
                following: 60.0,
                risk: 1.0,
            },
            share: 0.95,
            low_speed: 4.0,
            margin: 0.1,
            braking: 6.0,
            reaction: 0.5,
            rules: RuleMode::Obey,
        }
    }
}

impl Settings {
    /// The limits that plans keep.
    #[must_use]
    pub fn limits(&self) -> Limits {
        Limits::for_vehicle(self.vehicle).scaled(self.share)
    }

    /// The way (m) in which one stops from `velocity` (m/s).
    #[must_use]
    pub fn stopping(&self, velocity: f64) -> f64 {
        velocity * (self.reaction + velocity / (2.0 * self.braking))
    }

    /// Steps of `dt` seconds in the horizon, at least one and at most [`MOST_STEPS`].
    #[must_use]
    pub fn steps(&self, dt: f64) -> usize {
        // NaN is not one step.
        ((self.horizon / dt).round() as usize).clamp(1, MOST_STEPS)
    }

    /// Whether the horizon has no more steps of `dt` seconds than a plan can have.
    #[must_use]
    pub fn fits(&self, dt: f64) -> bool {
        (self.horizon / dt).round() <= MOST_STEPS as f64
    }
}
