//! What the search may try: somebody doing some manoeuvre, with the numbers that seem to work.

use super::attacker::Candidate;
use super::{Stage, manoeuvre};
use crate::scenario::Obstacle;
use crate::verdict::{Manoeuvre, ManoeuvreKind};

/// Numbers of a manoeuvre: start (s), duration (s), gap (m), speed (m/s).
pub type Numbers = [f64; 4];

/// One obstacle doing one kind of manoeuvre, with a normal distribution over its numbers.
#[derive(Debug, Clone)]
pub struct Arm {
    /// Whose.
    pub obstacle: i64,
    /// What.
    pub kind: ManoeuvreKind,
    /// Which of its ways that cross the ego's.
    pub way: usize,
    mean: Numbers,
    spread: Numbers,
    lowest: Numbers,
    highest: Numbers,
    /// The best cost so far.
    pub best: f64,
}

/// No manoeuvre takes less, seconds.
const SHORTEST: f64 = 0.8;

/// A change of the distribution keeps this share of the old one.
const KEEP: f64 = 0.2;

/// Spreads do not shrink below this share of the first ones.
const LEAST_SPREAD: f64 = 0.04;

impl Arm {
    /// What a candidate can try, all of it.
    #[must_use]
    pub fn all(stage: &Stage<'_>, candidate: &Candidate) -> Vec<Self> {
        let Some(obstacle) = stage.scenario.obstacle(candidate.obstacle) else {
            return Vec::new();
        };
        let dt = stage.dt();
        let track = obstacle.track().steps();
        let first = track.start.max(*stage.steps.start()) as f64 * dt;
        let last = (track.end - 2).min(*stage.steps.end()) as f64 * dt;
        let met = candidate.step as f64 * dt;
        let ego = stage.ego_at(candidate.step).map_or(0.0, |m| m.velocity);
        let standing = obstacle
            .motion_at(candidate.step)
            .is_some_and(|m| m.velocity < 1.0);
        let arm = |kind, way, mean: Numbers, spread, low: Numbers, high: Numbers| Self {
            obstacle: candidate.obstacle,
            kind,
            way,
            mean,
            spread,
            lowest: [first, SHORTEST, low[2], low[3]],
            highest: [(last - SHORTEST).max(first), high[1], high[2], high[3]],
            best: f64::INFINITY,
        };
        use ManoeuvreKind as Kind;
        let most = ego + 5.0;
        let beside = |kind, gap: f64, low: f64, high: f64| {
            arm(
                kind,
                0,
                [met - 2.5, 2.5, gap, ego * 0.8],
                [2.0, 0.8, (high - low) / 3.0, 3.0],
                [0.0, 0.0, low, 0.0],
                [0.0, 5.0, high, most],
            )
        };
        let cross = |kind, way, speed: f64| {
            arm(
                kind,
                way,
                [met - 2.5, 2.5, 4.0, speed],
                [1.5, 0.8, 5.0, 3.0],
                [0.0, 0.0, 0.0, 1.0],
                [0.0, 6.0, 20.0, 15.0],
            )
        };
        let mut arms = vec![
            beside(Kind::CutIn, 0.5, 0.0, 5.0),
            beside(Kind::Drift, -0.5, -1.5, 0.8),
            beside(Kind::DoorToDoor, 0.1, 0.0, 0.8),
            arm(
                Kind::HardBrake,
                0,
                [met - 1.5, 1.6, 0.0, 0.5],
                [1.5, 0.6, 0.0, 1.5],
                [0.0, 0.0, 0.0, 0.0],
                [0.0, 3.0, 0.0, 5.0],
            ),
            cross(Kind::RunTheLight, 0, 8.0),
            cross(Kind::LateTurn, 0, 6.0),
            cross(Kind::LateTurn, 1, 6.0),
        ];
        if standing {
            arms.push(cross(Kind::PullOut, 0, 5.0));
        }
        arms.retain(|arm| arm.is_possible(stage, obstacle));
        arms
    }

    /// Whether it can be done at all, at its usual time or some time around it.
    fn is_possible(&self, stage: &Stage<'_>, obstacle: &Obstacle) -> bool {
        let around = [0.0, -1.0, 1.0, -2.0, 2.0];
        around.into_iter().any(|off| {
            let mut numbers = self.mean;
            numbers[0] += off * self.spread[0];
            let manoeuvre = self.manoeuvre(&mut numbers);
            manoeuvre::plan(stage, obstacle, &manoeuvre, self.way).is_ok()
        })
    }

    /// A manoeuvre from the distribution, and its numbers. A gap below 0 is none, as is one that the kind does not have.
    pub fn sample(&self, random: &mut fastrand::Rng) -> (Manoeuvre, Numbers) {
        let mut x = self.mean;
        for (x, spread) in x.iter_mut().zip(self.spread) {
            *x += spread * normal(random);
        }
        let manoeuvre = self.manoeuvre(&mut x);
        (manoeuvre, x)
    }

    /// The manoeuvre with these numbers, which are taken into their bounds.
    fn manoeuvre(&self, x: &mut Numbers) -> Manoeuvre {
        for (i, x) in x.iter_mut().enumerate() {
            *x = x.clamp(self.lowest[i], self.highest[i]);
        }
        let gap = (self.kind != ManoeuvreKind::HardBrake && x[2] >= 0.0).then_some(x[2]);
        Manoeuvre {
            kind: self.kind,
            start: x[0],
            duration: x[1],
            gap,
            speed: Some(x[3]),
        }
    }

    /// Moves the distribution to the best ones of those that were tried.
    pub fn learn(&mut self, best: &[Numbers]) {
        if best.is_empty() {
            return;
        }
        let count = best.len() as f64;
        for i in 0..4 {
            let mean = best.iter().map(|x| x[i]).sum::<f64>() / count;
            let spread = best.iter().map(|x| (x[i] - mean).powi(2)).sum::<f64>() / count;
            let first = self.highest[i] - self.lowest[i];
            self.mean[i] = KEEP * self.mean[i] + (1.0 - KEEP) * mean;
            let spread = KEEP * self.spread[i] + (1.0 - KEEP) * spread.sqrt();
            self.spread[i] = spread.max(LEAST_SPREAD * first.min(3.0));
        }
    }
}

/// A standard normal number (Box and Muller 1958).
fn normal(random: &mut fastrand::Rng) -> f64 {
    let (u, v) = (1.0 - random.f64(), random.f64());
    (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos()
}
