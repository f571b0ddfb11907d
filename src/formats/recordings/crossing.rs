//! Pedestrian crossings as lanelets, which are walked along from one side of the road to the other.

use nearmiss_base::geometry::{Point, Vector};
use nearmiss_scene::scenario::{Bound, Lanelet, LaneletType, LineMarking, RoadUser};

/// A crossing between two edges that run the same way.
pub fn between(id: i64, left: Vec<Point>, right: Vec<Point>) -> Lanelet {
    let bound = |points| Bound {
        points,
        heights: Vec::new(),
        marking: LineMarking::NoMarking,
    };
    Lanelet {
        id,
        left: bound(left),
        right: bound(right),
        types: vec![LaneletType::Crosswalk],
        users_bidirectional: vec![RoadUser::Pedestrian],
        ..Lanelet::default()
    }
}

/// A crossing whose outline is a ring; `None` where it encloses nothing. Its long sides are its edges, and of a ring
/// with other than four corners those of the rectangle around it.
pub fn of_ring(id: i64, ring: &[Point]) -> Option<Lanelet> {
    let mut ring = ring.to_vec();
    if ring.len() > 3 && ring.first() == ring.last() {
        ring.pop();
    }
    let corners = match ring[..] {
        [a, b, c, d] => [a, b, c, d],
        _ => rectangle_around(&ring)?,
    };
    let [a, b, c, d] = corners;
    // Counterclockwise, so that the left edge is on the left.
    let turned = (b - a).perp(&(c - a)) + (c - a).perp(&(d - a));
    if turned.abs() < 1e-6 {
        return None;
    }
    let [a, b, c, d] = if turned > 0.0 {
        [a, b, c, d]
    } else {
        [d, c, b, a]
    };
    let first = (b - a).norm() + (d - c).norm();
    let second = (c - b).norm() + (a - d).norm();
    let (left, right) = if first >= second {
        (vec![d, c], vec![a, b])
    } else {
        (vec![a, d], vec![b, c])
    };
    Some(between(id, left, right))
}

/// The rectangle around a ring along its longest side.
fn rectangle_around(ring: &[Point]) -> Option<[Point; 4]> {
    let next = ring.iter().cycle().skip(1);
    let sides = ring.iter().zip(next).map(|(a, b)| b - a);
    let longest = sides.max_by(|a, b| a.norm_squared().total_cmp(&b.norm_squared()))?;
    let along = longest.try_normalize(1e-9)?;
    let across = Vector::new(-along.y, along.x);
    let origin = ring[0];
    let range = |axis: &Vector| {
        let each = ring.iter().map(|p| (p - origin).dot(axis));
        each.fold((f64::MAX, f64::MIN), |(a, b), v| (a.min(v), b.max(v)))
    };
    let ((x0, x1), (y0, y1)) = (range(&along), range(&across));
    let at = |x: f64, y: f64| origin + along * x + across * y;
    Some([at(x0, y0), at(x1, y0), at(x1, y1), at(x0, y1)])
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn ring(corners: &[(f64, f64)]) -> Vec<Point> {
        corners.iter().map(|(x, y)| Point::new(*x, *y)).collect()
    }

    #[test]
    fn the_long_sides_are_the_edges_whichever_way_the_ring_turns() {
        let corners = [(0.0, 0.0), (0.0, 10.0), (4.0, 10.0), (4.0, 0.0)];
        let mut turned = corners;
        turned.reverse();
        for corners in [corners, turned] {
            let lanelet = of_ring(1, &ring(&corners)).unwrap();
            let (left, right) = (&lanelet.left.points, &lanelet.right.points);
            assert!((left[1] - left[0]).norm() == 10.0, "{left:?}");
            let along = left[1] - left[0];
            assert!(
                along.perp(&(right[0] - left[0])) < 0.0,
                "{left:?} {right:?}"
            );
            assert!((right[1] - right[0]).dot(&along) > 0.0);
        }
    }

    #[test]
    fn other_rings_have_a_rectangle_around_them() {
        let corners = [
            (0.0, 0.0),
            (10.0, 0.0),
            (11.0, 1.0),
            (10.0, 2.0),
            (0.0, 2.0),
            (0.0, 0.0),
        ];
        let lanelet = of_ring(1, &ring(&corners)).unwrap();
        // Along its last longest side, here to the left of the picture.
        assert_eq!(lanelet.left.points, ring(&[(11.0, 0.0), (0.0, 0.0)]));
        assert_eq!(lanelet.right.points, ring(&[(11.0, 2.0), (0.0, 2.0)]));
        assert_eq!(
            of_ring(1, &ring(&[(0.0, 0.0), (1.0, 0.0), (2.0, 0.0)])),
            None
        );
        assert_eq!(of_ring(1, &[]), None);
    }
}
