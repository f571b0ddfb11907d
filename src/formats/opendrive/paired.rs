//! Roads of one lane that bend so tightly that a border runs back: laid through each pair of points of the borders.

use super::curve::Curve;
use super::profile::Profile;
use nearmiss_base::geometry::{Point, Polyline, Pose, Vector, angle_between};

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

/// A line across the road: where the reference line crosses it, squarely, and where both borders are.
struct Rung {
    pose: Pose,
    left: Point,
    right: Point,
}

/// The road through pairs of points, `place` of the way from the right to the left; `None` where they are not paired.
pub fn paired(left: &Polyline, right: &Polyline, place: f64) -> Option<Paired> {
    let (l, r) = (left.points(), right.points());
    if l.len() != r.len() {
        return None;
    }
    let middles: Vec<Point> = l.iter().zip(r).map(|(l, r)| r + (l - r) * place).collect();
    let rungs = (0..l.len()).map(|i| {
        let before = middles[i.saturating_sub(1)];
        let driven = middles[(i + 1).min(l.len() - 1)] - before;
        Rung {
            pose: Pose {
                position: middles[i],
                heading: square(&(l[i] - r[i]), driven),
            },
            left: l[i],
            right: r[i],
        }
    });
    through(&rungs.collect::<Vec<_>>())
}

/// The road square to every line across it, from a pair of points to the next: the reference line is the curve that
/// crosses all of them at a right angle, and begins `place` of the way from the right to the left.
///
/// Where a border runs back, lines across meet beyond it: on their other side there are such curves that only run
/// forwards, and both borders are exact. `None` where points are not paired, a line across has no length, or the curve
/// runs back.
pub fn crossing_squarely(left: &Polyline, right: &Polyline, place: f64) -> Option<Paired> {
    let (l, r) = (left.points(), right.points());
    if l.len() != r.len() {
        return None;
    }
    let unit = |left: &Point, right: &Point| {
        let across = left - right;
        (across.norm() > NARROW).then(|| across.normalize())
    };
    let mut across = unit(&l[0], &r[0])?;
    // How far to the left of the right border the curve is.
    let mut beside = (l[0] - r[0]).norm() * place;
    let pose = |right: &Point, across: &Vector, beside: f64| Pose {
        position: right + across * beside,
        heading: (-across.x).atan2(across.y),
    };
    let mut rungs = vec![Rung {
        pose: pose(&r[0], &across, beside),
        left: l[0],
        right: r[0],
    }];
    let mut before = r[0];
    for i in 1..l.len() {
        let (a, b) = (l[i] - l[i - 1], r[i] - r[i - 1]);
        let end = unit(&l[i], &r[i])?;
        let turn = across.dot(&end).clamp(-1.0, 1.0).acos();
        let count = (a.norm().max(b.norm()) / RUNGS.0)
            .max(turn / RUNGS.1)
            .ceil()
            .clamp(1.0, MOST_RUNGS);
        for k in 1..=count as usize * FINER {
            let share = k as f64 / (count * FINER as f64);
            let (left, right) = (l[i - 1] + a * share, r[i - 1] + b * share);
            let next = unit(&left, &right)?;
            // Square to the line across: what the border gains along it, the curve loses.
            beside -= (right - before).dot(&((across + next) / 2.0));
            (across, before) = (next, right);
            let pose = pose(&right, &across, beside);
            let last = rungs.last()?;
            let ahead = last.pose.to_local(&pose.position).x;
            if ahead < -SHORT {
                return None;
            }
            if k % FINER == 0 && (ahead > SHORT || i + 1 == l.len()) {
                rungs.push(Rung { pose, left, right });
            }
        }
    }
    through(&rungs)
}

/// Lines across narrower than this have no direction, metres.
const NARROW: f64 = 0.05;

/// Rungs are no farther apart than this: metres along a border, and radians.
const RUNGS: (f64, f64) = (0.5, 0.06);

/// Rungs between two pairs at most.
const MOST_RUNGS: f64 = 200.0;

/// Steps of the integration between two rungs.
const FINER: usize = 16;

/// Rungs nearer than this along the curve are one, metres.
const SHORT: f64 = 0.01;

/// The road whose reference line crosses these rungs.
fn through(rungs: &[Rung]) -> Option<Paired> {
    let mut curve = Curve::default();
    let mut knots = vec![(0.0, 0)];
    for (i, pair) in rungs.windows(2).enumerate() {
        curve.biarc_to(pair[0].pose, pair[1].pose);
        if curve.length() > knots.last().map_or(0.0, |(s, _)| *s) + 1e-6 {
            knots.push((curve.length(), i + 1));
        }
    }
    let side = |of: fn(&Rung) -> Point| -> Profile {
        let mut all = Vec::new();
        let at = |s: f64, p: &Point| curve.at(s).to_local(p).y;
        for pair in knots.windows(2) {
            let ((from, i), (to, j)) = (pair[0], pair[1]);
            let (a, b) = (of(&rungs[i]), of(&rungs[j]));
            let (first, then) = (at(from, &a), at(to, &b));
            all.push((from, first));
            let count = ((to - from) / CLOSE).ceil().clamp(1.0, 200.0);
            for k in 1..count as usize {
                let share = k as f64 / count;
                let s = from + (to - from) * share;
                let expected = first + (then - first) * share;
                all.push((s, crossing(&curve.at(s), &a, &b, expected)));
            }
        }
        let end = knots.last().map(|(s, i)| (*s, at(*s, &of(&rungs[*i]))));
        all.extend(end);
        Profile(all)
    };
    let (left, right) = (side(|r| r.left), side(|r| r.right));
    (knots.len() > 1).then_some(Paired { curve, left, right })
}

/// The direction square to a line across the road, as it is driven.
fn square(across: &Vector, driven: Vector) -> f64 {
    let driving = driven.y.atan2(driven.x);
    if across.norm() < NARROW {
        return driving;
    }
    let square = (-across.x).atan2(across.y);
    if angle_between(driving, square).abs() < 1.4 {
        square
    } else {
        driving
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

    #[test]
    fn a_border_that_runs_back_is_kept() {
        // A turn about (0, 0) by a lane wider than its radius: its inner border is beyond the centre.
        let around = |radius: f64| {
            let at = |i: i32| f64::from(i) * std::f64::consts::PI / 24.0;
            let all: Vec<(f64, f64)> = (0..=12)
                .map(|i| (radius * at(i).sin(), -radius * at(i).cos()))
                .collect();
            line(&all)
        };
        let (left, right) = (around(-1.0), around(2.5));
        // From the inner border the curve would run back.
        assert!(crossing_squarely(&left, &right, 1.0).is_none());
        let laid = crossing_squarely(&left, &right, 0.0).unwrap();
        assert!(deviation(&laid.curve, &laid.left, &left) < 0.01);
        assert!(deviation(&laid.curve, &laid.right, &right) < 0.01);
    }
}
