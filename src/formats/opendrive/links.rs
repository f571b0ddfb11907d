//! Roads as they are written: numbered, linked to each other, and with junctions where several meet.

use std::collections::{BTreeMap, HashMap, HashSet};

use super::graph::{Edge, Graph, Mode};
use super::road::Road;
use nearmiss_base::geometry::Point;
use nearmiss_scene::scenario::{Lanelet, LaneletNetwork};

/// What a road continues into, or what it continues.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Link {
    /// Nothing.
    #[default]
    None,
    /// A road: the beginning of a successor, the end of a predecessor.
    Road(usize),
    /// A junction.
    Junction(usize),
}

/// A road with its links; ids count from 1.
#[derive(Debug, Clone)]
pub struct LinkedRoad {
    /// Its geometry.
    pub road: Road,
    /// Its id.
    pub id: usize,
    /// The junction of which it is a connecting road.
    pub junction: Option<usize>,
    /// What leads into it.
    pub predecessor: Link,
    /// What it leads into.
    pub successor: Link,
    /// The lanes of the predecessor, by its own lanes, counted from the left.
    pub lanes_before: Vec<Option<usize>>,
    /// The lanes of the successor.
    pub lanes_behind: Vec<Option<usize>>,
    /// A piece cut off the beginning of another road for a junction.
    pub is_cut: bool,
}

/// A junction.
#[derive(Debug, Clone, PartialEq)]
pub struct Junction {
    /// Its id.
    pub id: usize,
    /// Its name.
    pub name: String,
    /// How roads continue in it.
    pub connections: Vec<Connection>,
}

/// Incoming road, connecting road, and the lanes that continue, counted from the left.
pub type Connection = (usize, usize, Vec<(usize, usize)>);

/// A network of roads.
#[derive(Debug, Default)]
pub struct Roads {
    /// All roads.
    pub roads: Vec<LinkedRoad>,
    /// All junctions.
    pub junctions: Vec<Junction>,
    /// Pairs of lanelets that continue each other but do not meet, by id, with the gap in metres.
    pub apart: Vec<(i64, i64, f64)>,
}

/// Ends of lanelets farther apart than this do not meet, metres.
const MEET: f64 = 0.008;

/// Narrower lanes end, metres.
const NARROW: f64 = 1e-4;

/// What is cut off a road for a junction: at most so many metres, and such a share of it.
const CUT: (f64, f64) = (0.5, 0.2);

/// Links roads as the lanelets tell.
pub fn link(network: &LaneletNetwork, roads: Vec<Road>) -> Roads {
    let mut lane_of = HashMap::new();
    for (r, road) in roads.iter().enumerate() {
        for (lane, place) in road.lanelets.iter().enumerate() {
            lane_of.insert(network.lanelets[*place].id, (r, lane, *place));
        }
    }
    let (edges, apart) = edges(network, &roads, &lane_of);
    let turning = network
        .intersections
        .iter()
        .flat_map(|i| &i.incomings)
        .flat_map(|i| [&i.right, &i.straight, &i.left].into_iter().flatten());
    let inside: HashSet<usize> = turning
        .filter_map(|id| lane_of.get(id).map(|(road, ..)| *road))
        .collect();
    let graph = Graph::new(edges, &inside);
    let mut written = Roads {
        apart,
        ..Roads::default()
    };
    for (place, road) in roads.into_iter().enumerate() {
        let lanes = road.lanelets.len();
        written.roads.push(LinkedRoad {
            road,
            id: place + 1,
            junction: None,
            predecessor: Link::None,
            successor: Link::None,
            lanes_before: vec![None; lanes],
            lanes_behind: vec![None; lanes],
            is_cut: false,
        });
    }
    let junctions = junctions(network, &graph, &lane_of);
    for (place, node) in graph.nodes.iter().enumerate() {
        match (node.mode, junctions.get(&place)) {
            (Mode::Cut, Some(junction)) => written.cut(&graph, place, *junction),
            (Mode::Direct, _) => {
                let edge = &graph.edges[node.edges[0]];
                let whole = |r: &usize| graph.connecting.contains(r);
                if !whole(&edge.from) && !whole(&edge.to) {
                    written.direct(edge);
                }
            }
            _ => {}
        }
    }
    written.connect(&graph, &junctions);
    written
}

type Lanes = HashMap<i64, (usize, usize, usize)>;

fn edges(
    network: &LaneletNetwork,
    roads: &[Road],
    lane_of: &Lanes,
) -> (Vec<Edge>, Vec<(i64, i64, f64)>) {
    let mut pairs: BTreeMap<(usize, usize), Vec<(usize, usize)>> = BTreeMap::new();
    let mut apart = Vec::new();
    for lanelet in &network.lanelets {
        let Some((from, lane, place)) = lane_of.get(&lanelet.id).copied() else {
            continue;
        };
        // Of several lanelets with one id, the first is meant.
        if !std::ptr::eq(lanelet, &network.lanelets[place]) {
            continue;
        }
        for successor in &lanelet.successors {
            let Some((to, into, other)) = lane_of.get(successor).copied() else {
                continue;
            };
            let other = &network.lanelets[other];
            let corners = [0, 1].map(|side| {
                let end = roads[from].corner(lane + side, true);
                (end - roads[to].corner(into + side, false)).norm()
            });
            let gap = corners.into_iter().fold(gap(lanelet, other), f64::max);
            let narrow = || {
                let before = roads[from].widths[lane]
                    .0
                    .last()
                    .is_some_and(|w| w.1 < NARROW);
                before
                    || roads[to].widths[into]
                        .0
                        .first()
                        .is_some_and(|w| w.1 < NARROW)
            };
            if gap > MEET || narrow() {
                apart.push((lanelet.id, other.id, gap));
                continue;
            }
            let lanes = pairs.entry((from, to)).or_default();
            // One lane continues one lane of another road.
            if !lanes.iter().any(|(a, b)| *a == lane || *b == into) {
                lanes.push((lane, into));
            }
        }
    }
    let edge = |((from, to), lanes)| Edge { from, to, lanes };
    (pairs.into_iter().map(edge).collect(), apart)
}

/// How far the end of a lanelet is from the beginning of another one, metres.
fn gap(lanelet: &Lanelet, next: &Lanelet) -> f64 {
    let away = |a: Option<&Point>, b: Option<&Point>| match (a, b) {
        (Some(a), Some(b)) => (a - b).norm(),
        _ => f64::INFINITY,
    };
    let left = away(lanelet.left.points.last(), next.left.points.first());
    left.max(away(lanelet.right.points.last(), next.right.points.first()))
}

/// The ids of the junctions at nodes; those of one intersection are one.
fn junctions(network: &LaneletNetwork, graph: &Graph, lane_of: &Lanes) -> BTreeMap<usize, usize> {
    let mut of_node: BTreeMap<usize, usize> = BTreeMap::new();
    // Nodes at both ends of a connecting road are one junction, also where no other road meets there.
    let mut same: Vec<Vec<usize>> = Vec::new();
    for road in &graph.connecting {
        let touches = |n: &&usize| {
            let node = &graph.nodes[**n];
            node.ending.contains(road) || node.beginning.contains(road)
        };
        let all: Vec<usize> = (0..graph.nodes.len()).collect();
        same.push(all.iter().filter(touches).copied().collect());
    }
    for intersection in &network.intersections {
        let roads = intersection
            .incomings
            .iter()
            .flat_map(|i| [&i.right, &i.straight, &i.left].into_iter().flatten())
            .filter_map(|id| lane_of.get(id).map(|(road, ..)| *road));
        let roads: HashSet<usize> = roads.filter(|r| graph.connecting.contains(r)).collect();
        let nodes = graph.nodes.iter().enumerate().filter(|(_, n)| {
            n.ending
                .iter()
                .chain(&n.beginning)
                .any(|r| roads.contains(r))
        });
        same.push(nodes.map(|(n, _)| n).collect());
    }
    let cut = graph
        .nodes
        .iter()
        .enumerate()
        .filter(|(_, n)| n.mode == Mode::Cut);
    same.extend(cut.map(|(n, _)| vec![n]));
    for group in same {
        let Some(first) = group.iter().min().copied() else {
            continue;
        };
        let known: HashSet<usize> = group
            .iter()
            .filter_map(|n| of_node.get(n).copied())
            .collect();
        let label = known.iter().min().copied().unwrap_or(first).min(first);
        for junction in of_node.values_mut() {
            if known.contains(junction) {
                *junction = label;
            }
        }
        of_node.extend(group.into_iter().map(|n| (n, label)));
    }
    // Numbered in order, from 1.
    let labels: Vec<usize> = of_node.values().copied().collect();
    let mut order: Vec<usize> = labels.clone();
    order.sort_unstable();
    order.dedup();
    let number = |label: usize| order.partition_point(|l| *l < label) + 1;
    of_node
        .into_iter()
        .map(|(n, label)| (n, number(label)))
        .collect()
}

impl Roads {
    fn junction(&mut self, id: usize) -> &mut Junction {
        let place = match self.junctions.iter().position(|j| j.id == id) {
            Some(place) => place,
            None => {
                self.junctions.push(Junction {
                    id,
                    name: format!("junction {id}"),
                    connections: Vec::new(),
                });
                self.junctions.len() - 1
            }
        };
        &mut self.junctions[place]
    }

    /// One road continues into another.
    fn direct(&mut self, edge: &Edge) {
        let (from, to) = (self.roads[edge.from].id, self.roads[edge.to].id);
        self.roads[edge.from].successor = Link::Road(to);
        self.roads[edge.to].predecessor = Link::Road(from);
        for (a, b) in &edge.lanes {
            self.roads[edge.from].lanes_behind[*a] = Some(*b);
            self.roads[edge.to].lanes_before[*b] = Some(*a);
        }
    }

    /// Cuts a connecting road for each edge of a node off the roads that begin there.
    fn cut(&mut self, graph: &Graph, place: usize, junction: usize) {
        let node = &graph.nodes[place];
        for road in &node.beginning {
            let length = self.roads[*road].road.length();
            let (head, tail) = self.roads[*road].road.split(CUT.0.min(CUT.1 * length));
            let to = self.roads[*road].id;
            self.roads[*road].road = tail;
            self.roads[*road].predecessor = Link::Junction(junction);
            let edges = node.edges.iter().map(|e| &graph.edges[*e]);
            for edge in edges.filter(|e| e.to == *road) {
                let lanes = edge.lanes.iter().map(|(_, b)| *b);
                let (Some(first), Some(last)) = (lanes.clone().min(), lanes.max()) else {
                    continue;
                };
                let from = self.roads[edge.from].id;
                self.roads[edge.from].successor = Link::Junction(junction);
                let id = self.roads.len() + 1;
                let mut before = vec![None; last + 1 - first];
                for (a, b) in &edge.lanes {
                    before[b - first] = Some(*a);
                }
                let links = edge.lanes.iter().map(|(a, b)| (*a, b - first)).collect();
                self.junction(junction).connections.push((from, id, links));
                self.roads.push(LinkedRoad {
                    road: head.lanes(first..last + 1),
                    id,
                    junction: Some(junction),
                    predecessor: Link::Road(from),
                    successor: Link::Road(to),
                    lanes_before: before,
                    lanes_behind: (first..=last).map(Some).collect(),
                    is_cut: true,
                });
            }
        }
    }

    /// Links the roads that are connecting roads as a whole.
    fn connect(&mut self, graph: &Graph, junctions: &BTreeMap<usize, usize>) {
        for (place, node) in graph.nodes.iter().enumerate() {
            let Some(junction) = junctions.get(&place).copied() else {
                continue;
            };
            for edge in node.edges.iter().map(|e| &graph.edges[*e]) {
                let (from, to) = (self.roads[edge.from].id, self.roads[edge.to].id);
                if graph.connecting.contains(&edge.to) {
                    self.roads[edge.from].successor = Link::Junction(junction);
                    let road = &mut self.roads[edge.to];
                    road.predecessor = Link::Road(from);
                    road.junction = Some(junction);
                    for (a, b) in &edge.lanes {
                        road.lanes_before[*b] = Some(*a);
                    }
                    let links = edge.lanes.clone();
                    self.junction(junction).connections.push((from, to, links));
                } else if graph.connecting.contains(&edge.from) {
                    self.roads[edge.to].predecessor = Link::Junction(junction);
                    let road = &mut self.roads[edge.from];
                    road.successor = Link::Road(to);
                    road.junction = Some(junction);
                    for (a, b) in &edge.lanes {
                        road.lanes_behind[*a] = Some(*b);
                    }
                }
            }
        }
    }
}
