//! Measures along the road: gaps and closing speeds in the Frenet frame of the ego's route, and the bodies on its lanes.

pub(super) mod exposure;
pub(super) mod following;
pub(super) mod rss;

pub(super) use exposure::Exposure;
pub(super) use following::Following;

use std::collections::HashMap;

use nearmiss_base::geometry::{
    Footprint, Frenet, PathPoint, Placed, Point, Pose, ReferencePath, Shape, Vector,
};

use crate::scenario::{Motion, Route, RouteError, Scene};

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
const LOOKAHEAD: f64 = 150.0;

/// Between two poses on the road ahead, metres.
const POSE_SPACING: f64 = 2.0;

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
        let on = graph.road_ahead(last, LOOKAHEAD).map(|route| {
            let count = (route.length() / POSE_SPACING).floor() as usize;
            let poses =
                (1..=count).map(|i| route.path.pose_at(route.start + i as f64 * POSE_SPACING));
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
        LaneBody::beside(&self.route.path, motion, body)
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

/// A body in the Frenet frame of a route.
///
/// Its outline is projected with the curvature of the route beside its position, which is exact on straight
/// lines and arcs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LaneBody {
    /// The position of its state.
    pub at: Frenet,
    /// Least arc length of the body, metres.
    pub rear: f64,
    /// Greatest arc length of the body, metres.
    pub front: f64,
    /// Least offset of the body, metres; offsets grow to the left.
    pub right: f64,
    /// Greatest offset of the body, metres.
    pub left: f64,
    /// Velocity along and across the route, m/s.
    pub velocity: Vector,
    /// Acceleration along the route, m/s²: the recorded one, which is along the heading.
    pub acceleration: f64,
}

impl LaneBody {
    /// A body along a path; `None` if it is not beside it.
    pub(in crate::metrics) fn beside(
        path: &ReferencePath,
        motion: &Motion,
        body: &Footprint,
    ) -> Option<Self> {
        let (at, point) = path.project_point(&motion.pose.position).ok()?;
        Self::new(at, &point, motion, body)
    }

    fn new(at: Frenet, beside: &PathPoint, motion: &Motion, body: &Footprint) -> Option<Self> {
        // The way at the body's offset is this much longer or shorter than the route.
        let stretch = beside.stretch(at).ok()?;
        let frame = Frame {
            at,
            curvature: beside.curvature,
            turn: motion.pose.heading - beside.heading,
        };
        let (sin, cos) = frame.turn.sin_cos();
        let mut found = Self {
            at,
            rear: f64::MAX,
            front: f64::MIN,
            right: f64::MAX,
            left: f64::MIN,
            velocity: Vector::new(motion.velocity * cos / stretch, motion.velocity * sin),
            acceleration: motion.acceleration * cos / stretch,
        };
        if let Shape::Circle { radius, center } = body.shape() {
            let middle = frame.place(center, sin, cos);
            let around = frame.curvature * radius
                / (1.0 - frame.curvature * middle.d).max(*radius * frame.curvature.abs());
            let half = if frame.curvature == 0.0 {
                *radius
            } else {
                around.clamp(-1.0, 1.0).asin() / frame.curvature
            };
            found.take(Frenet {
                s: middle.s - half,
                d: middle.d - radius,
            });
            found.take(Frenet {
                s: middle.s + half,
                d: middle.d + radius,
            });
        } else {
            for corner in body.corners() {
                found.take(frame.place(corner, sin, cos));
            }
        }
        Some(found)
    }

    fn take(&mut self, p: Frenet) {
        self.rear = self.rear.min(p.s);
        self.front = self.front.max(p.s);
        self.right = self.right.min(p.d);
        self.left = self.left.max(p.d);
    }

    /// Free distance across the route to another body, metres; 0 where they overlap across it.
    #[must_use]
    pub fn clearance(&self, other: &Self) -> f64 {
        (other.right - self.left)
            .max(self.right - other.left)
            .max(0.0)
    }
}

/// A frame that moves along an arc: where points of a body lie.
struct Frame {
    at: Frenet,
    curvature: f64,
    turn: f64,
}

impl Frame {
    /// Coordinates of a point of the body's frame, along the circle that the route follows here.
    fn place(&self, p: &Point, sin: f64, cos: f64) -> Frenet {
        let (along, across) = (p.x * cos - p.y * sin, p.x * sin + p.y * cos);
        let offset = self.at.d + across;
        let k = self.curvature;
        let radial = 1.0 - k * offset;
        let ds = if k == 0.0 {
            along
        } else {
            (k * along).atan2(radial) / k
        };
        // (1 − h)/κ with h the distance from the circle's centre in radii, without cancellation.
        let h = (k * along).hypot(radial);
        let d = (2.0 * offset - k * (along * along + offset * offset)) / (1.0 + h);
        Frenet {
            s: self.at.s + ds,
            d,
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use nearmiss_base::geometry::{Pose, ReferencePath};

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

    #[test]
    fn corners_on_an_arc_lie_where_projection_finds_them() {
        let arc = |i: i32| {
            let angle = f64::from(i) / 100.0;
            Point::new(30.0 * angle.sin(), 30.0 - 30.0 * angle.cos())
        };
        let path = ReferencePath::new((0..200).map(arc)).unwrap();
        let body = Footprint::new(Shape::rectangle(8.0, 2.5)).unwrap();
        let angle: f64 = 0.9;
        let motion = Motion {
            pose: Pose::new(28.0 * angle.sin(), 30.0 - 28.0 * angle.cos(), angle + 0.2),
            velocity: 10.0,
            acceleration: -2.0,
        };
        let (at, point) = path.project_point(&motion.pose.position).unwrap();
        let found = LaneBody::new(at, &point, &motion, &body).unwrap();
        let corners: Vec<Frenet> = body.at(motion.pose).outlines()[0]
            .iter()
            .map(|p| path.project(p).unwrap())
            .collect();
        let most = |f: fn(&Frenet) -> f64| corners.iter().map(f).fold(f64::MIN, f64::max);
        assert!(
            (found.front - most(|c| c.s)).abs() < 2e-2,
            "{found:?} {corners:?}"
        );
        assert!((found.rear + most(|c| -c.s)).abs() < 2e-2);
        assert!((found.left - most(|c| c.d)).abs() < 2e-2);
        assert!((found.right + most(|c| -c.d)).abs() < 2e-2);
        // Inside the curve the same speed leads farther along the route.
        assert!(found.velocity.x > 10.0 * 0.2_f64.cos());
    }

    #[test]
    fn a_straight_road_is_plain() {
        let path = ReferencePath::new([Point::new(0.0, 0.0), Point::new(100.0, 0.0)]).unwrap();
        let disc = Footprint::new(Shape::Circle {
            radius: 0.5,
            center: Point::new(0.2, 0.0),
        })
        .unwrap();
        let motion = Motion {
            pose: Pose::new(40.0, 3.0, 0.0),
            velocity: 1.0,
            acceleration: 0.0,
        };
        let (at, point) = path.project_point(&motion.pose.position).unwrap();
        let found = LaneBody::new(at, &point, &motion, &disc).unwrap();
        for (value, expected) in [
            (found.rear, 39.7),
            (found.front, 40.7),
            (found.right, 2.5),
            (found.left, 3.5),
        ] {
            assert!((value - expected).abs() < 1e-9, "{found:?}");
        }
    }
}
