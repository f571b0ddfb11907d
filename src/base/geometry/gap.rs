//! Distances and nearest points between bodies and points.

use parry2d_f64::query::{self, ClosestPoints};

use super::{Placed, Point, convert};

/// One end of a measured gap.
#[derive(Debug, Clone, Copy)]
pub enum Tip<'a> {
    /// A point of the world.
    Point(Point),
    /// A body at its pose.
    Body(Placed<'a>),
}

/// The gap between two things.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gap {
    /// Exact distance, metres; 0 where they touch or overlap.
    pub metres: f64,
    /// The nearest points of the first and of the second; both in the middle where they touch.
    pub ends: (Point, Point),
}

impl Gap {
    /// The gap from one thing to another.
    #[must_use]
    pub fn between(from: &Tip<'_>, to: &Tip<'_>) -> Self {
        match (from, to) {
            (Tip::Point(a), Tip::Point(b)) => Self::of_points(*a, *b),
            (Tip::Body(body), Tip::Point(p)) => Self::of_points(nearest(body, p), *p),
            (Tip::Point(p), Tip::Body(body)) => Self::of_points(*p, nearest(body, p)),
            (Tip::Body(a), Tip::Body(b)) => Self::of_bodies(a, b),
        }
    }

    fn of_points(a: Point, b: Point) -> Self {
        Self {
            metres: (b - a).norm(),
            ends: (a, b),
        }
    }

    fn of_bodies(a: &Placed<'_>, b: &Placed<'_>) -> Self {
        let found = query::closest_points(
            &convert::pose(&a.pose),
            &*a.footprint.collider,
            &convert::pose(&b.pose),
            &*b.footprint.collider,
            f64::MAX,
        );
        match found {
            Ok(ClosestPoints::WithinMargin(p, q)) => {
                let ends = (Point::new(p.x, p.y), Point::new(q.x, q.y));
                // The same number as everywhere else.
                Self {
                    metres: a.distance(b),
                    ends,
                }
            }
            _ => {
                let middle = nalgebra::center(&a.pose.position, &b.pose.position);
                Self {
                    metres: a.distance(b),
                    ends: (middle, middle),
                }
            }
        }
    }
}

/// The point of a body that is nearest to `p`; `p` itself inside.
fn nearest(body: &Placed<'_>, p: &Point) -> Point {
    let pose = convert::pose(&body.pose);
    let found = body
        .footprint
        .collider
        .project_point(&pose, convert::point(p), true);
    Point::new(found.point.x, found.point.y)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::super::{Footprint, Pose, Shape};
    use super::*;

    #[test]
    fn distances_that_can_be_worked_out_by_hand() {
        let car = Footprint::new(Shape::rectangle(4.0, 2.0)).unwrap();
        let here = Tip::Body(car.at(Pose::new(0.0, 0.0, 0.0)));
        // Centres 10 m apart: 2 m of each car are in between.
        let ahead = Gap::between(&here, &Tip::Body(car.at(Pose::new(10.0, 0.0, 0.0))));
        assert!((ahead.metres - 6.0).abs() < 1e-9);
        assert!((ahead.ends.0.x - 2.0).abs() < 1e-6 && (ahead.ends.1.x - 8.0).abs() < 1e-6);
        // From the corner (2, 1): 3 across and 4 up.
        let point = Gap::between(&here, &Tip::Point(Point::new(5.0, 5.0)));
        assert!((point.metres - 5.0).abs() < 1e-9);
        assert!((point.ends.0 - Point::new(2.0, 1.0)).norm() < 1e-9);
        let back = Gap::between(&Tip::Point(Point::new(5.0, 5.0)), &here);
        assert_eq!((back.ends.0, back.ends.1), (point.ends.1, point.ends.0));
        // Points: 3, 4, 5 again.
        let points = Gap::between(
            &Tip::Point(Point::new(1.0, 1.0)),
            &Tip::Point(Point::new(4.0, 5.0)),
        );
        assert!((points.metres - 5.0).abs() < 1e-12);
        // Inside, and overlapping.
        let inside = Gap::between(&here, &Tip::Point(Point::new(1.0, 0.5)));
        assert_eq!(inside.metres, 0.0);
        let over = Gap::between(&here, &Tip::Body(car.at(Pose::new(3.0, 0.5, 0.3))));
        assert_eq!(over.metres, 0.0);
    }
}
