//! A drive along its way: where front and rear are at each step.

use super::Regulations;
use crate::scenario::{Route, RouteError, Scene};
use nearmiss_base::geometry::{Point, ReferencePath};

/// The ego of a scene along the way that it drove.
#[derive(Debug)]
pub(super) struct EgoAlong<'a> {
    pub scene: &'a Scene,
    pub path: ReferencePath,
    pub regulations: Regulations,
    /// Its moments, one a step.
    pub moments: Vec<Moment>,
}

/// The ego at a step.
#[derive(Debug, Clone, Copy)]
pub(super) struct Moment {
    pub step: i64,
    /// Arc lengths of the body's front and rear, metres.
    pub front: f64,
    pub rear: f64,
    /// m/s and m/s².
    pub velocity: f64,
    pub acceleration: f64,
    pub position: Point,
}

/// From one step to the next the place on the path moves less than this, metres.
const HINT: f64 = 25.0;

impl<'a> EgoAlong<'a> {
    /// Finds the way of a scene's ego.
    ///
    /// # Errors
    /// It is on no lanes, or they are not connected.
    pub fn new(scene: &'a Scene) -> Result<Self, RouteError> {
        let network = &scene.scenario.network;
        let graph = network.lane_graph(None);
        let poses = scene.ego.track.iter().map(|(_, motion)| motion.pose);
        let route: Route = graph.route_along(poses)?;
        let regulations = Regulations::along(network, &route, &route.path);
        let (length, _) = scene.ego.footprint.shape().size();
        let mut hint = route.start;
        let moments = scene
            .ego
            .track
            .iter()
            .filter_map(|(step, motion)| {
                let position = motion.pose.position;
                let at = route.path.project_near(&position, hint, HINT).ok()?;
                hint = at.s;
                Some(Moment {
                    step,
                    front: at.s + length / 2.0,
                    rear: at.s - length / 2.0,
                    velocity: motion.velocity,
                    acceleration: motion.acceleration,
                    position,
                })
            })
            .collect();
        Ok(Self {
            scene,
            regulations,
            moments,
            path: route.path,
        })
    }

    /// Seconds between two steps.
    pub fn dt(&self) -> f64 {
        self.scene.scenario.dt()
    }

    /// The place of the moment at which the front passes an arc length; nothing where it begins beyond it or never does.
    pub fn passes(&self, s: f64) -> Option<usize> {
        let beyond = self.moments.iter().position(|m| m.front > s)?;
        (beyond > 0).then_some(beyond)
    }

    /// Whether the front comes within so many metres of an arc length that is ahead of it at first.
    pub fn comes_near(&self, s: f64, within: f64) -> bool {
        let first = self.moments.first();
        first.is_some_and(|m| m.front <= s) && self.moments.iter().any(|m| m.front > s - within)
    }

    /// The lanelet of the way under the middle of the ego.
    pub fn lanelet(&self, moment: &Moment) -> Option<i64> {
        self.regulations
            .lanelet_at(f64::midpoint(moment.front, moment.rear))
    }
}
