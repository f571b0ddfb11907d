//! The lanelet network as a road: what lies where, lanes, the graph, routes, the drivable area.

mod lane;
mod lane_relation;
mod matching;
mod route;

pub use lane::Lane;
pub use lane_relation::{LaneRelation, LaneRelations};
pub use matching::DrivableArea;
pub(super) use matching::Index;
pub use route::{Destination, Leg, Route, RouteError};

use nearmiss_base::geometry::{angle_between, normalize_angle};
use petgraph::graph::{DiGraph, NodeIndex};
use petgraph::visit::EdgeRef;

use crate::scenario::{Lanelet, LaneletNetwork, RoadUser};
use matching::includes;

/// Costs and distances that differ by less are alike, metres: rounding must not choose between them.
const COST_TOLERANCE: f64 = 1e-6;

/// Place of the item with the least cost; of several alike the first, so that rounding does not choose.
fn least<T>(items: &[T], cost: impl Fn(&T) -> f64) -> Option<usize> {
    let mut best: Option<(usize, f64)> = None;
    for (place, item) in items.iter().enumerate() {
        let cost = cost(item);
        if best.is_none_or(|(_, least)| cost < least - COST_TOLERANCE) {
            best = Some((place, cost));
        }
    }
    best.map(|(place, _)| place)
}

/// Which way a lanelet is driven.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Direction {
    /// As its borders are drawn.
    Along,
    /// The other way, where that is allowed.
    Against,
}

/// A lanelet driven in a direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct DirectedLanelet {
    /// Its id.
    pub lanelet: i64,
    /// Which way.
    pub direction: Direction,
}

/// The sides of a lane, seen in driving direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Side {
    /// Left.
    Left,
    /// Right.
    Right,
}

/// How one node leads to another.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Step {
    /// Straight on, from end to beginning.
    On,
    /// A lane change.
    Change(Side),
}

/// A step with its cost, metres.
#[derive(Debug, Clone, Copy)]
struct Edge {
    pub step: Step,
    pub cost: f64,
}

/// A lanelet, by its place in the network, driven in a direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
struct Node {
    pub place: usize,
    pub direction: Direction,
    /// Whether it is reached only sideways from the start: what lies behind the start there is not ahead.
    pub first_row: bool,
}

/// The lanes that a road user may drive, and how they are connected.
///
/// Lane changes lead to neighbours that may be driven the same way. The cost of a way is the length of
/// the lanelets that it drives to their ends, and 30 m for each lane change, more on short lanelets.
/// Markings are not asked: whether a line may be crossed is a rule of the road, not of the map.
#[derive(Debug, Clone)]
pub struct LaneGraph<'a> {
    network: &'a LaneletNetwork,
    /// By place; `None` for lanelets without length.
    lanes: Vec<Option<Lane>>,
    graph: DiGraph<Node, Edge>,
    /// By place, direction and row.
    nodes: Vec<[[Option<NodeIndex>; 2]; 2]>,
}

/// What a lane change costs, metres of detour.
const LANE_CHANGE: f64 = 30.0;

/// A lane change on a shorter lanelet costs more, as the path has to cross within it, metres.
const CHANGE_LENGTH: f64 = 40.0;

impl LaneletNetwork {
    /// The graph of the lanes that `user` may drive, or of all.
    #[must_use]
    pub fn lane_graph(&self, user: Option<RoadUser>) -> LaneGraph<'_> {
        LaneGraph::new(self, user)
    }
}

/// Whether `user` may drive a lanelet along and against its direction.
fn directions(lanelet: &Lanelet, user: Option<RoadUser>) -> [bool; 2] {
    let both = &lanelet.users_bidirectional;
    match user {
        None => [true, !both.is_empty()],
        Some(user) => [lanelet.may_use(user), includes(both, user)],
    }
}

impl<'a> LaneGraph<'a> {
    fn new(network: &'a LaneletNetwork, user: Option<RoadUser>) -> Self {
        let lanes: Vec<Option<Lane>> = network.lanelets.iter().map(Lane::from_lanelet).collect();
        let mut graph = DiGraph::new();
        let mut nodes = vec![[[None; 2]; 2]; lanes.len()];
        for (place, lanelet) in network.lanelets.iter().enumerate() {
            let may = directions(lanelet, user);
            for direction in [Direction::Along, Direction::Against] {
                if lanes[place].is_none() || !may[direction as usize] {
                    continue;
                }
                for first_row in [false, true] {
                    let node = Node {
                        place,
                        direction,
                        first_row,
                    };
                    nodes[place][direction as usize][usize::from(first_row)] =
                        Some(graph.add_node(node));
                }
            }
        }
        let mut built = Self {
            network,
            lanes,
            graph,
            nodes,
        };
        built.connect();
        built
    }

    fn connect(&mut self) {
        for from in self.graph.node_indices().collect::<Vec<_>>() {
            let node = self.graph[from];
            let length = self.length(node);
            let lanelet = &self.network.lanelets[node.place];
            let on = match node.direction {
                Direction::Along => &lanelet.successors,
                Direction::Against => &lanelet.predecessors,
            };
            for &id in on {
                let to = self
                    .network
                    .place(id)
                    .and_then(|place| self.node(place, node.direction, false));
                let edge = Edge {
                    step: Step::On,
                    cost: length,
                };
                if let Some(to) = to {
                    self.graph.update_edge(from, to, edge);
                }
            }
            let sides = [
                (lanelet.adjacent_left, Side::Left, Side::Right),
                (lanelet.adjacent_right, Side::Right, Side::Left),
            ];
            for (adjacent, along, against) in sides {
                let Some(adjacent) = adjacent else { continue };
                let direction = if adjacent.same_direction {
                    node.direction
                } else {
                    node.direction.other()
                };
                let to = self
                    .network
                    .place(adjacent.id)
                    .filter(|&p| p != node.place)
                    .and_then(|place| self.node(place, direction, node.first_row));
                let side = if node.direction == Direction::Along {
                    along
                } else {
                    against
                };
                let edge = Edge {
                    step: Step::Change(side),
                    cost: LANE_CHANGE + 2.0 * (CHANGE_LENGTH - length).max(0.0),
                };
                if let Some(to) = to {
                    self.graph.update_edge(from, to, edge);
                }
            }
        }
    }

    /// The network it was made of.
    #[must_use]
    pub fn network(&self) -> &'a LaneletNetwork {
        self.network
    }

    /// The lane of a lanelet, as it is driven; `None` if it may not be driven so.
    #[must_use]
    pub fn lane(&self, driven: DirectedLanelet) -> Option<Lane> {
        let place = self.network.place(driven.lanelet)?;
        let node = self.node(place, driven.direction, false)?;
        self.lane_of(self.graph[node])
    }

    /// What follows a lanelet, straight on.
    #[must_use]
    pub fn successors(&self, driven: DirectedLanelet) -> Vec<DirectedLanelet> {
        self.follow(driven, |step| step == Step::On)
    }

    /// The lane beside a lanelet that may be changed to.
    #[must_use]
    pub fn neighbour(&self, driven: DirectedLanelet, side: Side) -> Option<DirectedLanelet> {
        let found = self.follow(driven, |step| step == Step::Change(side));
        found.first().copied()
    }

    fn follow(
        &self,
        driven: DirectedLanelet,
        wanted: impl Fn(Step) -> bool,
    ) -> Vec<DirectedLanelet> {
        let node = self
            .network
            .place(driven.lanelet)
            .and_then(|place| self.node(place, driven.direction, false));
        let Some(node) = node else { return Vec::new() };
        let edges = self.graph.edges(node).filter(|e| wanted(e.weight().step));
        let mut found: Vec<DirectedLanelet> = edges.map(|e| self.driven(e.target())).collect();
        found.sort_unstable();
        found
    }

    fn node(&self, place: usize, direction: Direction, first_row: bool) -> Option<NodeIndex> {
        self.nodes[place][direction as usize][usize::from(first_row)]
    }

    fn driven(&self, node: NodeIndex) -> DirectedLanelet {
        let node = self.graph[node];
        DirectedLanelet {
            lanelet: self.network.lanelets[node.place].id,
            direction: node.direction,
        }
    }

    fn length(&self, node: Node) -> f64 {
        self.lanes[node.place].as_ref().map_or(0.0, Lane::length)
    }

    fn lane_of(&self, node: Node) -> Option<Lane> {
        let lane = self.lanes[node.place].as_ref()?;
        Some(match node.direction {
            Direction::Along => lane.clone(),
            Direction::Against => lane.reversed(),
        })
    }

    /// Heading of a lane as it is driven, at arc length `s` of its driven centre line, radians.
    fn heading(&self, node: Node, s: f64) -> f64 {
        let Some(lane) = &self.lanes[node.place] else {
            return 0.0;
        };
        match node.direction {
            Direction::Along => lane.centre().pose_at(s).heading,
            Direction::Against => {
                let back = lane.centre().pose_at(lane.length() - s).heading;
                normalize_angle(back + std::f64::consts::PI)
            }
        }
    }

    /// The steps from `node` straight on, or straight back, the least turning first.
    ///
    /// Lanelets of a crossing begin alike, so what counts is how far they turn within [`TURN_LOOKAHEAD`] metres.
    fn straightest(&self, from: NodeIndex, forward: bool) -> Vec<NodeIndex> {
        let side = if forward {
            petgraph::Outgoing
        } else {
            petgraph::Incoming
        };
        let edges = self.graph.edges_directed(from, side);
        let on = edges.filter(|e| e.weight().step == Step::On);
        let others = on.map(|e| if forward { e.target() } else { e.source() });
        let here = self.graph[from];
        let turn = |other: &NodeIndex| {
            let there = self.graph[*other];
            let (a, b) = if forward {
                let end = self.heading(here, self.length(here));
                (
                    end,
                    self.heading(there, TURN_LOOKAHEAD.min(self.length(there))),
                )
            } else {
                let back = (self.length(there) - TURN_LOOKAHEAD).max(0.0);
                (self.heading(there, back), self.heading(here, 0.0))
            };
            angle_between(a, b).abs()
        };
        let mut found: Vec<(f64, NodeIndex)> = others
            .filter(|&o| !self.graph[o].first_row)
            .map(|o| ((turn(&o) / SAME_TURN).round(), o))
            .collect();
        found.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        found.into_iter().map(|(_, node)| node).collect()
    }
}

/// How far ahead the turn of a lanelet is measured, metres.
const TURN_LOOKAHEAD: f64 = 30.0;

/// Turns that differ by less are alike, radians: which of two equal forks is taken must not depend on rounding.
const SAME_TURN: f64 = 1e-6;

impl Direction {
    fn other(self) -> Self {
        match self {
            Self::Along => Self::Against,
            Self::Against => Self::Along,
        }
    }
}
