//! Which roads meet at their ends, and which of them are the connecting roads of a junction.

use std::collections::{BTreeMap, HashMap, HashSet};

/// A road that continues into another one.
#[derive(Debug, Clone, PartialEq)]
pub struct Edge {
    /// The road that ends.
    pub from: usize,
    /// The road that begins there.
    pub to: usize,
    /// Lanes that continue, counted from the left, of either road.
    pub lanes: Vec<(usize, usize)>,
}

/// A place where roads end and begin.
#[derive(Debug, Clone, Default)]
pub struct Node {
    /// Places of its edges.
    pub edges: Vec<usize>,
    /// Roads that end here.
    pub ending: Vec<usize>,
    /// Roads that begin here.
    pub beginning: Vec<usize>,
    /// How its roads are connected.
    pub mode: Mode,
}

/// How the roads that meet at a node are connected.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Mode {
    /// One road continues into one: no junction is needed.
    #[default]
    Direct,
    /// The roads that begin here are connecting roads.
    Beginning,
    /// The roads that end here are connecting roads.
    Ending,
    /// Connecting roads are cut off the roads that begin here.
    Cut,
}

/// All nodes, with the connecting roads found.
#[derive(Debug, Default)]
pub struct Graph {
    /// The edges.
    pub edges: Vec<Edge>,
    /// The nodes.
    pub nodes: Vec<Node>,
    /// Roads that are connecting roads as a whole.
    pub connecting: HashSet<usize>,
    /// The node at the beginning of a road.
    start: HashMap<usize, usize>,
    /// The node at its end.
    end: HashMap<usize, usize>,
}

impl Graph {
    /// The graph of these edges; `inside` tells the roads within intersections.
    pub fn new(edges: Vec<Edge>, inside: &HashSet<usize>) -> Self {
        let mut graph = Self {
            edges,
            ..Self::default()
        };
        graph.gather();
        let simple = |n: &Node| n.ending.len() == 1 && n.beginning.len() == 1;
        let open: Vec<usize> = (0..graph.nodes.len())
            .filter(|n| !simple(&graph.nodes[*n]))
            .collect();
        for node in &open {
            graph.nodes[*node].mode = Mode::Cut;
        }
        let mut decided = BTreeMap::new();
        for hinted in [true, false] {
            for node in &open {
                if decided.contains_key(node) {
                    continue;
                }
                let within = |roads: &[usize]| roads.iter().all(|r| inside.contains(r));
                let Node {
                    ending, beginning, ..
                } = &graph.nodes[*node];
                let (ends, begins) = (within(ending), within(beginning));
                let wishes: &[Mode] = match (hinted, begins, ends) {
                    (true, true, false) => &[Mode::Beginning],
                    (true, false, true) => &[Mode::Ending],
                    (true, ..) => &[],
                    (false, ..) => &[Mode::Beginning, Mode::Ending],
                };
                let possible = wishes.iter().find_map(|m| graph.with(&decided, *node, *m));
                if let Some(more) = possible {
                    decided = more;
                }
            }
        }
        for (node, mode) in decided {
            graph.nodes[node].mode = mode;
            graph.connecting.extend(graph.nodes[node].connecting(mode));
        }
        graph
    }

    /// Joins the edges that share the end or the beginning of a road.
    fn gather(&mut self) {
        let mut of_edge: Vec<usize> = (0..self.edges.len()).collect();
        let mut first: HashMap<(bool, usize), usize> = HashMap::new();
        fn root(of: &mut [usize], mut i: usize) -> usize {
            while of[i] != i {
                of[i] = of[of[i]];
                i = of[i];
            }
            i
        }
        for (i, edge) in self.edges.iter().enumerate() {
            for side in [(false, edge.from), (true, edge.to)] {
                let other = *first.entry(side).or_insert(i);
                let (a, b) = (root(&mut of_edge, i), root(&mut of_edge, other));
                of_edge[a.max(b)] = a.min(b);
            }
        }
        let mut places: BTreeMap<usize, usize> = BTreeMap::new();
        for (i, edge) in self.edges.iter().enumerate() {
            let root = root(&mut of_edge, i);
            let place = *places.entry(root).or_insert_with(|| {
                self.nodes.push(Node::default());
                self.nodes.len() - 1
            });
            let node = &mut self.nodes[place];
            node.edges.push(i);
            if !node.ending.contains(&edge.from) {
                node.ending.push(edge.from);
            }
            if !node.beginning.contains(&edge.to) {
                node.beginning.push(edge.to);
            }
            self.end.insert(edge.from, place);
            self.start.insert(edge.to, place);
        }
    }

    /// The node at the other end of a connecting road of a node.
    fn beyond(&self, road: usize, mode: Mode) -> Option<usize> {
        match mode {
            Mode::Beginning => self.end.get(&road).copied(),
            _ => self.start.get(&road).copied(),
        }
    }

    /// What is decided with one more node in this mode and all that follows from it; `None` if that cannot be.
    fn with(
        &self,
        decided: &BTreeMap<usize, Mode>,
        node: usize,
        mode: Mode,
    ) -> Option<BTreeMap<usize, Mode>> {
        let mut all = decided.clone();
        let mut open = vec![(node, mode)];
        while let Some((at, mode)) = open.pop() {
            match all.insert(at, mode) {
                Some(before) if before != mode => return None,
                Some(_) => continue,
                None => {}
            }
            let node = &self.nodes[at];
            if !self.is_single(node, mode) {
                return None;
            }
            for road in node.connecting(mode) {
                let other = self.beyond(road, mode)?;
                if other == at {
                    return None;
                }
                if self.nodes[other].mode != Mode::Direct {
                    let opposite = match mode {
                        Mode::Beginning => Mode::Ending,
                        _ => Mode::Beginning,
                    };
                    open.push((other, opposite));
                }
            }
        }
        let roads = all.iter().map(|(n, mode)| self.nodes[*n].connecting(*mode));
        let roads: HashSet<usize> = roads.flatten().collect();
        // A connecting road leads to roads that are none.
        let apart = |e: &Edge| !(roads.contains(&e.from) && roads.contains(&e.to));
        self.edges.iter().all(apart).then_some(all)
    }

    /// Whether each connecting road of a node continues only one road there.
    fn is_single(&self, node: &Node, mode: Mode) -> bool {
        let count = |road: usize| {
            let edges = node.edges.iter().map(|e| &self.edges[*e]);
            let own = edges.filter(|e| match mode {
                Mode::Beginning => e.to == road,
                _ => e.from == road,
            });
            own.count()
        };
        node.connecting(mode).into_iter().all(|r| count(r) == 1)
    }
}

impl Node {
    /// Roads that are connecting roads in a mode.
    pub fn connecting(&self, mode: Mode) -> Vec<usize> {
        match mode {
            Mode::Beginning => self.beginning.clone(),
            Mode::Ending => self.ending.clone(),
            Mode::Direct | Mode::Cut => Vec::new(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn edges(all: &[(usize, usize)]) -> Vec<Edge> {
        let edge = |&(from, to): &(usize, usize)| Edge {
            from,
            to,
            lanes: vec![(0, 0)],
        };
        all.iter().map(edge).collect()
    }

    #[test]
    fn one_after_the_other_needs_no_junction() {
        let graph = Graph::new(edges(&[(0, 1), (1, 2)]), &HashSet::new());
        assert_eq!(graph.nodes.len(), 2);
        assert!(graph.nodes.iter().all(|n| n.mode == Mode::Direct));
    }

    #[test]
    fn turns_between_roads_are_connecting_roads() {
        // 0 and 1 lead in, 2 to 5 turn, 6 and 7 lead out.
        let all = [
            (0, 2),
            (0, 3),
            (1, 4),
            (1, 5),
            (2, 6),
            (4, 6),
            (3, 7),
            (5, 7),
        ];
        let graph = Graph::new(edges(&all), &HashSet::new());
        assert_eq!(graph.connecting, HashSet::from([2, 3, 4, 5]));
    }

    #[test]
    fn a_fork_that_ends_is_cut() {
        let graph = Graph::new(edges(&[(0, 1), (0, 2)]), &HashSet::new());
        assert_eq!(graph.nodes[0].mode, Mode::Cut);
        assert!(graph.connecting.is_empty());
    }

    #[test]
    fn forks_in_a_row_do_not_connect_connecting_roads() {
        let all = [
            (0, 1),
            (0, 2),
            (1, 3),
            (1, 4),
            (3, 5),
            (4, 5),
            (2, 6),
            (5, 7),
        ];
        let graph = Graph::new(edges(&all), &HashSet::new());
        for edge in &graph.edges {
            let both = [edge.from, edge.to]
                .iter()
                .all(|r| graph.connecting.contains(r));
            assert!(!both, "{edge:?}");
        }
    }
}
