//! Open polylines by arc length: points along them, and the nearest point to something.

use super::{Point, Pose};

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
}
