//! Convex polygons: hulls, and whether two overlap.

use super::{Point, Vector};

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

#[cfg(test)]
mod tests {
    use super::*;

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
}
