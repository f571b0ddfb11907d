//! Which of many polygons a point lies inside, and boxes over a sequence, without looking at all of them.
//!
//! A tree of bounding boxes over a sequence whose order follows space.
//!
//! For pieces of a curve or steps of a motion, where neighbours in the row are neighbours in the plane, this
//! is as good as an R-tree and cheaper to build and to ask.

use std::cell::OnceCell;

use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};

use super::{Bounds, Point, distance_to_segment};

/// Edges of one side in a strip of a polygon.
const STRIP: usize = 8;

/// Polygons such as the surfaces of lanes: long and narrow, so that the boxes around them say little.
///
/// Each is cut across into short strips. A point inside a polygon is inside one of its strips, as the strips together
/// go around it as often as the whole does, so their boxes find the polygons that are worth a look.
#[derive(Debug)]
pub struct Rings<'a> {
    rings: Vec<Ring<'a>>,
    /// Boxes of strips, with the place of their polygon.
    strips: RTree<GeomWithData<Rectangle<[f64; 2]>, usize>>,
}

#[derive(Debug)]
struct Ring<'a> {
    points: &'a [Point],
    /// A tree of its edges, built when it is first asked.
    edges: OnceCell<BoxTree>,
}

impl<'a> Rings<'a> {
    /// Polygons (not closed), each with the number of its points that are one of its two long sides; the others are the
    /// other side, back again.
    pub fn new(rings: impl IntoIterator<Item = (&'a [Point], usize)>) -> Self {
        let (mut kept, mut strips) = (Vec::new(), Vec::new());
        for (place, (points, side)) in rings.into_iter().enumerate() {
            let boxes = strips_of(points, side);
            strips.extend(boxes.map(|bounds| {
                let [min, max] = [bounds.min, bounds.max].map(|p| [p.x, p.y]);
                GeomWithData::new(Rectangle::from_corners(min, max), place)
            }));
            kept.push(Ring {
                points,
                edges: OnceCell::new(),
            });
        }
        Self {
            rings: kept,
            strips: RTree::bulk_load(strips),
        }
    }

    /// Places of polygons that `p` may lie inside, in no order and some more than once; it lies in no other.
    pub fn near(&self, p: &Point) -> impl Iterator<Item = usize> {
        let at = AABB::from_point([p.x, p.y]);
        let strips = self.strips.locate_in_envelope_intersecting(at);
        strips.map(|strip| strip.data)
    }

    /// Whether `p` lies inside the polygon at a place, further than `edge` metres from its border.
    #[must_use]
    pub fn has_inside(&self, place: usize, p: &Point, edge: f64) -> bool {
        self.rings[place].has_inside(p, edge)
    }
}

/// Boxes around the strips of a polygon.
fn strips_of(points: &[Point], side: usize) -> impl Iterator<Item = Bounds> {
    let (one, other) = points.split_at(side.min(points.len()));
    let longest = one.len().max(other.len());
    let count = longest.saturating_sub(1).div_ceil(STRIP).max(1);
    // The points from one cut to the next, both cuts included, along a side.
    let part = move |of: usize, strip: usize| {
        let cut = |strip: usize| (of.saturating_sub(1) * strip) / count;
        cut(strip)..(cut(strip + 1) + 1).min(of)
    };
    (0..count).filter_map(move |strip| {
        let back = part(other.len(), strip);
        let back = other.len() - back.end..other.len() - back.start;
        let corners = one[part(one.len(), strip)].iter().chain(&other[back]);
        Bounds::from_points(corners)
    })
}

impl Ring<'_> {
    fn edge(&self, place: usize) -> (&Point, &Point) {
        let next = (place + 1) % self.points.len();
        (&self.points[place], &self.points[next])
    }

    /// Whether a point lies inside, by winding number, and not just at the border.
    fn has_inside(&self, p: &Point, edge: f64) -> bool {
        let edges = self.edges.get_or_init(|| {
            let places = 0..self.points.len();
            BoxTree::new(places.map(|place| {
                let (from, to) = self.edge(place);
                let corner = |p: &Point| Bounds { min: *p, max: *p };
                corner(from).union(&corner(to))
            }))
        });
        if !edges.bounds().is_some_and(|bounds| bounds.contains(p)) {
            return false;
        }
        let reach = super::Vector::new(edge, edge);
        let around = Bounds {
            min: p - reach,
            max: p + reach,
        };
        let at_border = edges.any_meeting(&around, |place| {
            let (from, to) = self.edge(place);
            distance_to_segment(p, from, to) <= edge
        });
        if at_border {
            return false;
        }
        // Only edges to the right of it count.
        let right = Bounds {
            min: *p,
            max: Point::new(f64::INFINITY, p.y),
        };
        let mut winding = 0;
        edges.any_meeting(&right, |place| {
            let (from, to) = self.edge(place);
            let upward = to.y > from.y;
            let crosses = (to.y > p.y) != (from.y > p.y);
            if crosses && ((to - from).perp(&(p - from)) > 0.0) == upward {
                winding += if upward { 1 } else { -1 };
            }
            false
        });
        winding != 0
    }
}

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
    use crate::geometry::contains;

    /// A lane along a wave, with sides of different numbers of points.
    fn lane(turn: f64, points: [u32; 2]) -> Vec<Point> {
        let side = |y: f64, count: u32| {
            (0..count).map(move |i| {
                let x = f64::from(i) / f64::from(count - 1) * 60.0;
                let y = y + 8.0 * (x * 0.2).sin();
                let (sin, cos) = turn.sin_cos();
                Point::new(x * cos - y * sin, x * sin + y * cos)
            })
        };
        let mut ring: Vec<Point> = side(2.0, points[0]).collect();
        ring.extend(side(-2.0, points[1]).rev());
        ring
    }

    fn inside_of(all: &Rings<'_>, p: &Point, edge: f64) -> Vec<usize> {
        let places: std::collections::BTreeSet<usize> = all.near(p).collect();
        let inside = places.into_iter().filter(|i| all.has_inside(*i, p, edge));
        inside.collect()
    }

    #[test]
    fn the_same_is_found_as_by_looking_at_every_edge() {
        let shapes = [(0.0, [90, 90]), (0.7, [30, 200]), (2.0, [61, 2])];
        let mut rings = shapes.map(|(turn, points)| (lane(turn, points), points[0] as usize));
        // Sides that are drawn in different directions cross themselves.
        rings[1].0[30..].reverse();
        let all = Rings::new(rings.iter().map(|(ring, side)| (&ring[..], *side)));
        let (mut inside, mut outside) = (0, 0);
        for i in 0..4000_u32 {
            let p = Point::new(
                f64::from(i % 80) * 1.1 - 20.0,
                f64::from(i / 80) * 1.3 - 10.0,
            );
            let by_all = |ring: &[Point]| {
                let next = ring.iter().cycle().skip(1);
                let mut edges = ring.iter().zip(next);
                contains(ring, &p) && edges.all(|(a, b)| distance_to_segment(&p, a, b) > 0.6)
            };
            let wanted: Vec<usize> = (0..3).filter(|i| by_all(&rings[*i].0)).collect();
            assert_eq!(inside_of(&all, &p, 0.6), wanted, "{p}");
            inside += wanted.len();
            outside += 3 - wanted.len();
        }
        assert!(inside > 100 && outside > 100, "{inside} {outside}");
    }

    #[test]
    fn long_sides_are_looked_at_in_part_and_empty_polygons_hold_nothing() {
        let ring = lane(0.3, [20_000, 20_000]);
        let strips: Vec<Bounds> = strips_of(&ring, 20_000).collect();
        assert_eq!(strips.len(), 19_999_usize.div_ceil(STRIP));
        assert!(strips.iter().all(|b| (b.max - b.min).norm() < 8.0));
        let none = Rings::new([(&[][..], 0), (&ring[..1], 1), (&ring[..2], 7)]);
        assert!(inside_of(&none, &ring[0], 0.0).is_empty());
    }

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
