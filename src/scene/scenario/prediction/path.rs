//! The line an obstacle follows: straight, an arc, or the middle of a lane.

use std::sync::Arc;

use nearmiss_base::geometry::{Polyline, Pose, Vector, angle_between};

/// Poses by the distance driven.
#[derive(Debug, Clone)]
pub enum Path {
    /// Straight ahead.
    Straight(Pose),
    /// A circle; positive curvature (1/m) turns left.
    Arc {
        /// The beginning.
        start: Pose,
        /// 1/m.
        curvature: f64,
    },
    /// Along a line, back to it from beside it.
    Lane {
        /// The middle of the lane.
        line: Arc<Polyline>,
        /// Arc length beside which it begins, metres.
        s: f64,
        /// Offset there, metres; positive on the left.
        offset: f64,
        /// Change of the offset per metre there.
        slope: f64,
        /// Heading there that the offset's slope does not explain, radians.
        skew: f64,
    },
}

/// Metres in which an offset from the middle of a lane fades to 1/e, after a start without slope.
const RETURN: f64 = 10.0;

/// The heading of a body on a line is that of the chord between its axles, this long, metres.
const CHORD: f64 = 3.0;

/// Steeper than this no obstacle crosses a lane.
const STEEPEST: f64 = 1.0;

impl Path {
    /// Along `line` from `start`.
    #[must_use]
    pub fn along(line: Arc<Polyline>, start: &Pose) -> Self {
        let at = line.project(&start.position);
        let chord = chord(&line, at.s);
        let offset = (start.position - chord.position).dot(&chord.left());
        let turn = angle_between(chord.heading, start.heading);
        let slope = turn.tan().clamp(-STEEPEST, STEEPEST);
        Self::Lane {
            line,
            s: at.s,
            offset,
            slope,
            skew: turn - slope.atan(),
        }
    }

    /// The pose after `distance` metres.
    #[must_use]
    pub fn pose_at(&self, distance: f64) -> Pose {
        match self {
            Self::Straight(start) => Pose {
                position: start.position + start.forward() * distance,
                heading: start.heading,
            },
            Self::Arc { start, curvature } => {
                let turn = curvature * distance;
                // The chord of the arc, without the division where it is straight.
                let half = turn / 2.0;
                let chord = if half.abs() < 1e-6 {
                    distance
                } else {
                    distance * half.sin() / half
                };
                let heading = start.heading + half;
                Pose {
                    position: start.position + Vector::new(heading.cos(), heading.sin()) * chord,
                    heading: start.heading + turn,
                }
            }
            Self::Lane {
                line,
                s,
                offset,
                slope,
                skew,
            } => {
                let on = chord(line, s + distance);
                let fade = (-distance / RETURN).exp();
                let rate = slope + offset / RETURN;
                let d = (offset + rate * distance) * fade;
                let slope = (rate - (offset + rate * distance) / RETURN) * fade;
                Pose {
                    position: on.position + on.left() * d,
                    heading: on.heading + slope.atan() + skew * fade,
                }
            }
        }
    }
}

/// The middle of the chord whose axles are on the line around `s`.
fn chord(line: &Polyline, s: f64) -> Pose {
    let (rear, front) = (line.pose_at(s - CHORD / 2.0), line.pose_at(s + CHORD / 2.0));
    let between = front.position - rear.position;
    Pose {
        position: rear.position + between / 2.0,
        heading: between.y.atan2(between.x),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use nearmiss_base::geometry::Point;

    fn apart(a: &Pose, b: &Pose) -> f64 {
        (a.position - b.position).norm() + angle_between(a.heading, b.heading).abs()
    }

    #[test]
    fn a_quarter_of_a_circle() {
        let arc = |curvature| Path::Arc {
            start: Pose::new(1.0, 2.0, 0.0),
            curvature,
        };
        let quarter = 10.0 * std::f64::consts::FRAC_PI_2;
        let left = arc(0.1).pose_at(quarter);
        assert!(apart(&left, &Pose::new(11.0, 12.0, std::f64::consts::FRAC_PI_2)) < 1e-9);
        let straight = Path::Straight(Pose::new(1.0, 2.0, 0.0));
        assert!(apart(&arc(0.0).pose_at(7.0), &straight.pose_at(7.0)) < 1e-12);
        assert!(apart(&arc(1e-8).pose_at(7.0), &arc(2e-6).pose_at(7.0)) < 1e-3);
    }

    #[test]
    fn a_lane_is_joined_where_one_stands_and_followed_afterwards() {
        let points = [(0., 0.), (50., 0.), (50., 80.)].map(|(x, y)| Point::new(x, y));
        let line = Arc::new(Polyline::new(points).unwrap());
        for (x, y, heading) in [(5.0, 1.2, -0.2), (20.0, -0.7, 0.3), (10.0, 0.0, 1.2)] {
            let start = Pose::new(x, y, heading);
            let path = Path::along(line.clone(), &start);
            assert!(apart(&path.pose_at(0.0), &start) < 1e-9, "{x} {y}");
            // It begins into the direction of the heading, as far as lanes are crossed at all.
            let moved = path.pose_at(0.01).position - start.position;
            let steep = heading.abs() > std::f64::consts::FRAC_PI_4;
            assert!(steep || (moved.y.atan2(moved.x) - heading).abs() < 0.01);
            let far = path.pose_at(110.0);
            assert!((far.position.x - 50.0).abs() < 0.01, "{far:?}");
            assert!((far.heading - std::f64::consts::FRAC_PI_2).abs() < 0.01);
        }
    }
}
