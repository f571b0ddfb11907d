//! Ranks obstacles by how little their motion must change to reach the ego.

use super::{AttackContext, Capability};
use nearmiss_base::geometry::Point;
use nearmiss_scene::scenario::{Obstacle, ObstacleRole};

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
    /// Whether it gets there without reversing: one that the ego is behind of can only fall back, by no more than it has
    /// driven.
    pub reaches: bool,
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
/// only ever behind the ego comes late: a collision from behind tests the other one, and it would have to overtake
/// first. One that would have to reverse comes last.
#[must_use]
pub fn rank(stage: &AttackContext<'_>) -> Vec<Candidate> {
    let mut found: Vec<Candidate> = stage
        .scenario
        .obstacles
        .iter()
        .filter(|obstacle| moves(stage, obstacle))
        .filter_map(|obstacle| candidate(stage, obstacle))
        .collect();
    found.sort_by(|a, b| {
        let order = (!a.reaches, a.behind).cmp(&(!b.reaches, b.behind));
        order.then(a.acceleration.total_cmp(&b.acceleration))
    });
    found
}

/// Why none of some obstacles, or of all where none is named, can reach the ego; `None` where one can.
#[must_use]
pub fn why_none(stage: &AttackContext<'_>, among: &[i64]) -> Option<&'static str> {
    if stage.ego.iter().all(|(_, ego)| ego.velocity < MOVING) {
        return Some("the ego drives slower than 2 m/s at every step");
    }
    let may = |id: i64| among.is_empty() || among.contains(&id);
    let ranked = rank(stage).into_iter().filter(|c| may(c.obstacle));
    let reach: Vec<bool> = ranked.map(|c| c.reaches).collect();
    let obstacles = &stage.scenario.obstacles;
    if reach.contains(&true) {
        None
    } else if !reach.is_empty() {
        Some("the ego is reached only in reverse")
    } else if obstacles.iter().any(|o| may(o.id) && moves(stage, o)) {
        Some("none has been there for 0.5 s when the ego drives 2 m/s or faster")
    } else {
        Some("none moves by itself")
    }
}

fn moves(stage: &AttackContext<'_>, obstacle: &Obstacle) -> bool {
    obstacle.role == ObstacleRole::Dynamic
        && Capability::for_obstacle(obstacle, stage.style).is_some()
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
        let reaches = distance <= fall_back(stage, obstacle, step, &ego.pose.position);
        let better = |b: Candidate| {
            (!reaches, behind, acceleration) < (!b.reaches, b.behind, b.acceleration)
        };
        if best.is_none_or(better) {
            best = Some(Candidate {
                obstacle: obstacle.id,
                acceleration,
                step,
                distance,
                near: distance <= NEAR && !behind,
                behind,
                reaches,
            });
        }
    }
    best
}

/// How far an obstacle can fall back to an ego behind it within [`LOOKAHEAD`] seconds until `step`, metres: as far as it
/// has driven. No bound where the ego is not behind it.
fn fall_back(stage: &AttackContext<'_>, obstacle: &Obstacle, step: i64, ego: &Point) -> f64 {
    let Some(now) = obstacle.motion_at(step) else {
        return f64::INFINITY;
    };
    let length = obstacle
        .footprint
        .as_ref()
        .map_or(0.0, |f| f.shape().size().0);
    if now.pose.to_local(ego).x >= -length / 2.0 {
        return f64::INFINITY;
    }
    let lately = obstacle
        .track()
        .during(&(step - stage.step_at(LOOKAHEAD)..=step));
    let first = lately.first().map_or(now, |(_, first)| first);
    (now.pose.position - first.pose.position).norm()
}
