//! Simple polygons and bounding boxes: hulls, overlap, and what of a line or ring lies in a box.

use super::polyline::distance_to_segment;
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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use proptest::prelude::*;

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
}
