//! Planner settings: horizon, cost weights, and the durations, final speeds, positions and offsets that are sampled.

use nearmiss_scene::scenario::VehicleType;
use strum::{IntoStaticStr, VariantArray};

use super::pace::StopAhead;
use super::profile::{Profile, Start};
use super::{Limits, Polynomial, ReferenceTrack, Traffic};

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

/// The three ranges of one level of refinement.
#[derive(Debug, Clone, Copy)]
pub(super) struct Level {
    durations: usize,
    speeds: usize,
    offsets: usize,
    changes: usize,
}

/// The shortest manoeuvre, seconds.
const MIN_DURATION: f64 = 0.5;

/// The shortest change of the offset, seconds.
const SHORTEST_CHANGE: f64 = 1.5;

/// Durations of stops at a line, as shares of that with constant braking, and the longest one, seconds.
const STOPPING: [f64; 3] = [0.95, 1.15, 1.4];

const MAX_DURATION: f64 = 20.0;

/// A stop over less than this (m) or from a lower speed (m/s) is one of the usual profiles.
const NO_WAY: f64 = 0.3;

const CREEPING: f64 = 0.3;

/// Of a polynomial's largest acceleration, its mean is about this share.
const MEAN: f64 = 0.65;

/// Speeds further above both the present and the wanted one are not sampled, m/s.
pub(super) const MAX_SPEED_GAIN: f64 = 6.0;

/// Distance that is kept behind an obstacle that is followed, at standstill (m) and by speed (s).
const STANDING_GAP: f64 = 3.0;

const TIME_GAP: f64 = 0.8;

/// An obstacle farther beside the path than this and half of its width is not followed, metres.
const FOLLOWED_OFFSET: f64 = 1.2;

impl Level {
    pub fn new(sampling: &Sampling, refinement: usize) -> Self {
        let odd = |n: usize| n | 1;
        Self {
            durations: sampling.durations * (refinement + 2) / 2,
            speeds: sampling.speeds * (refinement + 2) / 2,
            offsets: odd(sampling.offsets * (refinement + 2) / 2),
            changes: sampling.changes * (refinement + 2) / 2,
        }
    }

    /// Durations in seconds, the last one the horizon.
    pub fn durations(self, horizon: f64) -> impl Iterator<Item = f64> {
        let count = self.durations.max(1);
        (1..=count).map(move |i| (horizon * i as f64 / count as f64).max(MIN_DURATION))
    }

    /// Seconds in which the offset is changed: no vehicle steers as fast as it brakes.
    pub fn changes(self, horizon: f64) -> impl Iterator<Item = f64> {
        (1..=self.changes)
            .map(move |i| (horizon * i as f64 / self.changes as f64).max(SHORTEST_CHANGE))
    }

    /// Final offsets (m): to both sides of the path, closer together near it, and the present one.
    pub fn offsets(self, widest: f64, present: f64) -> impl Iterator<Item = f64> {
        let half = (self.offsets / 2).max(1) as i64;
        let spread = (-half..=half).map(move |i| {
            let share = i as f64 / half as f64;
            widest * share * share.abs().sqrt()
        });
        spread.chain(Some(present).filter(|d| d.abs() > 1e-3))
    }
}

/// Input of sampling.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sampler<'a> {
    pub settings: &'a Settings,
    pub limits: &'a Limits,
    pub guide: &'a ReferenceTrack,
    pub traffic: &'a Traffic,
    pub wanted: f64,
    pub stop: Option<StopAhead>,
    pub dt: f64,
}

impl Sampler<'_> {
    /// Adds the profiles of a level, from arc length, speed and acceleration `from`.
    pub fn profiles(&self, level: Level, from: [f64; 3], profiles: &mut Vec<Profile>) {
        for duration in level.durations(self.settings.horizon) {
            let mut speed = |v: f64| {
                let along = Polynomial::quartic(from, [v, 0.0], duration);
                profiles.push(Profile::new(along, duration, 0.0));
            };
            let (least, most) = self.reachable(from[1], duration);
            let count = level.speeds.max(2);
            for i in 0..count {
                speed(least + (most - least) * i as f64 / (count - 1) as f64);
            }
            let wanted = self.wanted.clamp(least, most);
            for known in [wanted, from[1]] {
                if known > least && known < most {
                    speed(known);
                }
            }
            profiles.extend(self.following(from, duration));
        }
        profiles.extend(self.stopping(from).into_iter().flatten());
    }

    /// The slowest and fastest speed that can be reached, m/s.
    fn reachable(&self, now: f64, duration: f64) -> (f64, f64) {
        let gain = MEAN * duration;
        let fastest = now + gain * self.limits.forward(now);
        let most = fastest
            .min(now.max(self.wanted) + MAX_SPEED_GAIN)
            .min(self.limits.speed);
        let least = (now - gain * self.limits.acceleration).max(0.0);
        // An ego that starts faster than the vehicle can go has to slow down, as far as it can.
        (least.min(most), most)
    }

    /// Ending where the rules ask to stand, with constant and with milder braking; nothing for one that stands.
    fn stopping(&self, from: [f64; 3]) -> Option<[Profile; 3]> {
        let stop = self.stop?;
        let distance = stop.s - from[0];
        if distance < NO_WAY || from[1] < CREEPING {
            return None;
        }
        let constant = 2.0 * distance / from[1];
        Some(STOPPING.map(|share| {
            let duration = (constant * share).clamp(MIN_DURATION, MAX_DURATION);
            let along = Polynomial::quintic(from, [stop.s, 0.0, 0.0], duration);
            Profile::new(along, duration, 0.0)
        }))
    }

    /// Ending behind an obstacle that is next on the path then, as fast as it is.
    fn following(&self, from: [f64; 3], duration: f64) -> Option<Profile> {
        let path = &self.guide.path;
        let step = (duration / self.dt).round() as usize;
        let mut next: Option<(f64, f64)> = None;
        for other in self.traffic.at(step) {
            let at = nearmiss_base::geometry::Point::new(other.x, other.y);
            let Ok(on) = path.project(&at) else {
                continue;
            };
            if (on.s - from[0] - from[1] * duration).abs() > REACH
                || on.d.abs() > FOLLOWED_OFFSET + other.half_width
                || on.s <= from[0]
            {
                continue;
            }
            let point = path.at(on.s);
            let along = other.cos * point.heading.cos() + other.sin * point.heading.sin();
            let speed = (other.velocity * along).max(0.0);
            let length = other.half_length * along.abs()
                + other.half_width * (1.0 - along * along).max(0.0).sqrt();
            let rear = on.s - length;
            if next.is_none_or(|(s, _)| rear < s) {
                next = Some((rear, speed));
            }
        }
        let (rear, speed) = next?;
        let front = self.limits.rear_to_centre + self.limits.length / 2.0;
        let gap = front + STANDING_GAP + TIME_GAP * speed;
        let end = (rear - gap).max(from[0]);
        let along = Polynomial::quintic(from, [end, speed, 0.0], duration);
        Some(Profile::new(along, duration, 0.0))
    }
}

/// Others are looked for this far from where the horizon ends, metres.
const REACH: f64 = 80.0;

/// The start in the coordinates of a path from the state there.
pub(super) fn start(by_length: [f64; 3], along: [f64; 3]) -> Start {
    let ([d, d1, d2], [_, v, a]) = (by_length, along);
    Start {
        by_time: [d, d1 * v, d2 * v * v + d1 * a],
        by_length,
    }
}
