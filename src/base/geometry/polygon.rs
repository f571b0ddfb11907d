//! Simple polygons and bounding boxes: hulls, overlap, what of a line lies in a box, and which of many rings or boxes are near.
//!
//! Boxes are a tree over a sequence whose order follows space: for pieces of a curve or steps of a motion, where neighbours in
//! the row are neighbours in the plane, that is as good as an R-tree and cheaper to build and to ask.

use std::cell::OnceCell;

use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};

use super::curve::distance_to_segment;
use super::{Point, Vector};

/// A box in line with the axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// Lower left corner.
    pub min: Point,
    /// Upper right corner.
    pub max: Point,
}

impl Bounds {
    /// The smallest box around `points`; `None` for no points.
    pub fn from_points<'a>(points: impl IntoIterator<Item = &'a Point>) -> Option<Self> {
        points.into_iter().fold(None, |bounds, p| {
            Some(bounds.map_or(Self { min: *p, max: *p }, |b: Self| Self {
                min: Point::new(b.min.x.min(p.x), b.min.y.min(p.y)),
                max: Point::new(b.max.x.max(p.x), b.max.y.max(p.y)),
            }))
        })
    }

    /// The smallest box around both.
    #[must_use]
    pub fn union(&self, other: &Self) -> Self {
        Self {
            min: Point::new(self.min.x.min(other.min.x), self.min.y.min(other.min.y)),
            max: Point::new(self.max.x.max(other.max.x), self.max.y.max(other.max.y)),
        }
    }

    /// Whether `p` is inside or on the border.
    #[must_use]
    pub fn contains(&self, p: &Point) -> bool {
        p.x >= self.min.x && p.x <= self.max.x && p.y >= self.min.y && p.y <= self.max.y
    }

    /// Whether the two boxes share a point.
    #[must_use]
    pub fn overlaps(&self, other: &Self) -> bool {
        self.min.x <= other.max.x
            && self.max.x >= other.min.x
            && self.min.y <= other.max.y
            && self.max.y >= other.min.y
    }

    /// The square of the distance from `p` to the box, m²; 0 inside.
    #[must_use]
    pub fn squared_distance(&self, p: &Point) -> f64 {
        let x = (self.min.x - p.x).max(p.x - self.max.x).max(0.0);
        let y = (self.min.y - p.y).max(p.y - self.max.y).max(0.0);
        x * x + y * y
    }

    /// The middle.
    #[must_use]
    pub fn center(&self) -> Point {
        nalgebra::center(&self.min, &self.max)
    }
}

/// How far from an edge a point is still on it, metres: files have no finer digits.
const ON_EDGE: f64 = 1e-6;

/// Whether `p` is inside the polygon `ring` (not closed) or on its border, by winding number.
///
/// The border belongs to the polygon, so that no point falls between two neighbours. Where the ring
/// overlaps itself, both layers are inside.
#[must_use]
pub fn contains(ring: &[Point], p: &Point) -> bool {
    let mut winding = 0;
    let mut previous = match ring.last() {
        Some(last) => last,
        None => return false,
    };
    for corner in ring {
        let near_y =
            p.y >= previous.y.min(corner.y) - ON_EDGE && p.y <= previous.y.max(corner.y) + ON_EDGE;
        if near_y {
            let upward = corner.y > previous.y;
            let crosses = (corner.y > p.y) != (previous.y > p.y);
            let side = (corner - previous).perp(&(p - previous));
            if crosses && (side > 0.0) == upward {
                winding += if upward { 1 } else { -1 };
            }
            if distance_to_segment(p, previous, corner) <= ON_EDGE {
                return true;
            }
        }
        previous = corner;
    }
    winding != 0
}

/// The convex hull of `points`, counter-clockwise, without points on its edges.
///
/// Source: Andrew, Another efficient algorithm for convex hulls in two dimensions, 1979.
#[must_use]
pub fn convex_hull(points: &[Point]) -> Vec<Point> {
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let mut hull: Vec<Point> = Vec::with_capacity(sorted.len() + 1);
    for chain in [false, true] {
        let from = hull.len();
        let mut add = |p: Point| {
            while let [.., a, b] = hull[from..]
                && (b - a).perp(&(p - b)) <= 0.0
            {
                hull.pop();
            }
            hull.push(p);
        };
        if chain {
            sorted.iter().rev().for_each(|p| add(*p));
        } else {
            sorted.iter().for_each(|p| add(*p));
        }
        // The end of each chain is the beginning of the other.
        hull.pop();
    }
    if hull.is_empty() {
        hull.extend(sorted.first());
    }
    hull
}

/// Polygons nearer than this touch, metres: rounding must not separate touching bodies.
const TOUCHING: f64 = 1e-7;

/// Whether two convex polygons (counter-clockwise, not closed) share a point.
///
/// By the separating-axis theorem: they do not if and only if one has an edge with the other outside of it.
#[must_use]
pub fn convex_overlap(a: &[Point], b: &[Point]) -> bool {
    !a.is_empty() && !b.is_empty() && !separates(a, b) && !separates(b, a)
}

fn separates(ring: &[Point], other: &[Point]) -> bool {
    let next = ring.iter().cycle().skip(1);
    ring.iter().zip(next).any(|(from, to)| {
        let edge: Vector = to - from;
        let slack = TOUCHING * edge.norm();
        other.iter().all(|p| edge.perp(&(p - from)) < -slack)
    })
}

/// The part of the way from `from` (0) to `to` (1) that lies within `bounds`; `None` if none does, or where a
/// coordinate is not finite.
///
/// Source: Liang and Barsky, A New Concept and Method for Line Clipping, ACM Transactions on Graphics 3(1), 1984.
#[must_use]
pub fn part_within(from: &Point, to: &Point, bounds: &Bounds) -> Option<(f64, f64)> {
    let (from, to) = (tamed(from)?, tamed(to)?);
    let (mut enters, mut leaves) = (0.0_f64, 1.0_f64);
    for axis in 0..2 {
        let (start, way) = (from[axis], to[axis] - from[axis]);
        let (low, high) = (bounds.min[axis], bounds.max[axis]);
        if way == 0.0 {
            if start < low || start > high {
                return None;
            }
            continue;
        }
        let (a, b) = ((low - start) / way, (high - start) / way);
        enters = enters.max(a.min(b));
        leaves = leaves.min(a.max(b));
    }
    (enters <= leaves).then_some((enters, leaves))
}

/// The point at a part of the way from `from` to `to` that [`part_within`] found in `bounds`.
#[must_use]
pub fn within_at(from: &Point, to: &Point, part: f64, bounds: &Bounds) -> Point {
    let (from, to) = (tamed(from).unwrap_or(*from), tamed(to).unwrap_or(*to));
    let at = match part {
        0.0 => from,
        1.0 => to,
        _ => from + (to - from) * part,
    };
    // Far from the origin a product has no digits left for the place within the box.
    Point::new(
        at.x.clamp(bounds.min.x, bounds.max.x),
        at.y.clamp(bounds.min.y, bounds.max.y),
    )
}

/// The part of a polygon that lies within `bounds`, as one ring whose edges may run along the box; empty where nothing
/// does. Corners that are not finite are left out.
///
/// Source: Sutherland and Hodgman, Reentrant Polygon Clipping, Communications of the ACM 17(1), 1974.
#[must_use]
pub fn ring_within(ring: &[Point], bounds: &Bounds) -> Vec<Point> {
    let mut kept: Vec<Point> = ring.iter().filter_map(tamed).collect();
    for axis in 0..2 {
        for (edge, sign) in [(bounds.min[axis], 1.0), (bounds.max[axis], -1.0)] {
            kept = half_plane(&kept, axis, edge, sign);
        }
    }
    kept
}

/// The part on one side of a line along an axis: above `edge` where `sign` is positive, else below.
fn half_plane(ring: &[Point], axis: usize, edge: f64, sign: f64) -> Vec<Point> {
    let holds = |p: &Point| (p[axis] - edge) * sign >= 0.0;
    let mut kept = Vec::with_capacity(ring.len() + 2);
    let before = ring.iter().cycle().skip(ring.len().saturating_sub(1));
    for (a, b) in before.zip(ring) {
        if holds(a) != holds(b) {
            // From the nearer end, to lose few digits.
            let (near, far) = if (a[axis] - edge).abs() < (b[axis] - edge).abs() {
                (a, b)
            } else {
                (b, a)
            };
            let mut cut = near + (far - near) * ((edge - near[axis]) / (far[axis] - near[axis]));
            cut[axis] = edge;
            kept.push(cut);
        }
        if holds(b) {
            kept.push(*b);
        }
    }
    kept
}

/// A point whose differences to others do not overflow; `None` for one that is not finite.
fn tamed(p: &Point) -> Option<Point> {
    const MOST: f64 = 1e300;
    let finite = p.x.is_finite() && p.y.is_finite();
    finite.then(|| p.map(|c| c.clamp(-MOST, MOST)))
}

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
    #![allow(clippy::unwrap_used)]

    use proptest::prelude::*;

    use super::*;
    use crate::geometry::contains;

    #[test]
    fn a_concave_ring() {
        let ring =
            [(0., 0.), (4., 0.), (4., 4.), (2., 1.), (0., 4.)].map(|(x, y)| Point::new(x, y));
        assert!(contains(&ring, &Point::new(0.5, 2.0)));
        assert!(!contains(&ring, &Point::new(2.0, 2.0)), "in the notch");
        assert!(!contains(&[], &Point::new(0.0, 0.0)));
    }

    #[test]
    fn the_border_belongs_to_both_neighbours() {
        let slanted = |i: f64| Point::new(0.3 + 0.7 * i, 0.1 + 1.3 * i);
        let left = [slanted(0.0), slanted(1.0), Point::new(-5.0, 1.0)];
        let right = [slanted(1.0), slanted(0.0), Point::new(5.0, 1.0)];
        for i in 0..=1000 {
            let joint = slanted(f64::from(i) / 1000.0);
            assert!(contains(&left, &joint) && contains(&right, &joint), "{i}");
        }
        let off = Point::new(0.3 - 1e-5, 0.1);
        assert!(!contains(&right, &off));
    }

    #[test]
    fn where_a_ring_overlaps_itself_it_is_inside() {
        let ring = [
            (0., 0.),
            (6., 0.),
            (6., 2.),
            (2., 2.),
            (2., -2.),
            (4., -2.),
            (4., 4.),
            (0., 4.),
        ]
        .map(|(x, y)| Point::new(x, y));
        assert!(contains(&ring, &Point::new(3.0, 1.0)) && contains(&ring, &Point::new(1.0, 1.0)));
        assert!(!contains(&ring, &Point::new(5.0, 3.0)));
    }

    fn ring(points: &[(f64, f64)]) -> Vec<Point> {
        points.iter().map(|&(x, y)| Point::new(x, y)).collect()
    }

    #[test]
    fn a_hull_leaves_out_what_is_inside_and_on_edges() {
        let hull = convex_hull(&ring(&[
            (0., 0.),
            (2., 1.),
            (4., 0.),
            (2., 0.),
            (4., 3.),
            (0., 3.),
            (4., 3.),
        ]));
        assert_eq!(hull, ring(&[(0., 0.), (4., 0.), (4., 3.), (0., 3.)]));
    }

    #[test]
    fn corners_between_each_other_do_not_make_an_overlap() {
        let square = ring(&[(0., 0.), (2., 0.), (2., 2.), (0., 2.)]);
        // Its box overlaps the square's, the triangle does not.
        let triangle = ring(&[(3., 1.5), (3., 3.), (1.5, 3.)]);
        assert!(!convex_overlap(&square, &triangle));
        let nearer = ring(&[(3., 0.5), (3., 3.), (0.5, 3.)]);
        assert!(convex_overlap(&square, &nearer));
        let inside = ring(&[(0.5, 0.5), (1., 0.5), (1., 1.)]);
        assert!(convex_overlap(&square, &inside) && convex_overlap(&inside, &square));
    }

    fn bounds() -> Bounds {
        Bounds {
            min: Point::new(-10.0, -5.0),
            max: Point::new(10.0, 5.0),
        }
    }

    fn area(ring: &[Point]) -> f64 {
        let next = ring.iter().cycle().skip(1);
        let twice: f64 = ring
            .iter()
            .zip(next)
            .map(|(a, b)| a.x * b.y - b.x * a.y)
            .sum();
        twice / 2.0
    }

    /// Small, usual, huge and no numbers.
    fn coordinate() -> impl Strategy<Value = f64> {
        prop_oneof![
            4 => -20.0..20.0_f64,
            2 => -1e6..1e6_f64,
            2 => (-308.0..308.0_f64, prop::bool::ANY).prop_map(|(e, minus)| {
                10_f64.powf(e) * if minus { -1.0 } else { 1.0 }
            }),
            1 => prop::sample::select(vec![0.0, 10.0, -5.0, f64::NAN, f64::INFINITY, f64::MIN]),
        ]
    }

    fn point() -> impl Strategy<Value = Point> {
        (coordinate(), coordinate()).prop_map(|(x, y)| Point::new(x, y))
    }

    #[test]
    fn lines_are_cut_where_they_leave() {
        let part = |a: (f64, f64), b: (f64, f64)| {
            part_within(&Point::new(a.0, a.1), &Point::new(b.0, b.1), &bounds())
        };
        assert_eq!(part((0.0, 0.0), (5.0, 5.0)), Some((0.0, 1.0)));
        assert_eq!(part((-20.0, 0.0), (20.0, 0.0)), Some((0.25, 0.75)));
        assert_eq!(part((0.0, 0.0), (0.0, 10.0)), Some((0.0, 0.5)));
        assert_eq!(part((-20.0, 6.0), (20.0, 6.0)), None);
        assert_eq!(part((11.0, 0.0), (30.0, 2.0)), None);
        assert_eq!(part((3.0, 3.0), (3.0, 3.0)), Some((0.0, 1.0)));
        assert_eq!(part((f64::NAN, 0.0), (1.0, 0.0)), None);
        let (a, b) = part((-1e308, 0.0), (1e308, 0.0)).unwrap();
        assert!((a - 0.5).abs() < 1e-9 && (b - 0.5).abs() < 1e-9);
    }

    #[test]
    fn a_polygon_around_the_box_becomes_the_box() {
        for far in [20.0, 1e8, 1e20, 1e308] {
            let ring =
                [(-far, -far), (far, -far), (far, far), (-far, far)].map(|(x, y)| Point::new(x, y));
            let cut = ring_within(&ring, &bounds());
            assert!((area(&cut) - 200.0).abs() < 1e-9, "{far}: {cut:?}");
        }
    }

    proptest! {
        #[test]
        fn nothing_lies_outside_the_box(ring in prop::collection::vec(point(), 0..12)) {
            let bounds = bounds();
            let inside = |p: &Point| {
                (-10.0..=10.0).contains(&p.x) && (-5.0..=5.0).contains(&p.y)
            };
            prop_assert!(ring_within(&ring, &bounds).iter().all(inside));
            for pair in ring.windows(2) {
                if let Some((a, b)) = part_within(&pair[0], &pair[1], &bounds) {
                    prop_assert!((0.0..=1.0).contains(&a) && a <= b && b <= 1.0);
                    for part in [a, b] {
                        prop_assert!(inside(&within_at(&pair[0], &pair[1], part, &bounds)));
                    }
                }
            }
        }

        #[test]
        fn areas_of_convex_polygons_are_those_of_samples(
            middle in (-12.0..12.0_f64, -8.0..8.0_f64),
            (wide, high) in (1.0..30.0_f64, 1.0..30.0_f64),
        ) {
            // A diamond, whose area in the box is counted on a grid.
            let (x, y) = middle;
            let ring = [(x - wide, y), (x, y - high), (x + wide, y), (x, y + high)];
            let ring = ring.map(|(x, y)| Point::new(x, y));
            let holds = |px: f64, py: f64| (px - x).abs() / wide + (py - y).abs() / high <= 1.0;
            let n = 400;
            let hits = (0..n * n).filter(|i| {
                let (col, row) = (f64::from(i % n), f64::from(i / n));
                let n = f64::from(n);
                holds(-10.0 + 20.0 * (col + 0.5) / n, -5.0 + 10.0 * (row + 0.5) / n)
            });
            let counted = hits.count() as f64 * 200.0 / f64::from(n * n);
            prop_assert!((area(&ring_within(&ring, &bounds())) - counted).abs() < 1.0);
        }
    }

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
