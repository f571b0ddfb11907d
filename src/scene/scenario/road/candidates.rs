//! The lanes that a pose can be on: those under it, by how well they point its way.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

use petgraph::graph::NodeIndex;

use super::{Direction, LaneGraph, RouteError};
use nearmiss_base::geometry::{Point, Pose, angle_between};

/// A lane that something is on.
#[derive(Debug, Clone, Copy)]
pub(super) struct Candidate {
    pub node: NodeIndex,
    /// Arc length along the lane as it is driven, metres.
    pub s: f64,
    /// Offset from the centre line, metres.
    pub d: f64,
    /// Angle between the heading and the lane, radians, not negative.
    pub turn: f64,
}

impl LaneGraph<'_> {
    /// The lanes under `p`; the turn is against `heading`, or 0 where none is known.
    pub(super) fn lanes_at(
        &self,
        p: &Point,
        heading: Option<f64>,
        first_row: bool,
    ) -> Vec<Candidate> {
        let mut found = Vec::new();
        for place in self.network.places_at(p) {
            let Some(lane) = &self.lanes[place] else {
                continue;
            };
            let along = lane.centre().project(p);
            for direction in [Direction::Along, Direction::Against] {
                let Some(node) = self.node(place, direction, first_row) else {
                    continue;
                };
                let s = match direction {
                    Direction::Along => along.s,
                    Direction::Against => lane.length() - along.s,
                };
                let points = self.heading(self.graph[node], s);
                found.push(Candidate {
                    node,
                    s,
                    d: along.d,
                    turn: heading.map_or(0.0, |h| angle_between(points, h).abs()),
                });
            }
        }
        found
    }

    /// The lanes that something at `start` can follow: those within 45° of its heading, or if there are
    /// none, within 90°.
    pub(super) fn starts(&self, start: &Pose) -> Result<Vec<Candidate>, RouteError> {
        if self.network.lanelets.is_empty() {
            return Err(RouteError::NoRoad);
        }
        let under = self.lanes_at(&start.position, Some(start.heading), true);
        if under.is_empty() {
            return Err(RouteError::StartOffRoad {
                nearest: self.network.nearest_lanelet(&start.position),
            });
        }
        for most in [FRAC_PI_4, FRAC_PI_2] {
            let fitting: Vec<_> = under.iter().copied().filter(|c| c.turn < most).collect();
            if !fitting.is_empty() {
                return Ok(fitting);
            }
        }
        let mut lanelets: Vec<i64> = under.iter().map(|c| self.driven(c.node).lanelet).collect();
        lanelets.dedup();
        Err(RouteError::AgainstDirection { lanelets })
    }
}
