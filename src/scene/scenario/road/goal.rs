//! Where goals lie on the lanes.

use std::collections::BTreeMap;

use petgraph::graph::NodeIndex;

use super::{Direction, LaneGraph};
use crate::scenario::{Goal, Position, Quantity};
use nearmiss_base::geometry::{Footprint, Point, Pose, angle_between};

/// A lane on which a goal is reached.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Arrival {
    /// Place of the goal among those of the problem.
    pub goal: usize,
    /// Arc length along the driven lane up to which it is reached, metres.
    pub until: f64,
}

/// The lanes of all goals, and the lanelets that goals name and the network does not have.
#[derive(Debug, Default)]
pub(super) struct Arrivals {
    pub at: BTreeMap<NodeIndex, Arrival>,
    pub unknown: Vec<i64>,
}

impl LaneGraph<'_> {
    /// Where `goals` are reached. Of several goals on one lane the farthest counts.
    pub(super) fn arrivals(&self, goals: &[Goal]) -> Arrivals {
        let mut arrivals = Arrivals::default();
        for (place, goal) in goals.iter().enumerate() {
            let mut found: Vec<(NodeIndex, f64)> = Vec::new();
            for position in &goal.positions {
                match position {
                    Position::Lanelets(ids) => {
                        for &id in ids {
                            match self.network.place(id) {
                                Some(at) => found.extend(self.whole(at)),
                                None => arrivals.unknown.push(id),
                            }
                        }
                    }
                    Position::Point(p) => found.extend(self.point(p)),
                    Position::Region(shape) => {
                        // A region that is no shape has no place.
                        if let Ok(region) = Footprint::new(shape.clone()) {
                            found.extend(self.region(&region));
                        }
                    }
                }
            }
            for (node, until) in self.pointing(goal.orientation, found) {
                let arrival = Arrival { goal: place, until };
                let known = arrivals.at.entry(node).or_insert(arrival);
                if known.until < until {
                    *known = arrival;
                }
            }
        }
        arrivals
    }

    fn both(&self, place: usize) -> impl Iterator<Item = NodeIndex> {
        let directions = [Direction::Along, Direction::Against];
        directions
            .into_iter()
            .filter_map(move |d| self.node(place, d, false))
    }

    fn whole(&self, place: usize) -> Vec<(NodeIndex, f64)> {
        let nodes = self.both(place);
        nodes.map(|n| (n, self.length(self.graph[n]))).collect()
    }

    fn point(&self, p: &Point) -> Vec<(NodeIndex, f64)> {
        let lanes = self.lanes_at(p, None, false).into_iter();
        lanes.map(|c| (c.node, c.s)).collect()
    }

    /// The lanes whose centre line runs through a region; if there are none, those under its middle;
    /// if there are none, those it overlaps.
    fn region(&self, region: &Footprint) -> Vec<(NodeIndex, f64)> {
        let placed = region.at(Pose::new(0.0, 0.0, 0.0));
        let under = self.network.places_under(&placed);
        let mut found = Vec::new();
        for &place in &under {
            let Some(lane) = &self.lanes[place] else {
                continue;
            };
            let steps = (lane.length() / 0.5).ceil().min(10_000.0) as usize;
            for node in self.both(place) {
                let along = self.graph[node].direction == Direction::Along;
                let last = (0..=steps).rev().find_map(|i| {
                    let s = lane.length() * i as f64 / steps.max(1) as f64;
                    let at = if along { s } else { lane.length() - s };
                    let p = lane.centre().pose_at(at).position;
                    placed.holds(&p).then_some(s)
                });
                found.extend(last.map(|s| (node, s)));
            }
        }
        if found.is_empty() {
            found = self.point(&placed.bounds().center());
        }
        if found.is_empty() {
            found = under.into_iter().flat_map(|p| self.whole(p)).collect();
        }
        found
    }

    /// Those that point as the goal wants it, if any does; a lane's direction need not be the car's.
    fn pointing(
        &self,
        orientation: Option<Quantity>,
        found: Vec<(NodeIndex, f64)>,
    ) -> Vec<(NodeIndex, f64)> {
        let (middle, half) = match orientation {
            None => return found,
            Some(Quantity::Exact(angle)) => (angle, 0.0),
            Some(Quantity::Interval(from, to)) => (f64::midpoint(from, to), (to - from) / 2.0),
        };
        let fits = |&(node, s): &(NodeIndex, f64)| {
            let heading = self.heading(self.graph[node], s);
            angle_between(middle, heading).abs() <= half + ASTRAY
        };
        let fitting: Vec<_> = found.iter().copied().filter(fits).collect();
        if fitting.is_empty() { found } else { fitting }
    }
}

/// A lane may point this far from what a goal wants of the car, radians.
const ASTRAY: f64 = 0.5;
