//! A reference line for a road that is given by its borders: smooth, and square to the road's two ends.

use super::curve::Curve;
use nearmiss_base::geometry::{Point, Polyline, Pose, Vector, angle_between};

/// How a reference line is laid.
#[derive(Debug, Clone, Copy)]
pub struct Laying {
    /// Where between the right (0) and the left (1) outer border it runs.
    pub place: f64,
    /// As far as it may be from there, metres.
    pub tolerance: f64,
    /// Pieces are not made shorter, metres.
    pub shortest: f64,
}

/// An end of the road: the line across it, from the left to the right.
fn square_to(left: &Point, right: &Point, driven: Vector) -> f64 {
    let across = left - right;
    let driving = driven.y.atan2(driven.x);
    if across.norm() < NARROW {
        return driving;
    }
    let square = (-across.x).atan2(across.y);
    // A line across that is nearly along the road tells nothing.
    if angle_between(driving, square).abs() < MOST_SKEWED {
        square
    } else {
        driving
    }
}

/// Narrower ends are points, metres.
const NARROW: f64 = 0.05;

/// More than this between the road and the square of its end cannot be laid, radians.
const MOST_SKEWED: f64 = 1.3;

/// More pieces have no use.
const DEEPEST: usize = 14;

/// The reference line of a road between two borders; `None` where they have no length.
pub fn lay(left: &Polyline, right: &Polyline, how: Laying) -> Option<Curve> {
    let middle = middle_line(left, right, how.place)?;
    let length = middle.length();
    let (first, last) = (middle.pose_at(0.0), middle.pose_at(length));
    let (l, r) = (left.points(), right.points());
    let start = Pose {
        position: first.position,
        heading: square_to(l.first()?, r.first()?, smooth(&middle, 0.0, how)),
    };
    let end = Pose {
        position: last.position,
        heading: square_to(l.last()?, r.last()?, smooth(&middle, length, how)),
    };
    let mut curve = Curve::default();
    between(
        &mut curve,
        &middle,
        (0.0, start),
        (length, end),
        how,
        DEEPEST,
    );
    (curve.length() > 0.0).then_some(curve)
}

/// The direction of a line around an arc length, from a little before to a little behind.
fn smooth(line: &Polyline, s: f64, how: Laying) -> Vector {
    let (low, high) = (
        (s - how.shortest).max(0.0),
        (s + how.shortest).min(line.length()),
    );
    let across = line.pose_at(high).position - line.pose_at(low).position;
    if across.norm() > 1e-9 {
        across
    } else {
        line.pose_at(s).forward()
    }
}

fn between(
    curve: &mut Curve,
    line: &Polyline,
    from: (f64, Pose),
    to: (f64, Pose),
    how: Laying,
    deeper: usize,
) {
    let mut tried = Curve::default();
    tried.biarc_to(from.1, to.1);
    let span = to.0 - from.0;
    let near = || {
        let points = line.points().iter().zip(line.arc_lengths());
        let inside = points.filter(|(_, s)| **s > from.0 && **s < to.0);
        let middle = line.pose_at(f64::midpoint(from.0, to.0)).position;
        let mut all = inside.map(|(p, _)| *p).chain([middle]);
        let samples = 24;
        let step = tried.length() / f64::from(samples);
        let laid: Vec<Point> = (0..=samples)
            .map(|i| tried.at(f64::from(i) * step).position)
            .collect();
        let laid = Polyline::new(laid);
        tried.length() < 1.5 * span
            && laid.is_some_and(|laid| all.all(|p| laid.project(&p).d.abs() < how.tolerance))
    };
    if deeper == 0 || span < 2.0 * how.shortest || near() {
        curve.biarc_to(from.1, to.1);
        return;
    }
    let s = f64::midpoint(from.0, to.0);
    let direction = smooth(line, s, how);
    let knot = Pose {
        position: line.pose_at(s).position,
        heading: direction.y.atan2(direction.x),
    };
    between(curve, line, from, (s, knot), how, deeper - 1);
    between(curve, line, (s, knot), to, how, deeper - 1);
}

/// The line at a fixed share between two borders, matched by their shares of length.
fn middle_line(left: &Polyline, right: &Polyline, place: f64) -> Option<Polyline> {
    let share = |line: &Polyline| {
        let length = line.length().max(1e-9);
        let all = line.arc_lengths().iter().map(move |s| s / length);
        all.collect::<Vec<_>>()
    };
    let mut shares = [share(left), share(right)].concat();
    shares.sort_by(f64::total_cmp);
    shares.dedup_by(|a, b| (*a - *b).abs() < 1e-9);
    let at = |u: f64| {
        let l = left.pose_at(u * left.length()).position;
        let r = right.pose_at(u * right.length()).position;
        r + (l - r) * place
    };
    Polyline::new(shares.into_iter().map(at))
}
