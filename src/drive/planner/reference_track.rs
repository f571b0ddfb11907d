//! The planner's reference: a route's path, smooth enough to be driven at speed, and the desired speed on it.
//!
//! Smooths a path so that it can be driven at speed, near the middle of the lanes.
//!
//! Maps draw curves with few points, and a path that keeps to them within centimetres has kinks that no vehicle can
//! follow. Points along the path are moved to make the squared third differences (the change of curvature) small,
//! within a tolerance: the smoother of Whittaker (1923), with more weight where the path would stray.

use std::sync::Arc;

use nearmiss_base::geometry::{
    LateralProfile, Point, Pose, ReferencePath, ReferencePathError, Vector, angle_between,
};
use nearmiss_scene::scenario::{LaneGraph, PlanningProblem, RouteError, Scenario};
use nearmiss_scene::traffic_rules::Regulations;

use super::{Arrival, CurvatureSpeedLimit, LegalSpeed, VehicleState};

/// The path to follow, when to be where, and how fast otherwise.
#[derive(Debug, Clone)]
pub struct ReferenceTrack {
    /// The path that is followed: near that of the route, smooth enough to be driven at speed.
    pub path: Arc<ReferencePath>,
    /// Arc length of the start along it, metres.
    pub start: f64,
    /// Where and when to arrive, if the goal specifies it.
    pub arrival: Option<Arrival>,
    /// The speed that is driven where nothing else decides, m/s.
    pub cruise: f64,
    /// The fastest that is driven to arrive in time, m/s: an ego that is late may stay late.
    pub fastest: f64,
    /// How fast the bends ahead let one be.
    pub bends: CurvatureSpeedLimit,
    /// What the rules of the road ask for along it.
    pub regulations: Arc<Regulations>,
    /// How fast they let one be; `None` where nothing limits the speed.
    pub legal: Option<Arc<LegalSpeed>>,
}

/// Why there is no reference track.
#[derive(Debug, thiserror::Error)]
pub enum ReferenceTrackError {
    /// The planning problem has no start.
    #[error("planning problem {problem} has no start position")]
    NoStart {
        /// Its id.
        problem: i64,
    },
    /// No way leads to the goal.
    #[error("planning problem {problem}: {source}")]
    NoRoute {
        /// Its id.
        problem: i64,
        /// Why.
        source: RouteError,
    },
    /// No smooth path follows the way.
    #[error("planning problem {problem}: {source}")]
    NoPath {
        /// Its id.
        problem: i64,
        /// Why.
        source: ReferencePathError,
    },
}

/// The ego wants to drive no slower than this where nothing says how fast, m/s.
const SLOWEST_CRUISE: f64 = 8.0;

/// How much faster than cruising, or than the mean speed to the goal, is driven to arrive in time.
const HASTE: f64 = 1.3;

/// The start may lie this far from where the route has it, metres.
const MAX_START_DISTANCE: f64 = 20.0;

/// The smooth path begins this far before the start, and ends this far beyond the goal, metres.
const BEHIND: f64 = 30.0;
const EXTENSION: f64 = 80.0;

/// Deceleration towards the goal, m/s².
const GENTLY: f64 = 2.0;

/// The end of the goal is approached as if at least this were left, seconds, so that the ego does not brake hard at it.
const LAST: f64 = 2.0;

impl ReferenceTrack {
    /// The guide to the goal of a planning problem: the route over its lanes, the goal's time and place, and as
    /// cruising speed the one that it starts with, 8 m/s at least.
    ///
    /// # Errors
    /// The problem has no start, or no way leads to its goal.
    pub fn for_problem(
        scenario: &Scenario,
        graph: &LaneGraph<'_>,
        problem: &PlanningProblem,
    ) -> Result<Self, ReferenceTrackError> {
        let start = problem.initial.point();
        let position = start.ok_or(ReferenceTrackError::NoStart {
            problem: problem.id,
        })?;
        let heading = problem.initial.orientation.map_or(0.0, |q| q.middle());
        let route = graph
            .route_to(&Pose { position, heading }, &problem.goals)
            .map_err(|source| ReferenceTrackError::NoRoute {
                problem: problem.id,
                source,
            })?;
        let (from, to) = (route.start - BEHIND, route.end + EXTENSION);
        let path = smooth(&route.path, from, to).map_err(|source| ReferenceTrackError::NoPath {
            problem: problem.id,
            source,
        })?;
        let start = path
            .project_near(&position, BEHIND, MAX_START_DISTANCE)
            .map_or(BEHIND, |at| at.s);
        let velocity = problem.initial.velocity.map_or(0.0, |q| q.middle());
        let cruise = velocity.max(SLOWEST_CRUISE);
        let arrival = Arrival::new(scenario, problem, &route, &path);
        let mean = arrival.map_or(0.0, |arrival| {
            let time = (arrival.step - problem.initial.time.from) as f64 * scenario.dt();
            (arrival.from - start) / time.max(scenario.dt())
        });
        let regulations = Regulations::along(&scenario.network, &route, &path);
        Ok(Self {
            legal: LegalSpeed::new(&regulations, path.length()).map(Arc::new),
            regulations: Arc::new(regulations),
            arrival,
            fastest: HASTE * cruise.max(mean),
            cruise,
            bends: CurvatureSpeedLimit::new(&path),
            path: Arc::new(path),
            start,
        })
    }

    /// The curvature (1/m) with which a vehicle keeps its angle to the path; nothing beside the path's ends.
    #[must_use]
    pub fn curvature_at(&self, state: &VehicleState) -> Option<f64> {
        let path = &self.path;
        let near = path.project_near(&state.rear.position, self.start, MAX_START_DISTANCE);
        let at = near.or_else(|_| path.project(&state.rear.position)).ok()?;
        let turn = angle_between(path.at(at.s).heading, state.rear.heading);
        let stretch = path.at(at.s).stretch(at).ok()?;
        let profile = LateralProfile {
            d: at.d,
            d_s: stretch * turn.tan(),
            d_ss: 0.0,
        };
        Some(path.heading_and_curvature(at.s, &profile).ok()?.1)
    }

    /// The speed to arrive in time with, m/s, of a body whose centre is at arc length `s` (m) at `step`, with speed
    /// `now` (m/s).
    ///
    /// It is as near to cruising as the goal's place and time let it be; it is slowed down to as gently as there is
    /// room for.
    #[must_use]
    pub fn wanted(&self, s: f64, now: f64, step: i64, dt: f64) -> f64 {
        let Some(arrival) = &self.arrival else {
            return self.cruise;
        };
        let left = (arrival.step - step) as f64 * dt;
        let room = (arrival.to - s).max(0.0);
        let least = ((arrival.from - s) / left.max(dt)).clamp(0.0, self.fastest);
        let most = (room / left.max(LAST)).max(now - GENTLY);
        let stopping = (2.0 * GENTLY * room).sqrt();
        self.cruise.min(most).min(stopping).max(least)
    }
}

/// Distance between the points that are moved, metres.
const SPACING: f64 = 1.0;

/// How far the smooth path may be from the given one, metres.
const TOLERANCE: f64 = 0.4;

/// What smoothness weighs against closeness: waves shorter than about 30 m are flattened.
const SMOOTHNESS: f64 = 1e4;

/// Where it strays, closeness weighs this much more in the next round; and this many rounds there are.
const FIRMER: f64 = 3.0;
const ROUNDS: usize = 12;

/// Points on either side that are held more firmly where one strays.
const HELD_NEIGHBOURS: usize = 4;

/// A smooth path along `path` from arc length `from` to `to`, metres.
///
/// # Errors
/// No smooth curve follows the points; not for paths that are smooth themselves.
pub(super) fn smooth(
    path: &ReferencePath,
    from: f64,
    to: f64,
) -> Result<ReferencePath, ReferencePathError> {
    let pieces = ((to - from) / SPACING).ceil().max(1.0) as usize;
    let points: Vec<Vector> = (0..=pieces)
        .map(|i| {
            path.at(from + (to - from) * i as f64 / pieces as f64)
                .position
                .coords
        })
        .collect();
    let origin = points[0];
    let given: Vec<Vector> = points.iter().map(|p| p - origin).collect();
    let mut weights = vec![1.0; given.len()];
    let mut moved = given.clone();
    for _ in 0..ROUNDS {
        moved = flatten(&given, &weights);
        let strays: Vec<usize> = (0..given.len())
            .filter(|&i| (moved[i] - given[i]).norm() > TOLERANCE)
            .collect();
        if strays.is_empty() {
            break;
        }
        let mut firmer = vec![false; given.len()];
        for i in strays {
            let last = (i + HELD_NEIGHBOURS).min(given.len() - 1);
            firmer[i.saturating_sub(HELD_NEIGHBOURS)..=last].fill(true);
        }
        for (weight, firmer) in weights.iter_mut().zip(firmer) {
            if firmer {
                *weight *= FIRMER;
            }
        }
    }
    ReferencePath::new(finer(&moved).into_iter().map(|p| Point::from(p + origin)))
}

/// Points between those of a curve, so that what is drawn through them does not follow the chords: cubic interpolation.
fn finer(points: &[Vector]) -> Vec<Vector> {
    let last = points.len() - 1;
    let at = |i: i64| -> Vector {
        match usize::try_from(i) {
            Err(_) => points[0] * 2.0 - points[1.min(last)],
            Ok(i) if i > last => points[last] * 2.0 - points[last.saturating_sub(1)],
            Ok(i) => points[i],
        }
    };
    let mut all = Vec::with_capacity(points.len() * BETWEEN);
    for i in 0..last as i64 {
        let [a, b, c, d] = [at(i - 1), at(i), at(i + 1), at(i + 2)];
        for part in 0..BETWEEN {
            let t = part as f64 / BETWEEN as f64;
            let slope = (c - a) * t;
            let square = (a * 2.0 - b * 5.0 + c * 4.0 - d) * (t * t);
            let cube = (b * 3.0 - a - c * 3.0 + d) * (t * t * t);
            all.push(b + (slope + square + cube) / 2.0);
        }
    }
    all.push(points[last]);
    all
}

/// Points for each that is moved.
const BETWEEN: usize = 8;

/// Third differences.
const DIFFERENCE: [f64; 4] = [-1.0, 3.0, -3.0, 1.0];

/// The points that minimise Σ w‖x − given‖² + λ Σ‖Δ³x‖², by a Cholesky decomposition of the band matrix.
fn flatten(given: &[Vector], weights: &[f64]) -> Vec<Vector> {
    let n = given.len();
    // Row i holds the matrix from the diagonal to the third place left of it.
    let mut band: Vec<[f64; 4]> = weights.iter().map(|w| [*w, 0.0, 0.0, 0.0]).collect();
    for first in 0..n.saturating_sub(3) {
        for (a, da) in DIFFERENCE.iter().enumerate() {
            for (b, db) in DIFFERENCE.iter().enumerate().take(a + 1) {
                band[first + a][a - b] += SMOOTHNESS * da * db;
            }
        }
    }
    for i in 0..n {
        for j in i.saturating_sub(3)..=i {
            let before = i.saturating_sub(3).max(j.saturating_sub(3))..j;
            let sum: f64 = before.map(|k| band[i][i - k] * band[j][j - k]).sum();
            let left = band[i][i - j] - sum;
            // The weights are positive, so the matrix is positive definite.
            band[i][i - j] = if i == j {
                left.sqrt()
            } else {
                left / band[j][0]
            };
        }
    }
    let mut x: Vec<Vector> = given.iter().zip(weights).map(|(p, w)| p * *w).collect();
    for i in 0..n {
        for k in i.saturating_sub(3)..i {
            let known = x[k];
            x[i] -= known * band[i][i - k];
        }
        x[i] /= band[i][0];
    }
    for i in (0..n).rev() {
        for k in i + 1..(i + 4).min(n) {
            let known = x[k];
            x[i] -= known * band[k][k - i];
        }
        x[i] /= band[i][0];
    }
    x
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    fn most(path: &ReferencePath, of: impl Fn(&nearmiss_base::geometry::PathPoint) -> f64) -> f64 {
        let steps = (path.length() / 0.25) as usize;
        (0..=steps)
            .map(|i| of(&path.at(i as f64 * 0.25)).abs())
            .fold(0.0, f64::max)
    }

    #[test]
    fn kinks_go_and_corners_stay_near() {
        let corner = [
            (0., 0.),
            (40., 0.),
            (41., 0.1),
            (80., 6.),
            (90., 14.),
            (92., 50.),
        ];
        let line = corner.map(|(x, y)| Point::new(x, y));
        let rough = ReferencePath::new(line).unwrap();
        let path = smooth(&rough, 0.0, rough.length()).unwrap();
        assert!(most(&path, |p| p.curvature_rate) < most(&rough, |p| p.curvature_rate) / 10.0);
        for i in 0..=100 {
            let p = path.at(path.length() * f64::from(i) / 100.0).position;
            assert!(rough.project(&p).unwrap().d.abs() < TOLERANCE + 0.15);
        }
    }

    #[test]
    fn a_straight_line_stays() {
        let line = [(5., 5.), (105., 105.)].map(|(x, y)| Point::new(x, y));
        let straight = ReferencePath::new(line).unwrap();
        let path = smooth(&straight, 0.0, straight.length()).unwrap();
        assert!((path.length() - straight.length()).abs() < 1e-6);
        assert!(most(&path, |p| p.curvature) < 1e-9);
    }
}
