//! The road of the ego: its route, and which lanes bodies stand on.

use std::collections::HashMap;

use super::LaneBody;
use crate::scenario::{Motion, Route, RouteError, Scene};
use nearmiss_base::geometry::{Footprint, Placed, Pose};

/// The route of the ego with the lanes beside it.
#[derive(Debug)]
pub struct Road {
    /// The route along which measures look.
    pub route: Route,
    /// Numbers of lanes by lanelet.
    lanes: HashMap<i64, i32>,
}

/// Some lanes of a road, by number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct LaneSet(u64);

/// How far the road ahead is looked at, metres: what is farther is no obstacle to anyone yet.
const AHEAD: f64 = 150.0;

/// Between two poses on the road ahead, metres.
const APART: f64 = 2.0;

/// Lane numbers are shifted by this to become bits; what is still outside is no lane beside the route.
const MIDDLE: i32 = 32;

impl LaneSet {
    /// Whether a lane is in both.
    #[must_use]
    pub fn meets(self, other: Self) -> bool {
        self.0 & other.0 != 0
    }

    fn add(&mut self, number: i32) {
        let bit = u32::try_from(number.saturating_add(MIDDLE)).ok();
        self.0 |= bit.and_then(|bit| 1_u64.checked_shl(bit)).unwrap_or(0);
    }
}

impl Road {
    /// The route along the ego's recorded track, by map matching; where that fails, the route of its planning
    /// problem.
    pub(in crate::metrics) fn from_scene(scene: &Scene) -> Result<Self, RouteError> {
        let graph = scene.scenario.network.lane_graph(None);
        let recorded = graph.route_along(scene.ego.track.iter().map(|(_, motion)| motion.pose));
        let route = recorded.or_else(|why| {
            let problems = &scene.scenario.planning_problems;
            let own = problems.iter().find(|p| p.id == scene.ego.id);
            // The recording is what was asked for, so its reason is the one to give.
            own.or(problems.first())
                .and_then(|p| graph.route(p).ok())
                .ok_or(why)
        })?;
        Ok(Self {
            lanes: graph.lane_numbers(&route),
            route,
        })
    }

    /// The route along `driven`, oldest first, and then straight on along the lanes, whatever came later.
    pub(in crate::metrics) fn ahead(scene: &Scene, driven: &[Pose]) -> Result<Self, RouteError> {
        let graph = scene.scenario.network.lane_graph(None);
        let last = driven.last().ok_or(RouteError::NeverOnRoad)?;
        let on = graph.road_ahead(last, AHEAD).map(|route| {
            let count = (route.length() / APART).floor() as usize;
            let poses = (1..=count).map(|i| route.path.pose_at(route.start + i as f64 * APART));
            poses.collect()
        });
        let on: Vec<Pose> = on.unwrap_or_default();
        let route = graph.route_along(driven.iter().copied().chain(on))?;
        Ok(Self {
            lanes: graph.lane_numbers(&route),
            route,
        })
    }

    /// A body along the route; `None` if it is not beside it.
    pub(in crate::metrics) fn along(&self, motion: &Motion, body: &Footprint) -> Option<LaneBody> {
        let (at, point) = self.route.path.project_point(&motion.pose.position).ok()?;
        LaneBody::new(at, &point, motion, body)
    }

    /// The lanes of the road that a body stands on.
    pub(in crate::metrics) fn lanes_under(&self, scene: &Scene, body: &Placed<'_>) -> LaneSet {
        let mut lanes = LaneSet::default();
        for id in scene.scenario.network.lanelets_under(body) {
            if let Some(&number) = self.lanes.get(&id) {
                lanes.add(number);
            }
        }
        lanes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sets_of_lanes() {
        let set = |numbers: &[i32]| {
            let mut set = LaneSet::default();
            numbers.iter().for_each(|n| set.add(*n));
            set
        };
        assert!(set(&[0, 1]).meets(set(&[1, 2])) && !set(&[0, -1]).meets(set(&[1, -2])));
        assert_eq!(set(&[40, -40, i32::MAX]), LaneSet::default());
    }
}
