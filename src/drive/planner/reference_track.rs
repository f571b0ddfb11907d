//! The planner's reference: a route's smooth path, and the desired speed on it.

use std::sync::Arc;

use super::smooth::smooth;
use super::{Arrival, CurvatureSpeedLimit, LegalSpeed, VehicleState};
use nearmiss_base::geometry::{
    LateralProfile, Pose, ReferencePath, ReferencePathError, angle_between,
};
use nearmiss_scene::scenario::{LaneGraph, PlanningProblem, RouteError, Scenario};
use nearmiss_scene::traffic_rules::Regulations;

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
const NEAR: f64 = 20.0;

/// The smooth path begins this far before the start, and ends this far beyond the goal, metres.
const BEHIND: f64 = 30.0;
const BEYOND: f64 = 80.0;

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
        let (from, to) = (route.start - BEHIND, route.end + BEYOND);
        let path = smooth(&route.path, from, to).map_err(|source| ReferenceTrackError::NoPath {
            problem: problem.id,
            source,
        })?;
        let start = path
            .project_near(&position, BEHIND, NEAR)
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
        let near = path.project_near(&state.rear.position, self.start, NEAR);
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
