//! Curves of lines and arcs without a kink, for roads given by borders, and how far beside them the borders are.

use nearmiss_base::geometry::{Point, Polyline, Pose, Vector, angle_between, normalize_angle};

/// A line or an arc.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Piece {
    /// Where the curve's arc length is when it begins, metres.
    pub s: f64,
    /// Its beginning and direction there.
    pub start: Pose,
    /// Metres.
    pub length: f64,
    /// 1/m, positive to the left; 0 is a line.
    pub curvature: f64,
}

/// A curve by its arc length.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Curve {
    /// In order, each where the one before ends.
    pub pieces: Vec<Piece>,
}

/// Flatter than this is a line, 1/m.
const LINE: f64 = 1e-7;

/// Shorter pieces are left out, metres.
const SHORTEST: f64 = 1e-6;

impl Piece {
    /// The pose after `s` metres of the piece.
    pub fn at(&self, s: f64) -> Pose {
        let Pose { position, heading } = self.start;
        let k = self.curvature;
        if k == 0.0 {
            return Pose {
                position: position + self.start.forward() * s,
                heading,
            };
        }
        let end = heading + k * s;
        // Half angles lose no digits where the arc is flat.
        let (half, middle) = (k * s / 2.0, heading + k * s / 2.0);
        let chord = if half == 0.0 {
            s
        } else {
            s * half.sin() / half
        };
        Pose {
            position: position + Vector::new(middle.cos(), middle.sin()) * chord,
            heading: normalize_angle(end),
        }
    }
}

impl Curve {
    /// Metres.
    pub fn length(&self) -> f64 {
        self.pieces.last().map_or(0.0, |p| p.s + p.length)
    }

    /// The pose at an arc length, continued straight beyond the ends.
    pub fn at(&self, s: f64) -> Pose {
        let place = self.pieces.partition_point(|p| p.s <= s);
        let Some(piece) = self.pieces.get(place.saturating_sub(1)) else {
            return Pose::new(0.0, 0.0, 0.0);
        };
        let along = s - piece.s;
        if along > piece.length {
            let end = piece.at(piece.length);
            return Pose {
                position: end.position + end.forward() * (along - piece.length),
                heading: end.heading,
            };
        }
        piece.at(along)
    }

    /// It up to an arc length, and the rest from there.
    pub fn split(&self, s: f64) -> (Self, Self) {
        let (mut head, mut tail) = (Self::default(), Self::default());
        for piece in &self.pieces {
            let cut = (s - piece.s).clamp(0.0, piece.length);
            if cut > SHORTEST {
                head.pieces.push(Piece {
                    length: cut,
                    ..*piece
                });
            }
            if piece.length - cut > SHORTEST {
                tail.pieces.push(Piece {
                    s: (piece.s + cut - s).max(0.0),
                    start: piece.at(cut),
                    length: piece.length - cut,
                    ..*piece
                });
            }
        }
        (head, tail)
    }

    /// Continues it by an arc from `from` that ends at `to`, touching the direction of `from`.
    fn arc_to(&mut self, from: Pose, to: Point) {
        let chord = to - from.position;
        let distance = chord.norm();
        if distance < SHORTEST {
            return;
        }
        let angle = angle_between(from.heading, chord.y.atan2(chord.x));
        let mut curvature = 2.0 * angle.sin() / distance;
        let mut length = if angle.abs() < 1e-9 {
            distance
        } else {
            distance * angle / angle.sin()
        };
        if curvature.abs() < LINE {
            (curvature, length) = (0.0, distance);
        }
        let s = self.length();
        let mut start = from;
        if curvature == 0.0 {
            start.heading = chord.y.atan2(chord.x);
            // Two lines in one direction are one line.
            if let Some(last) = self.pieces.last_mut()
                && last.curvature == 0.0
                && angle_between(last.start.heading, start.heading).abs() < 1e-6
            {
                let whole = to - last.start.position;
                last.start.heading = whole.y.atan2(whole.x);
                last.length = whole.norm();
                return;
            }
        }
        self.pieces.push(Piece {
            s,
            start,
            length,
            curvature,
        });
    }

    /// Continues it by two arcs (a biarc) from one pose to another.
    pub fn biarc_to(&mut self, from: Pose, to: Pose) {
        let joint = joint(&from, &to);
        self.arc_to(from, joint);
        let there = match self.pieces.last() {
            Some(last) => last.at(last.length).heading,
            None => from.heading,
        };
        let middle = Pose {
            position: joint,
            heading: there,
        };
        self.arc_to(middle, to.position);
    }
}

/// Where the two arcs of a biarc meet: that of equal tangent lengths.
fn joint(from: &Pose, to: &Pose) -> Point {
    let (a, b) = (from.forward(), to.forward());
    let v = to.position - from.position;
    let sum = a + b;
    let denominator = 2.0 * (1.0 - a.dot(&b));
    let along = v.dot(&sum);
    let squared = v.norm_squared();
    let d = if denominator < 1e-9 {
        let along = v.dot(&b);
        if along.abs() < 1e-9 {
            squared.sqrt() / 2.0
        } else {
            squared / (4.0 * along)
        }
    } else {
        let root = (along * along + denominator * squared).sqrt();
        (root - along) / denominator
    };
    Point::from((from.position.coords + a * d + to.position.coords - b * d) / 2.0)
}

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
const MAX_DEPTH: usize = 14;

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
        MAX_DEPTH,
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

/// A function of the arc length in straight pieces: points (s, value), metres.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Profile(pub Vec<(f64, f64)>);

impl Profile {
    /// The value at an arc length; that of the nearest end beyond them.
    pub fn at(&self, s: f64) -> f64 {
        let next = self.0.partition_point(|(at, _)| *at <= s);
        match (self.0.get(next.wrapping_sub(1)), self.0.get(next)) {
            (Some((s0, v0)), Some((s1, v1))) => v0 + (v1 - v0) * (s - s0) / (s1 - s0),
            (Some((_, v)), None) | (None, Some((_, v))) => *v,
            (None, None) => 0.0,
        }
    }

    /// The same with as few points as keep every one within `tolerance`, metres.
    pub fn simplified(&self, tolerance: f64) -> Self {
        let all = &self.0;
        let mut keep = vec![false; all.len()];
        let mut spans = vec![(0, all.len().saturating_sub(1))];
        while let Some((from, to)) = spans.pop() {
            let (Some(a), Some(b)) = (all.get(from), all.get(to)) else {
                break;
            };
            keep[from] = true;
            keep[to] = true;
            let chord = |s: f64| a.1 + (b.1 - a.1) * (s - a.0) / (b.0 - a.0);
            let off = |i: &usize| (all[*i].1 - chord(all[*i].0)).abs();
            let worst = (from + 1..to).max_by(|i, j| off(i).total_cmp(&off(j)));
            if let Some(worst) = worst.filter(|i| off(i) > tolerance) {
                spans.push((from, worst));
                spans.push((worst, to));
            }
        }
        let kept = all.iter().zip(keep).filter(|(_, keep)| *keep);
        Self(kept.map(|(point, _)| *point).collect())
    }

    /// The part between two arc lengths, counted from the first.
    pub fn part(&self, from: f64, to: f64) -> Self {
        let inside = self.0.iter().filter(|(s, _)| *s > from && *s < to);
        let ends = [(from, self.at(from)), (to, self.at(to))];
        let all = ends[..1].iter().chain(inside).chain(&ends[1..]);
        Self(all.map(|(s, value)| (s - from, *value)).collect())
    }

    /// This less another one that has values at the same places.
    pub fn less(&self, other: &Self) -> Self {
        let pairs = self.0.iter().zip(&other.0);
        Self(
            pairs
                .map(|((s, a), (_, b))| (*s, (a - b).max(0.0)))
                .collect(),
        )
    }
}

/// The arc lengths at which borders are looked at: close to each other, and at both ends.
pub fn samples(curve: &Curve) -> Vec<f64> {
    let length = curve.length();
    let step = (length / 4000.0)
        .clamp(SAMPLE_SPACING, 1.0)
        .min(length / 8.0);
    let count = (length / step).ceil().max(1.0) as usize;
    let mut all: Vec<f64> = (0..=count)
        .map(|i| length * i as f64 / count as f64)
        .collect();
    // Borders have their kinks where pieces have theirs: curvature changes there.
    all.extend(curve.pieces.iter().skip(1).map(|p| p.s));
    all.sort_by(f64::total_cmp);
    all.dedup_by(|a, b| (*a - *b).abs() < 1e-4);
    all
}

/// As close as samples are, metres.
const SAMPLE_SPACING: f64 = 0.1;

/// Borders farther to the side than this are not looked for, metres.
const MAX_OFFSET: f64 = 200.0;

/// The places of a border at arc lengths of the curve: where the lines across the curve meet it.
pub fn profile(curve: &Curve, border: &Polyline, at: &[f64]) -> Profile {
    let points = border.points();
    let mut values = Vec::with_capacity(at.len());
    let across = |pose: &Pose, p: &Point| (p - pose.position).dot(&pose.left());
    let mut near = points.first().map_or(0.0, |p| across(&curve.at(0.0), p));
    let mut segment = 0;
    for (i, s) in at.iter().enumerate() {
        let pose = curve.at(*s);
        let end = match i {
            0 => points.first(),
            _ if i + 1 == at.len() => points.last(),
            _ => None,
        };
        if let Some(p) = end {
            near = across(&pose, p);
            segment = if i == 0 { 0 } else { points.len() - 2 };
        } else if let Some((t, place)) = crossing(&pose, points, near, segment) {
            (near, segment) = (t, place);
        }
        values.push((*s, near));
    }
    Profile(values)
}

/// Segments around the last one that are looked at first.
const SEARCH_WINDOW: usize = 12;

/// Where the line across a pose meets a border: the crossing nearest to the one before.
fn crossing(pose: &Pose, points: &[Point], near: f64, segment: usize) -> Option<(f64, usize)> {
    let within = |from: usize, to: usize| {
        let pairs = points[from..=to].windows(2).enumerate();
        let found = pairs.filter_map(|(i, pair)| {
            let (a, b) = (pose.to_local(&pair[0]), pose.to_local(&pair[1]));
            if a.x * b.x > 0.0 || a.x == b.x {
                return None;
            }
            let t = a.y + (b.y - a.y) * a.x / (a.x - b.x);
            (t.abs() < MAX_OFFSET).then_some((t, from + i))
        });
        found.min_by(|a, b| (a.0 - near).abs().total_cmp(&(b.0 - near).abs()))
    };
    let last = points.len() - 1;
    let from = segment.saturating_sub(SEARCH_WINDOW);
    within(from, (segment + SEARCH_WINDOW).min(last)).or_else(|| within(0, last))
}

/// How far the border that a profile tells is from a border, either way, metres.
pub fn deviation(curve: &Curve, told: &Profile, border: &Polyline) -> f64 {
    let mut at: Vec<f64> = told.0.iter().map(|(s, _)| *s).collect();
    let length = curve.length();
    let count = (length / 0.25).ceil().clamp(8.0, 8000.0);
    at.extend((0..=count as usize).map(|i| length * i as f64 / count));
    at.sort_by(f64::total_cmp);
    let place = |s: &f64| {
        let pose = curve.at(*s);
        pose.position + pose.left() * told.at(*s)
    };
    let points: Vec<Point> = at.iter().map(place).collect();
    let away = |line: &Polyline, p: &Point| line.project(p).d.abs();
    let off = points.iter().map(|p| away(border, p)).fold(0.0, f64::max);
    // What is missing at the ends, or cut off at a corner.
    let Some(line) = Polyline::new(points) else {
        return off;
    };
    let missing = border.points().iter().map(|p| away(&line, p));
    missing.fold(off, f64::max)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    #[test]
    fn a_biarc_ends_where_and_as_it_shall_without_a_kink() {
        let cases = [
            (Pose::new(0.0, 0.0, 0.0), Pose::new(10.0, 2.0, 0.3)),
            (Pose::new(5.0, 1.0, 1.0), Pose::new(5.0, 9.0, 2.5)),
            (Pose::new(1e6, -2e6, -3.0), Pose::new(1e6 - 8.0, -2e6, 3.0)),
            (Pose::new(0.0, 0.0, 0.5), Pose::new(9.0, 0.0, 0.5)),
        ];
        for (from, to) in cases {
            let mut curve = Curve::default();
            curve.biarc_to(from, to);
            let end = curve.at(curve.length());
            assert!((end.position - to.position).norm() < 1e-6, "{from:?}");
            assert!(angle_between(end.heading, to.heading).abs() < 1e-6);
            assert!(angle_between(curve.at(0.0).heading, from.heading).abs() < 1e-6);
            for pair in curve.pieces.windows(2) {
                let end = pair[0].at(pair[0].length);
                assert!((end.position - pair[1].start.position).norm() < 1e-6);
                assert!(angle_between(end.heading, pair[1].start.heading).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn straight_on_is_one_line() {
        let mut curve = Curve::default();
        curve.biarc_to(Pose::new(0.0, 0.0, 0.0), Pose::new(10.0, 0.0, 0.0));
        curve.biarc_to(Pose::new(10.0, 0.0, 0.0), Pose::new(30.0, 0.0, 0.0));
        assert_eq!(curve.pieces.len(), 1);
        assert!((curve.length() - 30.0).abs() < 1e-12);
        assert!((curve.at(12.0).position.x - 12.0).abs() < 1e-12);
    }

    #[test]
    fn a_border_beside_a_line_keeps_its_corners() {
        let mut curve = Curve::default();
        curve.biarc_to(Pose::new(0.0, 0.0, 0.0), Pose::new(20.0, 0.0, 0.0));
        let border = [(0.0, 3.0), (10.0, 3.0), (20.0, 5.0)];
        let border = Polyline::new(border.map(|(x, y)| Point::new(x, y))).unwrap();
        let full = profile(&curve, &border, &samples(&curve));
        let few = full.simplified(1e-3);
        assert!(few.0.len() <= 4, "{few:?}");
        for (s, t) in [(0.0, 3.0), (5.0, 3.0), (15.0, 4.0), (20.0, 5.0)] {
            assert!((few.at(s) - t).abs() < 2e-3, "{s}");
        }
        assert!(deviation(&curve, &few, &border) < 2e-3);
    }

    #[test]
    fn widths_are_not_negative() {
        let a = Profile(vec![(0.0, 1.0), (5.0, 2.0)]);
        let b = Profile(vec![(0.0, 3.0), (5.0, 1.5)]);
        assert_eq!(a.less(&b).0, [(0.0, 0.0), (5.0, 0.5)]);
    }
}
