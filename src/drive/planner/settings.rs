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

nearmiss_record::named!(RuleMode, "rules");

nearmiss_record::fields! {
    /// Density of the samples.
    #[derive(Copy)]
    pub struct Sampling {
        "sampling" {
            /// Durations of manoeuvres, evenly spread up to the horizon.
            durations: usize = 4, Takes::Whole(1, 12);
            /// Final speeds for each duration.
            speeds: usize = 9, Takes::Whole(2, 30);
            /// Final offsets, an odd number: the path itself is one of them.
            offsets: usize = 9, Takes::Odd(3, 31);
            /// Times in which the offset is changed, evenly spread up to the horizon.
            changes: usize = 2, Takes::Whole(1, 6);
            /// The largest offset to either side, metres.
            widest: f64 = 3.5, Takes::Number(0.1, 20.0), "m";
            /// Refinements of all samples if no candidate is left.
            refinements: usize = 2, Takes::Whole(0, 3);
        }
    }
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

nearmiss_record::fields! {
    /// Weights of the terms of the cost; each term is a mean over the horizon.
    #[derive(Copy)]
    pub struct Weights {
        "weights" {
            /// Squared jerk along the path, (m/s³)².
            longitudinal_jerk: f64 = 0.02, Takes::Number(0.0, 1e6);
            /// Squared jerk across the path, (m/s³)².
            lateral_jerk: f64 = 0.05, Takes::Number(0.0, 1e6);
            /// Squared acceleration, along and across, (m/s²)².
            acceleration: f64 = 0.1, Takes::Number(0.0, 1e6);
            /// Squared difference from the wanted speed, (m/s)².
            speed: f64 = 1.0, Takes::Number(0.0, 1e6);
            /// Squared offset from the path, m².
            offset: f64 = 2.0, Takes::Number(0.0, 1e6);
            /// Closeness to predicted bodies, 0 to 1 squared.
            clearance: f64 = 40.0, Takes::Number(0.0, 1e6);
            /// What is missing to a stopping distance behind an obstacle that is in front, 0 to 1 squared.
            following: f64 = 60.0, Takes::Number(0.0, 1e6);
            /// Likelihood of contact times the squared speed at it, (m/s)².
            risk: f64 = 1.0, Takes::Number(0.0, 1e6);
        }
    }
}

/// Steps that a plan has at most: memory and time grow with them.
pub const MOST_STEPS: usize = 1000;

impl Default for Settings {
    fn default() -> Self {
        Self {
            vehicle: VehicleType::Bmw320i,
            horizon: 4.0,
            sampling: Sampling::default(),
            weights: Weights::default(),
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
