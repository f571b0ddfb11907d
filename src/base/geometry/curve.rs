//! Open polylines by arc length with the nearest point on them, and quintic B-splines.
//!
//! Source of the splines: de Boor, A Practical Guide to Splines, 1978.

use super::{Point, Pose, Vector};

/// A chain of at least two points without repeated neighbours, measured along its length.
///
/// ```
/// use nearmiss_base::geometry::{Point, Polyline};
///
/// let corner = [(0.0, 0.0), (10.0, 0.0), (10.0, 5.0)].map(|(x, y)| Point::new(x, y));
/// let line = Polyline::new(corner).unwrap();
/// assert_eq!(line.length(), 15.0);
/// let beside = line.project(&Point::new(4.0, 2.0));
/// assert_eq!((beside.s, beside.d), (4.0, 2.0)); // 4 m along it, 2 m to its left
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Polyline {
    points: Vec<Point>,
    /// Arc length at each point, metres, starting at 0.
    arc: Vec<f64>,
}

/// Where a point lies beside a polyline.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Projection {
    /// Arc length of the nearest point, metres.
    pub s: f64,
    /// Signed distance, metres; positive on the left.
    pub d: f64,
}

/// Points closer than this are one point, metres.
const SAME_POINT: f64 = 1e-9;

/// An arc length this close before a point is at the point, metres: far from the origin rounding moves
/// points by nearly as much, and the direction there must not depend on it.
const AT_POINT: f64 = 1e-7;

impl Polyline {
    /// A polyline through `points` without repeated neighbours; `None` if fewer than two are left.
    pub fn new(points: impl IntoIterator<Item = Point>) -> Option<Self> {
        let mut kept: Vec<Point> = Vec::new();
        let mut arc: Vec<f64> = Vec::new();
        for p in points {
            match (kept.last(), arc.last()) {
                (Some(last), Some(s)) => {
                    let step = (p - last).norm();
                    if step > SAME_POINT {
                        arc.push(s + step);
                        kept.push(p);
                    }
                }
                _ => {
                    kept.push(p);
                    arc.push(0.0);
                }
            }
        }
        (kept.len() >= 2).then_some(Self { points: kept, arc })
    }

    /// The points, in order.
    #[must_use]
    pub fn points(&self) -> &[Point] {
        &self.points
    }

    /// Arc length at each point, metres, starting at 0.
    #[must_use]
    pub fn arc_lengths(&self) -> &[f64] {
        &self.arc
    }

    /// Total arc length, metres.
    #[must_use]
    pub fn length(&self) -> f64 {
        self.arc.last().copied().unwrap_or(0.0)
    }

    /// The point and direction at arc length `s`; continued straight beyond both ends.
    #[must_use]
    pub fn pose_at(&self, s: f64) -> Pose {
        let next = self
            .arc
            .partition_point(|&a| a <= s + AT_POINT)
            .clamp(1, self.points.len() - 1);
        let (from, to) = (self.points[next - 1], self.points[next]);
        let direction = (to - from) / (self.arc[next] - self.arc[next - 1]);
        Pose {
            position: from + direction * (s - self.arc[next - 1]),
            heading: direction.y.atan2(direction.x),
        }
    }

    /// Distance from `p` to the segments that have a part in `window` of the arc length, metres.
    ///
    /// A window beyond an end takes the segment at that end.
    pub(super) fn distance_within(&self, p: &Point, window: std::ops::Range<f64>) -> f64 {
        let last = self.points.len() - 1;
        let from = self
            .arc
            .partition_point(|&a| a <= window.start)
            .clamp(1, last)
            - 1;
        let to = self
            .arc
            .partition_point(|&a| a < window.end)
            .clamp(from + 1, last);
        let ends = self.points[from..=to].windows(2);
        let distances = ends.map(|pair| distance_to_segment(p, &pair[0], &pair[1]));
        distances.fold(f64::MAX, f64::min)
    }

    /// The nearest point of the polyline to `p`, as arc length and signed distance.
    #[must_use]
    pub fn project(&self, p: &Point) -> Projection {
        let mut best = (f64::MAX, Projection { s: 0.0, d: 0.0 });
        for (i, pair) in self.points.windows(2).enumerate() {
            let along = pair[1] - pair[0];
            let length = self.arc[i + 1] - self.arc[i];
            let t = ((p - pair[0]).dot(&along) / (length * length)).clamp(0.0, 1.0);
            let off = p - (pair[0] + along * t);
            let distance = off.norm();
            if distance < best.0 {
                let side = along.perp(&(p - pair[0]));
                best = (
                    distance,
                    Projection {
                        s: self.arc[i] + t * length,
                        d: distance.copysign(side),
                    },
                );
            }
        }
        best.1
    }
}

/// Distance from `p` to the segment from `from` to `to`, metres; the two may be one point.
#[must_use]
pub fn distance_to_segment(p: &Point, from: &Point, to: &Point) -> f64 {
    let (along, off) = (to - from, p - from);
    let squared = along.norm_squared();
    let share = if squared > 0.0 {
        (off.dot(&along) / squared).clamp(0.0, 1.0)
    } else {
        0.0
    };
    (off - along * share).norm()
}

/// Weights of the six control points of a span, one row a power of the parameter, times 120.
const BASIS: [[f64; 6]; 6] = [
    [1.0, 26.0, 66.0, 26.0, 1.0, 0.0],
    [-5.0, -50.0, 0.0, 50.0, 5.0, 0.0],
    [10.0, 20.0, -60.0, 20.0, 10.0, 0.0],
    [-10.0, 20.0, 0.0, -20.0, 10.0, 0.0],
    [5.0, -20.0, 30.0, -20.0, 5.0, 0.0],
    [-1.0, 5.0, -10.0, 10.0, -5.0, 1.0],
];

/// Abscissae and weights of the Gauss-Legendre rule of seven points on [−1, 1].
const GAUSS: [(f64, f64); 7] = [
    (0.0, 0.417_959_183_673_469_4),
    (-0.405_845_151_377_397_2, 0.381_830_050_505_118_9),
    (0.405_845_151_377_397_2, 0.381_830_050_505_118_9),
    (-0.741_531_185_599_394_4, 0.279_705_391_489_276_7),
    (0.741_531_185_599_394_4, 0.279_705_391_489_276_7),
    (-0.949_107_912_342_758_5, 0.129_484_966_168_869_7),
    (0.949_107_912_342_758_5, 0.129_484_966_168_869_7),
];

/// A point of the curve this near to the foot of a perpendicular is one, metres.
pub(super) const SQUARE: f64 = 1e-9;

/// Number of pieces to search where there may be several minima.
const PIECES: u32 = 16;

/// One polynomial piece, over the parameter u in [0, 1].
#[derive(Debug, Clone, Copy)]
pub(super) struct Span {
    /// Coefficients of the powers of u.
    powers: [Vector; 6],
    /// The curve leaves the chord by no more than this, metres.
    pub sagitta: f64,
    /// The first derivative is no shorter than this, metres.
    pub slowest: f64,
}

/// A point of a span with its derivatives by u.
#[derive(Debug, Clone, Copy)]
pub(super) struct Jet {
    pub at: Vector,
    pub first: Vector,
    pub second: Vector,
    pub third: Vector,
}

impl Span {
    /// The piece that six neighbouring control points make.
    pub fn new(control: &[Vector; 6]) -> Self {
        let powers = BASIS.map(|row| {
            let weighted = row.iter().zip(control).map(|(w, c)| c * (w / 120.0));
            weighted.sum()
        });
        // The second derivative is a mean of the second differences of the control points.
        let bend = control
            .windows(3)
            .map(|c| (c[0] - c[1] * 2.0 + c[2]).norm())
            .fold(0.0, f64::max);
        let mut span = Self {
            powers,
            sagitta: bend / 8.0,
            slowest: 0.0,
        };
        let speeds = (0..=8).map(|i| span.first(f64::from(i) / 8.0).norm());
        // Between two samples it can fall by what the second derivative allows in half the way.
        span.slowest = speeds.fold(f64::MAX, f64::min) - bend / 16.0;
        span
    }

    /// The point at `u`.
    pub fn at(&self, u: f64) -> Vector {
        let p = &self.powers;
        ((((p[5] * u + p[4]) * u + p[3]) * u + p[2]) * u + p[1]) * u + p[0]
    }

    /// The first derivative at `u`.
    pub fn first(&self, u: f64) -> Vector {
        let p = &self.powers;
        (((p[5] * (5.0 * u) + p[4] * 4.0) * u + p[3] * 3.0) * u + p[2] * 2.0) * u + p[1]
    }

    /// The second derivative at `u`.
    pub fn second(&self, u: f64) -> Vector {
        let p = &self.powers;
        ((p[5] * (20.0 * u) + p[4] * 12.0) * u + p[3] * 6.0) * u + p[2] * 2.0
    }

    /// The point and its derivatives at `u`.
    pub fn jet(&self, u: f64) -> Jet {
        let p = &self.powers;
        Jet {
            at: self.at(u),
            first: self.first(u),
            second: self.second(u),
            third: (p[5] * (60.0 * u) + p[4] * 24.0) * u + p[3] * 6.0,
        }
    }

    /// Arc length from the beginning of the piece to `u`, metres.
    pub fn arc_to(&self, u: f64) -> f64 {
        let half = u / 2.0;
        let speeds = GAUSS.map(|(x, w)| w * self.first(half * (x + 1.0)).norm());
        half * speeds.iter().sum::<f64>()
    }

    /// The parameter at which the arc length is `arc`, of a piece that is `length` long.
    pub fn parameter_at(&self, arc: f64, length: f64) -> f64 {
        let mut u = (arc / length).clamp(0.0, 1.0);
        for _ in 0..8 {
            let step = (self.arc_to(u) - arc) / self.first(u).norm();
            u = (u - step).clamp(0.0, 1.0);
            if step.abs() < 1e-13 {
                break;
            }
        }
        u
    }

    /// The parameter of the point nearest to `p`.
    pub fn nearest(&self, p: &Vector) -> f64 {
        let distance = |u: f64| (self.at(u) - p).norm_squared();
        let end = if distance(0.0) <= distance(1.0) {
            0.0
        } else {
            1.0
        };
        let foot = self.foot(p, 0.0, 1.0);
        foot.filter(|&u| distance(u) <= distance(end))
            .unwrap_or(end)
    }

    /// The parameter between `from` and `to` of the nearest point that is square to `p`, if there is one.
    ///
    /// Sign changes of the distance's slope are refined with bisected Newton steps. Beyond the radius
    /// of curvature there may be several minima: they are looked for in pieces, and the lowest is taken.
    pub fn foot(&self, p: &Vector, from: f64, to: f64) -> Option<f64> {
        let slope = |u: f64| {
            let first = self.first(u);
            (self.at(u) - p).dot(&first) / first.norm()
        };
        let distance = |u: f64| (self.at(u) - p).norm_squared();
        let mut best: Option<f64> = None;
        let mut low = from;
        // A foot on a joint belongs to both sides, whatever rounding makes of the slope.
        let mut before = slope(from) - SQUARE;
        let farthest = (self.at(0.0) - p).norm() + self.first(0.0).norm() + 8.0 * self.sagitta;
        let one_minimum =
            self.slowest > 0.0 && farthest * 8.0 * self.sagitta < self.slowest * self.slowest;
        let pieces = if one_minimum { 1 } else { PIECES };
        for piece in 1..=pieces {
            let high = from + (to - from) * f64::from(piece) / f64::from(pieces);
            let after = slope(high);
            let rising = after + if piece == pieces { SQUARE } else { 0.0 };
            if before < 0.0 && rising >= 0.0 {
                let u = self.stationary(p, low, high);
                if best.is_none_or(|b| distance(u) < distance(b)) {
                    best = Some(u);
                }
            }
            (low, before) = (high, after);
        }
        best
    }

    /// Distance from `p` to the chord of the piece, metres.
    pub fn distance_to_chord(&self, p: &Vector) -> f64 {
        let ends = [self.at(0.0), self.at(1.0)].map(Point::from);
        distance_to_segment(&Point::from(*p), &ends[0], &ends[1])
    }

    /// The zero of the distance's slope between `low` (falling) and `high` (rising).
    fn stationary(&self, p: &Vector, mut low: f64, mut high: f64) -> f64 {
        let mut u = f64::midpoint(low, high);
        for _ in 0..60 {
            let (off, first) = (self.at(u) - p, self.first(u));
            let slope = off.dot(&first);
            if slope < 0.0 {
                low = u;
            } else {
                high = u;
            }
            let newton = u - slope / (first.norm_squared() + off.dot(&self.second(u)));
            let next = if newton >= low && newton <= high {
                newton
            } else {
                f64::midpoint(low, high)
            };
            let step = (next - u).abs();
            u = next;
            if step < 1e-14 {
                break;
            }
        }
        u
    }
}

#[cfg(test)]
mod tests {

    use super::*;

    fn corner() -> Polyline {
        let points = [(0., 0.), (10., 0.), (10., 0.), (10., 10.)].map(|(x, y)| Point::new(x, y));
        Polyline::new(points).expect("three different points")
    }

    #[test]
    fn length_and_points_along() {
        let line = corner();
        assert_eq!(line.points().len(), 3);
        assert!((line.length() - 20.0).abs() < 1e-12);
        let pose = line.pose_at(15.0);
        assert!((pose.position - Point::new(10., 5.)).norm() < 1e-12);
        assert!((line.pose_at(-1.0).position - Point::new(-1., 0.)).norm() < 1e-12);
    }

    #[test]
    fn left_is_positive() {
        let at = corner().project(&Point::new(4.0, 1.5));
        assert!((at.s - 4.0).abs() < 1e-12 && (at.d - 1.5).abs() < 1e-12);
        assert!(corner().project(&Point::new(12.0, 8.0)).d < 0.0);
        assert!(Polyline::new([Point::origin(), Point::origin()]).is_none());
    }

    fn span() -> Span {
        let control = [
            (0., 0.),
            (1., 0.2),
            (2., 0.1),
            (3., 0.9),
            (3.5, 1.8),
            (4., 3.),
        ];
        Span::new(&control.map(|(x, y)| Vector::new(x, y)))
    }

    #[test]
    fn derivatives_are_those_of_the_curve() {
        let (span, u, h) = (span(), 0.4, 1e-5);
        let jet = span.jet(u);
        let (before, after) = (span.jet(u - h), span.jet(u + h));
        assert!(((after.at - before.at) / (2.0 * h) - jet.first).norm() < 1e-8);
        assert!(((after.first - before.first) / (2.0 * h) - jet.second).norm() < 1e-8);
        assert!(((after.second - before.second) / (2.0 * h) - jet.third).norm() < 1e-7);
    }

    #[test]
    fn arc_length_agrees_with_many_chords_and_turns_back() {
        let span = span();
        let chords: f64 = (0..20_000)
            .map(|i| (span.at(f64::from(i + 1) / 2e4) - span.at(f64::from(i) / 2e4)).norm())
            .sum();
        let length = span.arc_to(1.0);
        assert!((length - chords).abs() < 1e-8, "{length} {chords}");
        let u = span.parameter_at(0.3 * length, length);
        assert!((span.arc_to(u) - 0.3 * length).abs() < 1e-13);
    }

    #[test]
    fn the_curve_stays_by_its_chord() {
        let span = span();
        let (from, to) = (span.at(0.0), span.at(1.0));
        let normal = Vector::new(from.y - to.y, to.x - from.x).normalize();
        let off = |u: f64| (span.at(u) - from).dot(&normal).abs();
        let most = (0..=100)
            .map(|i| off(f64::from(i) / 100.0))
            .fold(0.0, f64::max);
        assert!(most > 0.0 && most <= span.sagitta, "{most}");
    }

    #[test]
    fn the_nearest_point_is_nearest() {
        let span = span();
        for (x, y) in [(2.4, 0.3), (2.4, 2.0), (0.0, 0.0), (9.0, 9.0), (3.1, 0.2)] {
            let p = Vector::new(x, y);
            let found = (span.at(span.nearest(&p)) - p).norm();
            let scanned = (0..=10_000).map(|i| (span.at(f64::from(i) / 1e4) - p).norm());
            assert!(found <= scanned.fold(f64::MAX, f64::min) + 1e-9);
        }
    }
}
