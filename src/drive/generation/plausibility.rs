//! How plausible an attack is: its motion held against those that were recorded.
//!
//! Four quantities of each step count, of moving bodies: acceleration, jerk, yaw rate and the offset from the middle of
//! the lane. Recordings give a histogram of each; its density, smoothed over neighbouring bins, is the likelihood of a
//! step. The quantities are taken as independent of each other, and steps of each other: good enough to compare motions
//! of the same scenario, no probability of the attack.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use strum::{IntoStaticStr, VariantArray};

use nearmiss_base::geometry::angle_between;
use nearmiss_scene::scenario::{LaneletNetwork, Motion, ObstacleRole, Scenario};

/// A quantity of a motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "snake_case")]
pub enum MotionQuantity {
    /// Along the heading, m/s².
    Acceleration,
    /// Change of the acceleration, m/s³.
    Jerk,
    /// Change of the heading, rad/s.
    YawRate,
    /// Offset of the body's centre from the middle of the lanelet that it is on, to the left, metres.
    LaneOffset,
}

nearmiss_record::named!(MotionQuantity);

impl MotionQuantity {
    /// Its unit.
    #[must_use]
    pub fn unit(self) -> &'static str {
        match self {
            Self::Acceleration => "m/s²",
            Self::Jerk => "m/s³",
            Self::YawRate => "rad/s",
            Self::LaneOffset => "m",
        }
    }

    /// Width of a bin, in its unit, and how many bins there are to either side of 0. What is farther out is in the
    /// last one.
    fn bins(self) -> (f64, i32) {
        match self {
            Self::Acceleration => (0.1, 120),
            Self::Jerk => (0.5, 80),
            Self::YawRate => (0.01, 200),
            Self::LaneOffset => (0.1, 40),
        }
    }
}

/// Counts by bin; bin 0 is around 0.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Histogram(BTreeMap<i32, u64>);

impl Histogram {
    fn add(&mut self, quantity: MotionQuantity, value: f64) {
        *self.0.entry(bin(quantity, value)).or_default() += 1;
    }

    fn merge(&mut self, other: &Self) {
        for (bin, count) in &other.0 {
            *self.0.entry(*bin).or_default() += count;
        }
    }

    fn total(&self) -> u64 {
        self.0.values().sum()
    }
}

fn bin(quantity: MotionQuantity, value: f64) -> i32 {
    let (width, most) = quantity.bins();
    ((value / width).round() as i32).clamp(-most, most)
}

/// Samples of all quantities, a step each.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize, schemars::JsonSchema)]
pub struct MotionSamples {
    /// In the order of [`MotionQuantity::ALL`].
    histograms: [Histogram; 4],
}

/// Slower steps are those of bodies that stand, m/s: they would hide all others.
const STANDING: f64 = 0.5;

impl MotionSamples {
    /// Those of the recorded motions of all dynamic obstacles.
    #[must_use]
    pub fn recorded(scenario: &Scenario) -> Self {
        let mut samples = Self::default();
        let moving = scenario.obstacles.iter();
        for obstacle in moving.filter(|o| o.role == ObstacleRole::Dynamic) {
            let motions: Vec<(i64, Motion)> =
                obstacle.track().iter().map(|(s, m)| (s, *m)).collect();
            samples.add(&motions, &scenario.network, scenario.dt());
        }
        samples
    }

    /// Those of a motion, with `dt` seconds between two steps.
    #[must_use]
    pub fn of_motion(motions: &[(i64, Motion)], network: &LaneletNetwork, dt: f64) -> Self {
        let mut samples = Self::default();
        samples.add(motions, network, dt);
        samples
    }

    fn add(&mut self, motions: &[(i64, Motion)], network: &LaneletNetwork, dt: f64) {
        for (quantity, value) in values(motions, Some(network), dt) {
            self.histograms[quantity as usize].add(quantity, value);
        }
    }

    /// Adds those of another one.
    pub fn merge(&mut self, other: &Self) {
        for (own, other) in self.histograms.iter_mut().zip(&other.histograms) {
            own.merge(other);
        }
    }

    /// Whether nothing moves.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.histograms.iter().all(|h| h.0.is_empty())
    }

    /// The Wasserstein distance (of order 1) of a quantity to that of others, in its unit: the area between the two
    /// cumulative distributions. Nothing where one has no samples.
    ///
    /// Source: Vallender, Calculation of the Wasserstein distance between probability distributions on the line, 1974.
    #[must_use]
    pub fn wasserstein(&self, other: &Self, quantity: MotionQuantity) -> Option<f64> {
        let (a, b) = (
            &self.histograms[quantity as usize],
            &other.histograms[quantity as usize],
        );
        let (all_a, all_b) = (a.total(), b.total());
        if all_a == 0 || all_b == 0 {
            return None;
        }
        let (width, most) = quantity.bins();
        let share = |of: &Histogram, bin: i32, all: u64| {
            of.0.get(&bin).copied().unwrap_or(0) as f64 / all as f64
        };
        let (mut apart, mut area) = (0.0_f64, 0.0);
        for bin in -most..=most {
            apart += share(a, bin, all_a) - share(b, bin, all_b);
            area += apart.abs() * width;
        }
        Some(area)
    }
}

/// The values of each step that moves; offsets where a network is given.
fn values(
    motions: &[(i64, Motion)],
    network: Option<&LaneletNetwork>,
    dt: f64,
) -> Vec<(MotionQuantity, f64)> {
    let mut found = Vec::new();
    let mut before: Option<f64> = None;
    for pair in motions.windows(2) {
        let [(step, from), (next, to)] = pair else {
            continue;
        };
        let moves = f64::midpoint(from.velocity, to.velocity).abs() >= STANDING;
        if step + 1 != *next || !moves {
            before = None;
            continue;
        }
        let acceleration = (to.velocity - from.velocity) / dt;
        found.push((MotionQuantity::Acceleration, acceleration));
        if let Some(before) = before {
            found.push((MotionQuantity::Jerk, (acceleration - before) / dt));
        }
        before = Some(acceleration);
        let turned = angle_between(from.pose.heading, to.pose.heading);
        found.push((MotionQuantity::YawRate, turned / dt));
        if let Some(offset) = network.and_then(|network| network.lane_offset(&to.pose)) {
            found.push((MotionQuantity::LaneOffset, offset));
        }
    }
    found
}

/// Densities of recorded motions, to hold others against.
#[derive(Debug, Clone)]
pub struct RecordedMotions {
    samples: MotionSamples,
    /// Log density by bin, per unit of the quantity, from the lowest bin on.
    densities: [Vec<f64>; 4],
    /// Their means over the recorded steps.
    usual: [f64; 4],
    dt: f64,
}

/// What is spread evenly over all bins, for what no recording shows.
const EVENLY: f64 = 0.01;

/// Neighbours over which counts are smoothed, in bins: the standard deviation of a Gaussian.
const SMOOTHED: f64 = 2.0;

impl RecordedMotions {
    /// Those of a scenario; nothing where no obstacle moves in it.
    #[must_use]
    pub fn of_scenario(scenario: &Scenario) -> Option<Self> {
        let samples = MotionSamples::recorded(scenario);
        if samples.is_empty() {
            return None;
        }
        let densities = MotionQuantity::ALL.map(|q| density(q, &samples.histograms[q as usize]));
        let dt = scenario.dt();
        let mean = |quantity: MotionQuantity| {
            let histogram = &samples.histograms[quantity as usize];
            let (_, most) = quantity.bins();
            let all = histogram.total().max(1) as f64;
            let density = &densities[quantity as usize];
            let sum: f64 = { histogram.0.iter() }
                .map(|(bin, count)| *count as f64 * density[(bin + most) as usize])
                .sum();
            sum / all
        };
        let usual = MotionQuantity::ALL.map(mean);
        Some(Self {
            samples,
            densities,
            usual,
            dt,
        })
    }

    /// The recorded samples.
    #[must_use]
    pub fn samples(&self) -> &MotionSamples {
        &self.samples
    }

    /// How far acceleration, jerk and yaw rate of a motion are below those of recorded ones, nats per step and quantity;
    /// 0 where they are not. Quick, for searches over thousands of motions.
    #[must_use]
    pub fn deficit(&self, motions: &[(i64, Motion)]) -> f64 {
        let mut sums = [(0.0, 0_usize); 4];
        for (quantity, value) in values(motions, None, self.dt) {
            let sum = &mut sums[quantity as usize];
            sum.0 += self.log_density(quantity, value);
            sum.1 += 1;
        }
        let below = MotionQuantity::ALL[..3].iter().map(|quantity| {
            let (sum, n) = sums[*quantity as usize];
            match n {
                0 => 0.0,
                n => self.usual[*quantity as usize] - sum / n as f64,
            }
        });
        (below.sum::<f64>() / 3.0).max(0.0)
    }

    fn log_density(&self, quantity: MotionQuantity, value: f64) -> f64 {
        let (_, most) = quantity.bins();
        self.densities[quantity as usize][(bin(quantity, value) + most) as usize]
    }

    /// How plausible motions are: the steps of all of them count alike.
    #[must_use]
    pub fn plausibility<'m>(
        &self,
        all: impl IntoIterator<Item = &'m [(i64, Motion)]>,
        network: &LaneletNetwork,
    ) -> Plausibility {
        let mut sums = [(0.0, 0_usize); 4];
        let mut samples = MotionSamples::default();
        let values = |motions| values(motions, Some(network), self.dt);
        for (quantity, value) in all.into_iter().flat_map(values) {
            let sum = &mut sums[quantity as usize];
            sum.0 += self.log_density(quantity, value);
            sum.1 += 1;
            samples.histograms[quantity as usize].add(quantity, value);
        }
        let mean = |(sum, n): &(f64, usize)| if *n == 0 { 0.0 } else { sum / *n as f64 };
        Plausibility {
            log_likelihood: sums.iter().map(mean).sum::<f64>() / self.dt,
            recorded: self.usual.iter().sum::<f64>() / self.dt,
            samples,
        }
    }
}

/// The log density of each bin.
fn density(quantity: MotionQuantity, histogram: &Histogram) -> Vec<f64> {
    let (width, most) = quantity.bins();
    let bins = 2 * most + 1;
    let reach = (3.0 * SMOOTHED).ceil() as i32;
    let kernel: Vec<f64> = (-reach..=reach)
        .map(|i| (-0.5 * (f64::from(i) / SMOOTHED).powi(2)).exp())
        .collect();
    let whole: f64 = kernel.iter().sum();
    let all = histogram.total().max(1) as f64;
    let mut shares = vec![EVENLY / f64::from(bins); bins as usize];
    for (bin, count) in &histogram.0 {
        for (i, weight) in (-reach..=reach).zip(&kernel) {
            let to = (bin + i).clamp(-most, most) + most;
            shares[to as usize] += (1.0 - EVENLY) * *count as f64 / all * weight / whole;
        }
    }
    shares.iter().map(|share| (share / width).ln()).collect()
}

/// How plausible motions are beside the recorded ones of their scenario.
#[derive(Debug, Clone, PartialEq)]
pub struct Plausibility {
    /// Log-likelihood per second of its steps that move, nats: the mean of a step, by the steps of a second.
    pub log_likelihood: f64,
    /// The same of the recorded motions, on average.
    pub recorded: f64,
    /// Its samples.
    pub samples: MotionSamples,
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use nearmiss_base::geometry::Pose;

    fn moving(speeds: &[f64]) -> Vec<(i64, Motion)> {
        let mut x = 0.0;
        let motions = speeds.iter().enumerate().map(|(step, speed)| {
            x += speed * 0.1;
            let motion = Motion {
                pose: Pose::new(x, 0.0, 0.0),
                velocity: *speed,
                acceleration: 0.0,
            };
            (step as i64, motion)
        });
        motions.collect()
    }

    fn samples(speeds: &[f64]) -> MotionSamples {
        MotionSamples::of_motion(&moving(speeds), &LaneletNetwork::default(), 0.1)
    }

    #[test]
    fn the_distance_of_two_constant_accelerations_is_their_difference() {
        let one: Vec<f64> = (0..20).map(|k| 10.0 + 0.1 * f64::from(k)).collect();
        let three: Vec<f64> = (0..20).map(|k| 10.0 + 0.3 * f64::from(k)).collect();
        let (one, three) = (samples(&one), samples(&three));
        let apart = one.wasserstein(&three, MotionQuantity::Acceleration);
        assert!((apart.unwrap() - 2.0).abs() < 1e-9, "{apart:?}");
        assert_eq!(one.wasserstein(&one, MotionQuantity::Jerk), Some(0.0));
        // There is no lane here.
        assert_eq!(one.wasserstein(&three, MotionQuantity::LaneOffset), None);
    }

    #[test]
    fn who_stands_counts_for_nothing() {
        assert!(samples(&[0.0; 9]).is_empty());
        assert!(!samples(&[3.0; 9]).is_empty());
    }
}
