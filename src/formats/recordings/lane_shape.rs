//! The borders of lanes that are given by a line along their middle, and of pedestrian crossings.

use nearmiss_base::geometry::{Point, Polyline, Vector};
use nearmiss_scene::scenario::{Bound, Lanelet, LaneletType, LineMarking, RoadUser};

/// Distance of a border from the middle of its lane, metres, to the left and right, for each point of the line.
pub type Widths = Vec<(f64, f64)>;

/// The two borders of a lane along `centre`; `widths` has one entry for each of its points.
pub fn borders(centre: &[Point], heights: &[f64], widths: &Widths) -> (Bound, Bound) {
    let directions = directions(centre);
    let side = |sign: f64, of: fn(&(f64, f64)) -> f64| {
        let across = directions.iter().map(|d| Vector::new(-d.y, d.x) * sign);
        let points = centre.iter().zip(across).zip(widths);
        let points: Vec<Point> = points.map(|((p, across), w)| p + across * of(w)).collect();
        Bound {
            points: forwards(points, &directions),
            heights: if heights.len() == centre.len() {
                heights.to_vec()
            } else {
                Vec::new()
            },
            marking: LineMarking::Unknown,
        }
    };
    (side(1.0, |w| w.0), side(-1.0, |w| w.1))
}

/// On the inside of tight bends a border would run backwards; it stays where it is instead.
fn forwards(mut points: Vec<Point>, directions: &[Vector]) -> Vec<Point> {
    for i in 1..points.len() {
        if (points[i] - points[i - 1]).dot(&directions[i]) <= 0.0 {
            // A millimetre on, as borders do not stand still.
            points[i] = points[i - 1] + directions[i] * 1e-3;
        }
    }
    points
}

/// The direction of a line at each of its points: of the mean of the pieces before and after it.
pub fn directions(line: &[Point]) -> Vec<Vector> {
    let piece = |i: usize| -> Option<Vector> {
        let along = line.get(i + 1)? - line.get(i)?;
        along.try_normalize(1e-9)
    };
    let mut last = (0..line.len())
        .find_map(piece)
        .unwrap_or_else(|| Vector::new(1.0, 0.0));
    let all = (0..line.len()).map(|i| {
        let before = i.checked_sub(1).and_then(piece);
        let sum = before.unwrap_or_default() + piece(i).unwrap_or_default();
        last = sum.try_normalize(1e-9).unwrap_or(last);
        last
    });
    all.collect()
}

/// A line without points that repeat the one before, with its heights.
pub fn without_repeats(
    points: Vec<Point>,
    heights: Vec<f64>,
) -> (Vec<Point>, Vec<f64>, Vec<usize>) {
    let mut kept: (Vec<Point>, Vec<f64>, Vec<usize>) = Default::default();
    for (i, p) in points.into_iter().enumerate() {
        if kept.0.last().is_none_or(|last| (p - last).norm() > 1e-6) {
            kept.0.push(p);
            kept.1.extend(heights.get(i));
            kept.2.push(i);
        }
    }
    kept
}

/// Two borders with as many points each, as CommonRoad's readers want them: every point of one has a partner at the
/// same part of the other's length, which is added where it is not there. Their courses stay the same.
pub fn matched(left: Vec<Point>, right: Vec<Point>) -> (Vec<Point>, Vec<Point>) {
    if left.len() == right.len() {
        return (left, right);
    }
    let (Some(left_line), Some(right_line)) = (
        Polyline::new(left.iter().copied()),
        Polyline::new(right.iter().copied()),
    ) else {
        return (left, right);
    };
    let parts = |line: &Polyline| -> Vec<f64> {
        line.arc_lengths()
            .iter()
            .map(|s| s / line.length())
            .collect()
    };
    let mut all = parts(&left_line);
    all.extend(parts(&right_line));
    all.sort_by(f64::total_cmp);
    all.dedup_by(|b, a| *b - *a < SAME_PART);
    let along = |line: &Polyline| -> Vec<Point> {
        let each = all
            .iter()
            .map(|part| line.pose_at(part * line.length()).position);
        each.collect()
    };
    (along(&left_line), along(&right_line))
}

/// Parts of a length that are one.
const SAME_PART: f64 = 1e-6;

/// Whether two lines run the same way, from their ends.
pub fn same_way(a: &[Point], b: &[Point]) -> bool {
    let straight = |line: &[Point]| match line {
        [first, .., last] => last - first,
        _ => Vector::zeros(),
    };
    straight(a).dot(&straight(b)) >= 0.0
}

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
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    #[test]
    fn borders_lie_to_the_left_and_right() {
        let centre = [(0.0, 0.0), (10.0, 0.0), (10.0, 10.0)].map(|(x, y)| Point::new(x, y));
        let (left, right) = borders(&centre, &[1.0; 3], &vec![(1.0, 2.0); 3]);
        assert_eq!(left.points[0], Point::new(0.0, 1.0));
        assert_eq!(right.points[0], Point::new(0.0, -2.0));
        assert_eq!(left.points[2], Point::new(9.0, 10.0));
        assert_eq!(right.points[2], Point::new(12.0, 10.0));
        assert_eq!(left.heights.len(), 3);
    }

    #[test]
    fn a_border_never_runs_backwards() {
        let centre: Vec<Point> = (0..=18)
            .map(|i| f64::from(i) * std::f64::consts::PI / 18.0)
            .map(|a| Point::new(a.cos(), a.sin()))
            .collect();
        // The bend to the left has a radius of 1 m, and the border is 1.75 m to its inside.
        let (left, _) = borders(&centre, &[], &vec![(1.75, 1.75); centre.len()]);
        let along = directions(&centre);
        for (i, pair) in left.points.windows(2).enumerate() {
            assert!((pair[1] - pair[0]).dot(&along[i + 1]) > 0.0, "{i}");
        }
    }

    #[test]
    fn borders_get_as_many_points_and_keep_their_course() {
        let line = |xs: &[f64], y: f64| xs.iter().map(|x| Point::new(*x, y)).collect::<Vec<_>>();
        let (left, right) = matched(line(&[0.0, 4.0, 10.0], 1.0), line(&[0.0, 10.0], -1.0));
        assert_eq!(left, line(&[0.0, 4.0, 10.0], 1.0));
        assert_eq!(right, line(&[0.0, 4.0, 10.0], -1.0));
        assert!(same_way(&left, &right));
        assert!(!same_way(&left, &line(&[10.0, 0.0], 0.0)));
    }

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
