//! Roads of one lane that bend so tightly that a border runs back: laid through each pair of points of the borders.

use super::curve::Curve;
use super::profile::Profile;
use crate::geometry::{Point, Polyline, Pose, Vector, angle_between};

/// A reference line with the profiles of both borders.
pub struct Paired {
    /// The reference line.
    pub curve: Curve,
    /// The left border.
    pub left: Profile,
    /// The right border.
    pub right: Profile,
}

/// Samples between two pairs are so close, metres.
const CLOSE: f64 = 0.1;

/// A border is looked for so far beside where it is expected, metres.
const BESIDE: f64 = 0.5;

/// The road through pairs of points, `place` of the way from the right to the left; `None` where they are not paired.
pub fn paired(left: &Polyline, right: &Polyline, place: f64) -> Option<Paired> {
    let (l, r) = (left.points(), right.points());
    if l.len() != r.len() {
        return None;
    }
    let middles: Vec<Point> = l.iter().zip(r).map(|(l, r)| r + (l - r) * place).collect();
    let mut curve = Curve::default();
    let mut knots = vec![(0.0, 0)];
    let mut last: Option<Pose> = None;
    for i in 0..l.len() {
        let before = middles[i.saturating_sub(1)];
        let driven = middles[(i + 1).min(l.len() - 1)] - before;
        let pose = Pose {
            position: middles[i],
            heading: square(&(l[i] - r[i]), driven),
        };
        if let Some(last) = last {
            curve.biarc_to(last, pose);
            if curve.length() > knots.last().map_or(0.0, |(s, _)| *s) + 1e-6 {
                knots.push((curve.length(), i));
            }
        }
        last = Some(pose);
    }
    let side = |points: &[Point]| -> Profile {
        let mut all = Vec::new();
        let at = |s: f64, p: &Point| curve.at(s).to_local(p).y;
        for pair in knots.windows(2) {
            let ((from, i), (to, j)) = (pair[0], pair[1]);
            let (a, b) = (&points[i], &points[j]);
            let (first, then) = (at(from, a), at(to, b));
            all.push((from, first));
            let count = ((to - from) / CLOSE).ceil().clamp(1.0, 200.0);
            for k in 1..count as usize {
                let share = k as f64 / count;
                let s = from + (to - from) * share;
                let expected = first + (then - first) * share;
                all.push((s, crossing(&curve.at(s), a, b, expected)));
            }
        }
        let end = knots.last().map(|(s, i)| (*s, at(*s, &points[*i])));
        all.extend(end);
        Profile(all)
    };
    let (left, right) = (side(l), side(r));
    (knots.len() > 1).then_some(Paired { curve, left, right })
}

/// The direction square to a line across the road, as it is driven.
fn square(across: &Vector, driven: Vector) -> f64 {
    let driving = driven.y.atan2(driven.x);
    if across.norm() < 0.05 {
        return driving;
    }
    let square = (-across.x).atan2(across.y);
    match angle_between(driving, square).abs() < 1.4 {
        true => square,
        false => driving,
    }
}

/// Where the line across a pose meets that through two points, near where it is expected.
fn crossing(pose: &Pose, a: &Point, b: &Point, expected: f64) -> f64 {
    let (a, b) = (pose.to_local(a), pose.to_local(b));
    let along = b.x - a.x;
    if along.abs() < 1e-9 {
        return expected;
    }
    let t = a.y - (b.y - a.y) * a.x / along;
    if (t - expected).abs() < BESIDE {
        t
    } else {
        expected
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::super::profile::deviation;
    use super::*;

    fn line(points: &[(f64, f64)]) -> Polyline {
        Polyline::new(points.iter().map(|(x, y)| Point::new(*x, *y))).unwrap()
    }

    #[test]
    fn pairs_across_a_tight_bend_keep_both_borders() {
        // A quarter of a turn about (0, 0): the inner border has a radius of 0.5 m, the outer one of 4 m.
        let around = |radius: f64| {
            let at = |i: i32| f64::from(i) * std::f64::consts::PI / 32.0;
            let all: Vec<(f64, f64)> = (0..=16)
                .map(|i| (radius * at(i).sin(), -radius * at(i).cos()))
                .collect();
            line(&all)
        };
        let (left, right) = (around(0.5), around(4.0));
        let laid = paired(&left, &right, 0.5).unwrap();
        assert!(deviation(&laid.curve, &laid.left, &left) < 0.01);
        assert!(deviation(&laid.curve, &laid.right, &right) < 0.01);
    }
}
