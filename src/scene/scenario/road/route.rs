//! Routes: from a start to a goal, or ahead along the road, with a smooth reference path.

use petgraph::algo::astar;
use petgraph::graph::NodeIndex;

use super::candidates::Candidate;
use super::graph::{Node, Step};
use super::{DirectedLanelet, LaneGraph, RouteError, Side, least};
use crate::scenario::{Goal, PlanningProblem};
use nearmiss_base::geometry::{Pose, ReferencePath};

/// A way along lanelets with the path that follows it.
#[derive(Debug, Clone)]
pub struct Route {
    /// The lanelets in order; neighbours that are changed to follow each other.
    pub legs: Vec<Leg>,
    /// The lanelets that the path follows before the first leg, in driving direction.
    pub before: Vec<DirectedLanelet>,
    /// The lanelets that the path follows after the last leg.
    pub after: Vec<DirectedLanelet>,
    /// Where it leads.
    pub destination: Destination,
    /// The smooth path along the middle of the lanes. It begins before the route and ends after it
    /// where the road does: what drives behind the start or ahead of the goal is beside it too.
    pub path: ReferencePath,
    /// Arc length of the path at the start, metres.
    pub start: f64,
    /// Arc length of the path at the goal, metres.
    pub end: f64,
}

/// One lanelet of a route.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Leg {
    /// The lanelet and which way it is driven.
    pub driven: DirectedLanelet,
    /// The side to which the lane is changed, from the leg before onto this one.
    pub change: Option<Side>,
}

/// Where a route leads.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Destination {
    /// To the goal with this place among the problem's goals.
    Goal(usize),
    /// No goal says where: the route follows the road ahead, straight on where it forks.
    RoadAhead,
    /// Where a recording ends.
    Recording,
}

/// The lane that a leg is on, and between which shares of its length it is changed to.
#[derive(Debug, Clone, Copy)]
pub(super) struct LegLane {
    pub node: NodeIndex,
    pub change: Option<(Side, f64, f64)>,
}

/// How far the road ahead is followed where no goal says where, metres.
const AHEAD: f64 = 250.0;

/// What pointing elsewhere than the lane costs at the start, metres a radian.
const MISALIGNED: f64 = 20.0;

impl Route {
    /// Length from start to goal, metres.
    #[must_use]
    pub fn length(&self) -> f64 {
        self.end - self.start
    }

    /// Ids of its lanelets in order.
    #[must_use]
    pub fn lanelets(&self) -> Vec<i64> {
        self.legs.iter().map(|leg| leg.driven.lanelet).collect()
    }
}

impl LaneGraph<'_> {
    /// The cheapest route of a planning problem.
    ///
    /// Where no goal has a position, the route follows the road ahead for 250 m, and says so.
    ///
    /// # Errors
    /// Why there is none: start or goal are off the road, or no way leads from one to the other.
    pub fn route(&self, problem: &PlanningProblem) -> Result<Route, RouteError> {
        let position = problem.initial.point().ok_or(RouteError::NoStart)?;
        let heading = problem.initial.orientation.map_or(0.0, |q| q.middle());
        self.route_to(&Pose { position, heading }, &problem.goals)
    }

    /// The cheapest route from `start` to any of `goals`.
    ///
    /// # Errors
    /// As for [`Self::route`].
    pub fn route_to(&self, start: &Pose, goals: &[Goal]) -> Result<Route, RouteError> {
        let starts = self.starts(start)?;
        if goals.iter().all(|g| g.positions.is_empty()) {
            return self.road_ahead(start, AHEAD);
        }
        let arrivals = self.arrivals(goals);
        if arrivals.at.is_empty() {
            let mut unknown = arrivals.unknown;
            unknown.sort_unstable();
            unknown.dedup();
            return Err(RouteError::GoalOffRoad { unknown });
        }
        let mut best: Option<(f64, &Candidate, Vec<NodeIndex>)> = None;
        for from in &starts {
            let share = from.s / self.length(self.graph[from.node]);
            let arrived = |n: NodeIndex| {
                let node = self.graph[n];
                let arrival = arrivals.at.get(&self.plain(n));
                // Beside the start, what lies behind is not ahead.
                let ahead = |until: f64| !node.first_row || until >= share * self.length(node);
                arrival.is_some_and(|a| ahead(a.until))
            };
            let found = astar(
                &self.graph,
                from.node,
                arrived,
                |e| e.weight().cost,
                |_| 0.0,
            )
            .map(|(cost, way)| (cost + MISALIGNED * from.turn, from, way));
            best = match (best, found) {
                (Some(a), Some(b)) => Some(if b.0 < a.0 - super::ALIKE { b } else { a }),
                (a, b) => a.or(b),
            };
        }
        let Some((_, from, way)) = best else {
            let ids = |nodes: &mut dyn Iterator<Item = NodeIndex>| {
                let mut ids: Vec<i64> = nodes.map(|n| self.driven(n).lanelet).collect();
                ids.sort_unstable();
                ids.dedup();
                ids
            };
            return Err(RouteError::Unreachable {
                from: ids(&mut starts.iter().map(|c| c.node)),
                to: ids(&mut arrivals.at.keys().copied()),
            });
        };
        let goal = way.last().and_then(|&n| arrivals.at.get(&self.plain(n)));
        let (place, until) = goal.map_or((0, 0.0), |g| (g.goal, g.until));
        let parts = self.parts(&way, from, until);
        self.finish(parts, start, from.s, until, Destination::Goal(place))
    }

    /// The route along the lane under `start` and on for `distance` metres, straight on where it forks.
    ///
    /// # Errors
    /// The start is off the road, or no smooth path follows the lanes.
    pub fn road_ahead(&self, start: &Pose, distance: f64) -> Result<Route, RouteError> {
        let starts = self.starts(start)?;
        let badness = |c: &Candidate| MISALIGNED * c.turn + c.d.abs();
        let from = least(&starts, badness).ok_or(RouteError::NoRoad)?;
        let from = &starts[from];
        let mut way = vec![self.plain(from.node)];
        let mut left = distance + from.s;
        let mut end = from.node;
        loop {
            let length = self.length(self.graph[end]);
            let next = self
                .straightest(end, true)
                .into_iter()
                .find(|n| !way.contains(n));
            match next.filter(|_| left > length) {
                Some(next) => {
                    left -= length;
                    way.push(next);
                    end = next;
                }
                None => {
                    let until = left.min(length);
                    let parts = self.parts(&way, from, until);
                    return self.finish(parts, start, from.s, until, Destination::RoadAhead);
                }
            }
        }
    }

    /// The node of the same lane outside the start's row.
    fn plain(&self, node: NodeIndex) -> NodeIndex {
        let Node {
            place, direction, ..
        } = self.graph[node];
        self.node(place, direction, false).unwrap_or(node)
    }

    /// The lanes of a way, with each lane change as long as its lanelets allow.
    fn parts(&self, way: &[NodeIndex], from: &Candidate, until: f64) -> Vec<LegLane> {
        let step = |a: NodeIndex, b: NodeIndex| {
            let edge = self.graph.find_edge(a, b)?;
            match self.graph[edge].step {
                Step::On => None,
                Step::Change(side) => Some(side),
            }
        };
        let mut sides: Vec<Option<Side>> = way.windows(2).map(|w| step(w[0], w[1])).collect();
        sides.insert(0, None);
        let mut parts: Vec<LegLane> = Vec::with_capacity(way.len());
        let mut row = 0;
        while row < way.len() {
            let changes = sides[row + 1..].iter().take_while(|s| s.is_some()).count();
            let last = row + changes;
            let share =
                |s: f64, node: NodeIndex| (s / self.length(self.graph[node])).clamp(0.0, 1.0);
            let begin = if row == 0 { share(from.s, way[0]) } else { 0.0 };
            let end = if last + 1 == way.len() {
                // A goal right beside the start leaves no room to get there.
                share(until, way[last]).max(begin)
            } else {
                1.0
            };
            for (n, place) in (row..=last).enumerate() {
                let at = |n: usize| begin + (end - begin) * n as f64 / changes.max(1) as f64;
                let change = sides[place].map(|side| (side, at(n.saturating_sub(1)), at(n)));
                parts.push(LegLane {
                    node: self.plain(way[place]),
                    change,
                });
            }
            row = last + 1;
        }
        parts
    }

    /// The route along `parts`, from arc length `from` on the first lane to `until` on the last.
    pub(super) fn finish(
        &self,
        parts: Vec<LegLane>,
        start: &Pose,
        from: f64,
        until: f64,
        destination: Destination,
    ) -> Result<Route, RouteError> {
        let legs: Vec<Leg> = parts
            .iter()
            .map(|part| Leg {
                driven: self.driven(part.node),
                change: part.change.map(|(side, ..)| side),
            })
            .collect();
        let line = self.line(&parts);
        let path = ReferencePath::new(line.points).map_err(|source| RouteError::NoPath {
            lanelets: legs.iter().map(|l| l.driven.lanelet).collect(),
            source,
        })?;
        let along = line.first + from.min(line.first_length);
        let hint = path.station(along);
        let near = path.project_near(&start.position, hint, START_REACH);
        let start = near.map_or(hint, |at| at.s);
        let last =
            line.last + line.last_length * until / self.length_of(&parts).max(f64::MIN_POSITIVE);
        let end = path.station(last).max(start);
        let driven = |nodes: &[NodeIndex]| nodes.iter().map(|&n| self.driven(n)).collect();
        Ok(Route {
            legs,
            before: driven(&line.before),
            after: driven(&line.after),
            destination,
            path,
            start,
            end,
        })
    }

    fn length_of(&self, parts: &[LegLane]) -> f64 {
        parts
            .last()
            .map_or(0.0, |p| self.length(self.graph[p.node]))
    }
}

/// How far the smooth path may shift the start along itself, metres.
const START_REACH: f64 = 10.0;
