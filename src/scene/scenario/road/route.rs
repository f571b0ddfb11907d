//! Routes: from a start to a goal, or ahead along the road, with a smooth reference path; why there is none.

use std::collections::BTreeMap;

use nearmiss_base::geometry::{
    Footprint, Point, Pose, ReferencePath, ReferencePathError, angle_between,
};
use petgraph::algo::astar;
use petgraph::graph::NodeIndex;

use super::matching::Candidate;
use super::{DirectedLanelet, Direction, LaneGraph, Node, Side, Step, least};
use crate::scenario::{Goal, PlanningProblem, Position, Quantity};

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
const DEFAULT_LOOKAHEAD: f64 = 250.0;

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
            return self.road_ahead(start, DEFAULT_LOOKAHEAD);
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
                (Some(a), Some(b)) => Some(if b.0 < a.0 - super::COST_TOLERANCE {
                    b
                } else {
                    a
                }),
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

/// Why there is no route.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RouteError {
    /// The scenario has no road.
    #[error("no lanelets")]
    NoRoad,
    /// The initial state does not say where.
    #[error("the start has no position")]
    NoStart,
    /// The start is on no lanelet that may be driven.
    #[error("the start is not on a drivable lanelet{}", closest(.nearest))]
    StartOffRoad {
        /// The nearest lanelet, and how far it is in metres.
        nearest: Option<(i64, f64)>,
    },
    /// The start points against the driving direction of every lanelet there.
    #[error("the start points against the direction of lanelet {}", list(.lanelets))]
    AgainstDirection {
        /// The lanelets there.
        lanelets: Vec<i64>,
    },
    /// No goal is on a lanelet that may be driven.
    #[error("no goal is on a drivable lanelet{}", missing(.unknown))]
    GoalOffRoad {
        /// Lanelets that the goals name and that are not in the network.
        unknown: Vec<i64>,
    },
    /// No way leads there.
    #[error("no route from lanelet {} to lanelet {}", list(.from), list(.to))]
    Unreachable {
        /// Lanelets at the start.
        from: Vec<i64>,
        /// Lanelets of the goals.
        to: Vec<i64>,
    },
    /// The recorded positions are not on lanelets.
    #[error("no position is on a drivable lanelet")]
    NeverOnRoad,
    /// The recorded positions jump between lanelets that are not connected.
    #[error("the positions jump from lanelet {from} to lanelet {to}, which are not connected")]
    Jumps {
        /// The lanelet before.
        from: i64,
        /// The lanelet after.
        to: i64,
    },
    /// No smooth path follows the lanelets.
    #[error("no smooth path follows lanelets {}: {source}", list(.lanelets))]
    NoPath {
        /// The lanelets.
        lanelets: Vec<i64>,
        /// Why.
        source: ReferencePathError,
    },
}

/// Ids in words; many are cut short.
fn list(ids: &[i64]) -> String {
    let mut words: Vec<String> = ids.iter().take(8).map(i64::to_string).collect();
    if ids.len() > words.len() {
        words.push("…".into());
    }
    words.join(", ")
}

fn closest(nearest: &Option<(i64, f64)>) -> String {
    nearest.map_or_else(String::new, |(id, distance)| {
        format!("; the nearest lanelet is {id}, {distance:.2} m away")
    })
}

fn missing(ids: &[i64]) -> String {
    if ids.is_empty() {
        String::new()
    } else {
        format!("; no lanelet {}", list(ids))
    }
}

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
                                Some(at) => found.extend(self.full_route(at)),
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

    fn full_route(&self, place: usize) -> Vec<(NodeIndex, f64)> {
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
            found = under.into_iter().flat_map(|p| self.full_route(p)).collect();
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
            angle_between(middle, heading).abs() <= half + MAX_HEADING_ERROR
        };
        let fitting: Vec<_> = found.iter().copied().filter(fits).collect();
        if fitting.is_empty() { found } else { fitting }
    }
}

/// A lane may point this far from what a goal wants of the car, radians.
const MAX_HEADING_ERROR: f64 = 0.5;
