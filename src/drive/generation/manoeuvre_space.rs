//! The search space: an obstacle, a manoeuvre, and promising parameters.

use super::attacker::Candidate;
use super::{AttackContext, manoeuvre};
use nearmiss_scene::scenario::Obstacle;
use nearmiss_scene::verdict::{Manoeuvre, ManoeuvreKind};

/// Numbers of a manoeuvre: start (s), duration (s), gap (m), speed (m/s).
pub type Numbers = [f64; 4];

/// One obstacle and one kind of manoeuvre, with a normal distribution over its parameters.
#[derive(Debug, Clone)]
pub struct ManoeuvreSpace {
    /// The obstacle's id.
    pub obstacle: i64,
    /// The kind of manoeuvre.
    pub kind: ManoeuvreKind,
    /// Which of its ways that cross the ego's.
    pub way: usize,
    mean: Numbers,
    spread: Numbers,
    lowest: Numbers,
    highest: Numbers,
}

/// No manoeuvre takes less, seconds.
const SHORTEST: f64 = 0.8;

impl ManoeuvreSpace {
    /// What a candidate can try, all of it.
    #[must_use]
    pub fn all(stage: &AttackContext<'_>, candidate: &Candidate) -> Vec<Self> {
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
            // An ego that brakes is farther back than where it would be without the attack.
            beside(Kind::CutIn, 0.0, -5.0, 5.0),
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
    fn is_possible(&self, stage: &AttackContext<'_>, obstacle: &Obstacle) -> bool {
        let around = [0.0, -1.0, 1.0, -2.0, 2.0];
        around.into_iter().any(|off| {
            let mut numbers = self.mean;
            numbers[0] += off * self.spread[0];
            let manoeuvre = self.manoeuvre(&mut numbers);
            manoeuvre::plan(stage, obstacle, &manoeuvre, self.way).is_ok()
        })
    }

    /// Numbers from the distribution.
    pub fn sample(&self, random: &mut fastrand::Rng) -> Numbers {
        self.around(&self.mean, 1.0, random)
    }

    /// Numbers around others, with a share of the spread.
    pub fn around(&self, mean: &Numbers, share: f64, random: &mut fastrand::Rng) -> Numbers {
        let mut x = *mean;
        for (x, spread) in x.iter_mut().zip(self.spread) {
            *x += share * spread * normal(random);
        }
        x
    }

    /// How far numbers are from others, in spreads.
    pub fn apart(&self, x: &Numbers, y: &Numbers) -> f64 {
        let parts = x.iter().zip(y).zip(self.spread);
        let apart = parts.filter(|(_, spread)| *spread > 0.0);
        let squares = apart.map(|((x, y), spread)| ((x - y) / spread).powi(2));
        squares.sum::<f64>().sqrt()
    }

    /// The manoeuvre with these numbers, which are taken into their bounds.
    /// A drift with a gap below 0 has none, nor has a kind that does not know one.
    pub fn manoeuvre(&self, x: &mut Numbers) -> Manoeuvre {
        for (i, x) in x.iter_mut().enumerate() {
            *x = x.clamp(self.lowest[i], self.highest[i]);
        }
        let has_gap = match self.kind {
            ManoeuvreKind::HardBrake => false,
            ManoeuvreKind::Drift => x[2] >= 0.0,
            _ => true,
        };
        let gap = has_gap.then_some(x[2]);
        Manoeuvre {
            kind: self.kind,
            start: x[0],
            duration: x[1],
            gap,
            speed: Some(x[3]),
        }
    }
}

/// A standard normal number (Box and Muller 1958).
fn normal(random: &mut fastrand::Rng) -> f64 {
    let (u, v) = (1.0 - random.f64(), random.f64());
    (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos()
}
