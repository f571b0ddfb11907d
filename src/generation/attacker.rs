//! Ranks obstacles by how little their motion must change to reach the ego.

use super::{AttackContext, Capability};
use crate::scenario::{Obstacle, ObstacleRole};

/// An obstacle that could attack, and how much it would have to change.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate {
    /// Its id.
    pub obstacle: i64,
    /// The acceleration that it needs, in any direction, to be where the ego is, m/s²: constant for at most
    /// [`LOOKAHEAD`] seconds, the least one over all steps.
    pub acceleration: f64,
    /// The step at which the ego is reached so.
    pub step: i64,
    /// How far it is from the ego there while nothing is changed, metres, between the bodies.
    pub distance: f64,
    /// Whether it is within [`NEAR`] metres in front of the ego or beside it there, as the paper asks.
    pub near: bool,
    /// Whether it is behind the ego at every step.
    pub behind: bool,
}

/// Longer than this no attacker is taken to prepare, seconds.
pub const LOOKAHEAD: f64 = 3.0;

/// An attacker is in front or to the side within this distance in the paper, metres.
pub const NEAR: f64 = 30.0;

/// No obstacle attacks before it has been seen for so long, seconds.
const SEEN: f64 = 0.5;

/// An ego slower than this cannot be tested, m/s.
const MOVING: f64 = 2.0;

/// The obstacles that could attack, the least change first; ties in the file's order.
///
/// Steps at which the ego hardly moves do not count. Left out is what does not move by itself. An obstacle that is
/// only ever behind the ego comes last: a collision from behind tests the other one, and it would have to overtake
/// first.
#[must_use]
pub fn rank(stage: &AttackContext<'_>) -> Vec<Candidate> {
    let mut found: Vec<Candidate> = stage
        .scenario
        .obstacles
        .iter()
        .filter(|o| {
            o.role == ObstacleRole::Dynamic && Capability::for_obstacle(o, stage.style).is_some()
        })
        .filter_map(|obstacle| candidate(stage, obstacle))
        .collect();
    found.sort_by(|a, b| {
        let order = a.behind.cmp(&b.behind);
        order.then(a.acceleration.total_cmp(&b.acceleration))
    });
    found
}

fn candidate(stage: &AttackContext<'_>, obstacle: &Obstacle) -> Option<Candidate> {
    let first = obstacle.track().steps().start;
    let mut best: Option<Candidate> = None;
    for (step, ego) in stage.ego.iter() {
        let Some(other) = obstacle.placed_at(step) else {
            continue;
        };
        let time = (step - first.max(*stage.steps.start())) as f64 * stage.dt();
        if time < SEEN || ego.velocity < MOVING {
            continue;
        }
        let own = stage.footprint.at(ego.pose);
        // An obstacle that has its middle behind the ego's rear is behind.
        let ahead = ego.pose.to_local(&other.pose.position).x;
        let behind = ahead < -stage.footprint.shape().size().0 / 2.0;
        let distance = own.distance(&other);
        let acceleration = 2.0 * distance / time.min(LOOKAHEAD).powi(2);
        let better = |b: Candidate| (behind, acceleration) < (b.behind, b.acceleration);
        if best.is_none_or(better) {
            best = Some(Candidate {
                obstacle: obstacle.id,
                acceleration,
                step,
                distance,
                near: distance <= NEAR && !behind,
                behind,
            });
        }
    }
    best
}
