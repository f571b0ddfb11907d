//! Curves of lines and arcs that continue each other without a kink: reference lines for roads given by borders.

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

#[cfg(test)]
mod tests {
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
}
