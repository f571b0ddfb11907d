//! Which lanelets lie where: map matching of poses and recordings, and the drivable area.
//!
//! Source: Newson and Krumm, Hidden Markov Map Matching Through Noise and Sparseness, 2009; here the
//! states are lanes, and a step to one that is not connected is refused.

use std::collections::HashMap;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};
use std::sync::OnceLock;

use nearmiss_base::geometry::{
    Area, Bounds, Outside, Placed, Point, Pose, angle_between, contains,
};
use petgraph::graph::NodeIndex;
use petgraph::visit::EdgeRef;
use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};

use super::route::{Destination, LegLane, Route};
use super::{COST_TOLERANCE, Direction, LaneGraph, RouteError, Side, Step, least};
use crate::scenario::{Lanelet, LaneletNetwork, RoadUser};

/// Positions nearer to the one before are skipped, metres.
const MIN_SPACING: f64 = 1.0;

/// Half of this turn against the lane costs as much as half of [`OFFSET`] beside its middle, radians.
const TURN: f64 = 0.35;

/// Metres beside the middle of the lane.
const OFFSET: f64 = 1.5;

/// Cost of the steps between positions: straight on, and a lane change.
const ON: f64 = 0.2;

const CHANGE: f64 = 4.0;

/// Most steps in the graph between two positions.
const MAX_HOPS: usize = 6;

/// More lanes are not looked at from one lane: no map branches so.
const MOST_LANES: usize = 256;

/// A lane change that was recorded lasts this long to both sides of where it crossed over, metres.
const CROSSING: f64 = 15.0;

/// A lane at a position, with the best way there.
struct State {
    candidate: Candidate,
    cost: f64,
    /// Place among the states of the position before, and the lanes on the way from there.
    from: Option<(usize, Vec<NodeIndex>)>,
}

impl LaneGraph<'_> {
    /// The route that `poses` drove, in their order.
    ///
    /// Positions on no lanelet are passed over.
    ///
    /// # Errors
    /// None of the positions is on a lanelet, they jump to where no way leads, or no smooth path follows.
    pub fn route_along(&self, poses: impl IntoIterator<Item = Pose>) -> Result<Route, RouteError> {
        let mut columns: Vec<Vec<State>> = Vec::new();
        let mut first: Option<Pose> = None;
        let mut last: Option<Pose> = None;
        let mut near: HashMap<NodeIndex, Vec<Reached>> = HashMap::new();
        for pose in poses {
            // What is just this far apart must not depend on rounding.
            if last
                .is_some_and(|l| (l.position - pose.position).norm() < MIN_SPACING - COST_TOLERANCE)
            {
                continue;
            }
            let candidates = self.lanes_at(&pose.position, Some(pose.heading), false);
            if candidates.is_empty() {
                continue;
            }
            let column = match columns.last() {
                None => candidates.into_iter().map(State::first).collect(),
                Some(before) => self.advance(before, candidates, &mut near)?,
            };
            columns.push(column);
            first.get_or_insert(pose);
            last = Some(pose);
        }
        let (Some(start), false) = (first, columns.is_empty()) else {
            return Err(RouteError::NeverOnRoad);
        };
        let (parts, from, until) = self.trace(&columns);
        self.finish(parts, &start, from, until, Destination::Recording)
    }

    fn advance(
        &self,
        before: &[State],
        candidates: Vec<Candidate>,
        near: &mut HashMap<NodeIndex, Vec<Reached>>,
    ) -> Result<Vec<State>, RouteError> {
        for state in before {
            let node = state.candidate.node;
            near.entry(node).or_insert_with(|| self.reach(node));
        }
        // The ways to each candidate, by the lane that it is on.
        let mut ways_to: HashMap<NodeIndex, Vec<(f64, usize, &Reached)>> = HashMap::new();
        for candidate in &candidates {
            ways_to.entry(candidate.node).or_default();
        }
        for (place, state) in before.iter().enumerate() {
            for way in &near[&state.candidate.node] {
                if let Some(ways) = ways_to.get_mut(&way.node) {
                    // Backwards on one lane is slower than any recording's noise.
                    ways.push((state.cost + way.cost, place, way));
                }
            }
        }
        let mut column = Vec::new();
        for candidate in &candidates {
            let mut ways = ways_to.remove(&candidate.node).unwrap_or_default();
            let best = least(&ways, |way| way.0).map(|i| ways.swap_remove(i));
            column.extend(best.map(|(cost, place, way)| State {
                candidate: *candidate,
                cost: cost + emission(candidate),
                from: Some((place, way.way.clone())),
            }));
        }
        if column.is_empty() {
            let best = before.iter().min_by(|a, b| a.cost.total_cmp(&b.cost));
            let straight = |c: &&Candidate| c.turn;
            let to = candidates
                .iter()
                .min_by(|a, b| straight(a).total_cmp(&straight(b)));
            let id = |c: Option<&Candidate>| c.map_or(0, |c| self.driven(c.node).lanelet);
            return Err(RouteError::Jumps {
                from: id(best.map(|s| &s.candidate)),
                to: id(to),
            });
        }
        Ok(column)
    }

    /// Every lane within a few steps, with the cheapest way to it.
    fn reach(&self, from: NodeIndex) -> Vec<Reached> {
        let mut all = vec![Reached {
            node: from,
            cost: 0.0,
            way: Vec::new(),
        }];
        let mut edge = vec![0];
        for _ in 0..MAX_HOPS {
            let mut next = Vec::new();
            if all.len() > MOST_LANES {
                break;
            }
            for place in edge {
                for e in self.graph.edges(all[place].node) {
                    let more = match e.weight().step {
                        Step::On => ON,
                        Step::Change(_) => CHANGE,
                    };
                    let cost = all[place].cost + more;
                    let mut way = all[place].way.clone();
                    way.push(e.target());
                    let found = Reached {
                        node: e.target(),
                        cost,
                        way,
                    };
                    match all.iter().position(|r| r.node == e.target()) {
                        Some(known) if all[known].cost <= cost + COST_TOLERANCE => {}
                        Some(known) => {
                            all[known] = found;
                            next.push(known);
                        }
                        None => {
                            next.push(all.len());
                            all.push(found);
                        }
                    }
                }
            }
            edge = next;
        }
        all
    }

    /// The lanes of the cheapest sequence, with its arc lengths on the first and the last lane.
    fn trace(&self, columns: &[Vec<State>]) -> (Vec<LegLane>, f64, f64) {
        let Some(last) = columns.last() else {
            return (Vec::new(), 0.0, 0.0);
        };
        let mut place = least(last, |state| state.cost).unwrap_or(0);
        let until = last[place].candidate.s;
        let mut ways: Vec<(&Candidate, &[NodeIndex])> = Vec::new();
        for column in columns.iter().rev() {
            let state = &column[place];
            let (before, way) = match &state.from {
                Some((before, way)) => (*before, way.as_slice()),
                None => (0, [].as_slice()),
            };
            ways.push((&state.candidate, way));
            place = before;
        }
        ways.reverse();
        let from = ways[0].0;
        let mut parts = vec![LegLane {
            node: from.node,
            change: None,
        }];
        for (candidate, way) in ways {
            for &node in way {
                let before = parts[parts.len() - 1].node;
                let change = self.side(before, node).map(|side| {
                    let length = self.length(self.graph[node]);
                    // On a lane that was only passed, the change takes all of it.
                    let share = |s: f64| (s / length).clamp(0.0, 1.0);
                    if node == candidate.node {
                        (
                            side,
                            share(candidate.s - CROSSING),
                            share(candidate.s + CROSSING),
                        )
                    } else {
                        (side, 0.0, 1.0)
                    }
                });
                parts.push(LegLane { node, change });
            }
        }
        (parts, from.s, until)
    }

    fn side(&self, from: NodeIndex, to: NodeIndex) -> Option<Side> {
        let edge = self.graph.find_edge(from, to)?;
        match self.graph[edge].step {
            Step::On => None,
            Step::Change(side) => Some(side),
        }
    }
}

/// A lane that can be reached, the cost, and the lanes on the way, the last included.
struct Reached {
    node: NodeIndex,
    cost: f64,
    way: Vec<NodeIndex>,
}

impl State {
    fn first(candidate: Candidate) -> Self {
        Self {
            cost: emission(&candidate),
            candidate,
            from: None,
        }
    }
}

/// What it costs to be on a lane: the turn against it and the offset from its middle.
fn emission(candidate: &Candidate) -> f64 {
    (candidate.turn / TURN).powi(2) + (candidate.d / OFFSET).powi(2)
}

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

/// The tree of a network. It follows from the lanelets, so it says nothing about equality.
#[derive(Debug, Clone, Default)]
pub struct Index(OnceLock<RTree<Boxed>>);

/// A lanelet's box with its place in the network.
type Boxed = GeomWithData<Rectangle<[f64; 2]>, usize>;

impl PartialEq for Index {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

/// Boxes are wider by this, metres: a point on a border is on the lanelet.
const BORDER: f64 = 1e-3;

impl Index {
    fn tree(&self, lanelets: &[Lanelet]) -> &RTree<Boxed> {
        self.0.get_or_init(|| {
            let boxed = |(place, lanelet): (usize, &Lanelet)| {
                let points = lanelet.left.points.iter().chain(&lanelet.right.points);
                let bounds = Bounds::from_points(points)?;
                let [min, max] = [bounds.min, bounds.max].map(|p| [p.x, p.y]);
                let wide =
                    Rectangle::from_corners(min.map(|c| c - BORDER), max.map(|c| c + BORDER));
                Some(GeomWithData::new(wide, place))
            };
            RTree::bulk_load(lanelets.iter().enumerate().filter_map(boxed).collect())
        })
    }

    /// Places of the lanelets whose boxes meet `bounds`, in the file's order.
    fn near(&self, lanelets: &[Lanelet], bounds: &Bounds) -> Vec<usize> {
        let [min, max] = [bounds.min, bounds.max].map(|p| [p.x, p.y]);
        let envelope = AABB::from_corners(min, max);
        let found = self
            .tree(lanelets)
            .locate_in_envelope_intersecting(envelope);
        let mut places: Vec<usize> = found.map(|b| b.data).collect();
        places.sort_unstable();
        places
    }

    /// The lanelet nearest to `p` by their borders, with its distance in metres.
    fn nearest(&self, lanelets: &[Lanelet], p: &Point) -> Option<(usize, f64)> {
        let mut best: Option<(usize, f64)> = None;
        let order = self
            .tree(lanelets)
            .nearest_neighbor_iter_with_distance_2([p.x, p.y]);
        for (boxed, squared) in order {
            if best.is_some_and(|(_, d)| squared.sqrt() > d) {
                break;
            }
            let distance = lanelets[boxed.data].distance(p);
            if best.is_none_or(|(_, d)| distance < d) {
                best = Some((boxed.data, distance));
            }
        }
        best
    }
}

impl LaneletNetwork {
    /// Ids of the lanelets under `p`, borders included, in the file's order.
    #[must_use]
    pub fn lanelets_at(&self, p: &Point) -> Vec<i64> {
        let places = self.places_at(p).into_iter();
        places.map(|place| self.lanelets[place].id).collect()
    }

    /// Ids of the lanelets that a body stands on with more than a border, in the file's order.
    #[must_use]
    pub fn lanelets_under(&self, body: &Placed<'_>) -> Vec<i64> {
        let places = self.places_under(body).into_iter();
        places.map(|place| self.lanelets[place].id).collect()
    }

    /// The lanelet nearest to `p` and how far it is, metres; 0 on it, nothing without lanelets.
    #[must_use]
    pub fn nearest_lanelet(&self, p: &Point) -> Option<(i64, f64)> {
        let (place, distance) = self.index.nearest(&self.lanelets, p)?;
        Some((self.lanelets[place].id, distance))
    }

    pub(super) fn places_at(&self, p: &Point) -> Vec<usize> {
        let mut places = self
            .index
            .near(&self.lanelets, &Bounds { min: *p, max: *p });
        places.retain(|&place| contains(&self.lanelets[place].ring(), p));
        places
    }

    pub(super) fn places_under(&self, body: &Placed<'_>) -> Vec<usize> {
        let mut places = self.index.near(&self.lanelets, &body.bounds());
        places.retain(|&place| body.overlaps_ring(&self.lanelets[place].ring()));
        places
    }
}

/// The road as one area: to be built once and asked often.
#[derive(Debug, Clone)]
pub struct DrivableArea {
    area: Area,
}

/// Gaps between lanelets up to this width are road, metres: maps have gaps of centimetres between
/// neighbours and at joints, and no vehicle would notice. Outer borders stay where they are.
const GAP: f64 = 0.1;

impl LaneletNetwork {
    /// The area of the lanelets that `user` may use, or of all.
    #[must_use]
    pub fn drivable_area(&self, user: Option<RoadUser>) -> DrivableArea {
        let lanelets = self.lanelets.iter();
        let rings: Vec<Vec<Point>> = lanelets
            .filter(|l| user.is_none_or(|user| l.may_use(user)))
            .map(Lanelet::ring)
            .collect();
        DrivableArea {
            area: Area::union(rings.iter().map(Vec::as_slice), GAP),
        }
    }
}

impl Lanelet {
    /// Whether `user` may use it in at least one direction; all may where the file names none.
    #[must_use]
    pub fn may_use(&self, user: RoadUser) -> bool {
        let unnamed = self.users_one_way.is_empty() && self.users_bidirectional.is_empty();
        unnamed || includes(&self.users_one_way, user) || includes(&self.users_bidirectional, user)
    }
}

/// Whether `users` include `user`: every motor vehicle is a `vehicle`.
pub(super) fn includes(users: &[RoadUser], user: RoadUser) -> bool {
    let motor = !matches!(
        user,
        RoadUser::Bicycle | RoadUser::Pedestrian | RoadUser::Train
    );
    users.contains(&user) || motor && users.contains(&RoadUser::Vehicle)
}

impl DrivableArea {
    /// Whether all of `body` is on the road; what sticks out by less than a millimetre is.
    #[must_use]
    pub fn covers(&self, body: &Placed<'_>) -> bool {
        self.area.covers(body)
    }

    /// Where `body` leaves the road; `None` if all of it is on the road.
    #[must_use]
    pub fn outside(&self, body: &Placed<'_>) -> Option<Outside> {
        self.area.outside(body)
    }

    /// Whether `p` is on the road, its border included.
    #[must_use]
    pub fn contains(&self, p: &Point) -> bool {
        self.area.contains(p)
    }

    /// The road's border, which no two lanelets share: rings (not closed) with the road on their left.
    pub fn border(&self) -> impl Iterator<Item = Vec<Point>> {
        self.area.border()
    }
}
