//! A tree of bounding boxes over a sequence whose order follows space.
//!
//! For pieces of a curve or steps of a motion, where neighbours in the row are neighbours in the plane, this
//! is as good as an R-tree and cheaper to build and to ask.

use super::{Bounds, Point};

/// Boxes in their order, with the boxes around each half, each quarter and so on.
#[derive(Debug, Clone, Default)]
pub struct BoxTree {
    /// A heap: node n has the children 2n and 2n + 1, the boxes of the row are its leaves.
    nodes: Vec<Option<Bounds>>,
}

/// A tree is no deeper than its index has bits, and a search leaves at most one sibling a level.
const DEEPEST: usize = usize::BITS as usize;

impl BoxTree {
    /// The tree of a row of boxes.
    #[must_use]
    pub fn new(row: impl ExactSizeIterator<Item = Bounds>) -> Self {
        let leaves = row.len().next_power_of_two();
        let mut nodes = vec![None; 2 * leaves];
        for (place, bounds) in row.enumerate() {
            nodes[leaves + place] = Some(bounds);
        }
        for node in (1..leaves).rev() {
            let (a, b): (Option<Bounds>, Option<Bounds>) = (nodes[2 * node], nodes[2 * node + 1]);
            nodes[node] = match (a, b) {
                (Some(a), Some(b)) => Some(a.union(&b)),
                (a, b) => a.or(b),
            };
        }
        Self { nodes }
    }

    /// The box around all; `None` without boxes.
    #[must_use]
    pub fn bounds(&self) -> Option<Bounds> {
        self.nodes.get(1).copied().flatten()
    }

    /// Whether `wanted` holds for the place of any box that meets `around`.
    pub fn any_meeting(&self, around: &Bounds, mut wanted: impl FnMut(usize) -> bool) -> bool {
        let leaves = self.nodes.len() / 2;
        let mut open = [1; DEEPEST];
        let mut count = usize::from(self.bounds().is_some());
        while count > 0 {
            count -= 1;
            let node = open[count];
            if !self.nodes[node].is_some_and(|b| b.overlaps(around)) {
                continue;
            }
            if node >= leaves {
                if wanted(node - leaves) {
                    return true;
                }
                continue;
            }
            open[count] = 2 * node + 1;
            open[count + 1] = 2 * node;
            count += 2;
        }
        false
    }

    /// Visits the places of boxes near `p`, near ones first: `visit` is given a place and tells how near, in metres,
    /// a box has to be from now on.
    pub fn visit_near(&self, p: &Point, mut visit: impl FnMut(usize) -> f64) {
        let leaves = self.nodes.len() / 2;
        let far = |node: usize| self.nodes[node].map_or(f64::INFINITY, |b| b.squared_distance(p));
        let mut reach = f64::MAX;
        let mut open = [(1, 0.0); DEEPEST];
        let mut count = usize::from(self.bounds().is_some());
        while count > 0 {
            count -= 1;
            let (node, squared) = open[count];
            if squared > reach {
                continue;
            }
            if node >= leaves {
                let within = visit(node - leaves);
                reach = if within < 1e150 {
                    within * within
                } else {
                    f64::MAX
                };
                continue;
            }
            let (a, b) = ((2 * node, far(2 * node)), (2 * node + 1, far(2 * node + 1)));
            // The nearer one is taken first.
            let order = if a.1 <= b.1 { [b, a] } else { [a, b] };
            for child in order {
                if child.1 <= reach {
                    open[count] = child;
                    count += 1;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row() -> BoxTree {
        let place = |i: u32| Point::new(f64::from(i) * 0.7, (f64::from(i) * 0.4).sin() * 5.0);
        BoxTree::new((0..37_u32).map(|i| Bounds {
            min: place(i),
            max: place(i),
        }))
    }

    #[test]
    fn near_boxes_are_found_as_by_looking_at_all() {
        let tree = row();
        for i in 0..200_u32 {
            let p = Point::new(f64::from(i) * 0.15 - 2.0, f64::from(i % 13) - 6.0);
            let at = |place: usize| tree.nodes[tree.nodes.len() / 2 + place];
            let distance = |place| at(place).map_or(f64::MAX, |b| b.squared_distance(&p).sqrt());
            let (mut best, mut seen) = (f64::MAX, 0);
            tree.visit_near(&p, |place| {
                seen += 1;
                best = best.min(distance(place));
                best
            });
            let all = (0..37).map(distance).fold(f64::MAX, f64::min);
            assert!(
                (best - all).abs() < 1e-12 && seen < 37,
                "{best} {all} {seen}"
            );
        }
    }

    #[test]
    fn boxes_that_meet_are_found_and_empty_rows_have_none() {
        let tree = row();
        let all = tree.bounds().map(|b| {
            let mut found = Vec::new();
            tree.any_meeting(&b, |place| {
                found.push(place);
                false
            });
            found
        });
        assert_eq!(all, Some((0..37).collect()));
        let none = BoxTree::new(std::iter::empty());
        assert!(none.bounds().is_none());
        none.visit_near(&Point::origin(), |_| unreachable!("there is no box"));
    }
}
