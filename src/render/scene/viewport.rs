//! The part of the world that a map shows, and what lies in it.

use nearmiss_base::geometry::{Bounds, Point, Pose, Vector};

/// A rectangle of the world, turned so that what lies ahead of its frame is up on the map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Viewport {
    /// What is in the middle, and the direction that is up.
    pub frame: Pose,
    /// Half of its width and of its height, metres.
    pub half: (f64, f64),
    /// Up and left on the map, as directions of the world.
    axes: (Vector, Vector),
}

impl Viewport {
    /// The rectangle around a frame; `half` its width and half its height, metres.
    #[must_use]
    pub fn new(frame: Pose, half: (f64, f64)) -> Self {
        Self {
            frame,
            half,
            axes: (frame.forward(), frame.left()),
        }
    }

    /// Where a point is, metres from the middle: x to the right, y up.
    #[must_use]
    pub fn at(&self, p: &Point) -> (f64, f64) {
        let turned = self.turned(&(p - self.frame.position));
        (turned.x, turned.y)
    }

    /// A direction of the world on the map: x to the right, y up.
    #[must_use]
    pub fn turned(&self, v: &Vector) -> Vector {
        Vector::new(-v.dot(&self.axes.1), v.dot(&self.axes.0))
    }

    /// Whether something within `bounds` may be seen.
    #[must_use]
    pub fn sees(&self, bounds: &Bounds) -> bool {
        let half = (bounds.max - bounds.min) / 2.0;
        let reach = |axis: &Vector| (half.x * axis.x).abs() + (half.y * axis.y).abs();
        let (x, y) = self.at(&bounds.center());
        x.abs() <= self.half.0 + reach(&self.axes.1) && y.abs() <= self.half.1 + reach(&self.axes.0)
    }

    /// Whether something around these points may be seen; nothing is around none.
    pub fn sees_any<'a>(&self, points: impl IntoIterator<Item = &'a Point>) -> bool {
        Bounds::from_points(points).is_some_and(|bounds| self.sees(&bounds))
    }

    /// Whether something within `reach` metres of a point may be seen.
    #[must_use]
    pub fn sees_around(&self, p: &Point, reach: f64) -> bool {
        let (x, y) = self.at(p);
        x.abs() <= self.half.0 + reach && y.abs() <= self.half.1 + reach
    }

    /// Whether a point is seen.
    #[must_use]
    pub fn sees_point(&self, p: &Point) -> bool {
        self.sees_around(p, 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_are_seen_where_they_reach_into_the_turned_rectangle() {
        let east = Viewport::new(Pose::new(10.0, 0.0, 0.0), (5.0, 20.0));
        // Ahead is up: 20 m to the east are seen, and 5 m to the north.
        assert_eq!(east.at(&Point::new(13.0, 1.0)), (-1.0, 3.0));
        let around = |x: f64, y: f64| Bounds {
            min: Point::new(x - 2.0, y - 1.0),
            max: Point::new(x + 2.0, y + 1.0),
        };
        assert!(east.sees(&around(31.9, 0.0)) && !east.sees(&around(32.1, 0.0)));
        assert!(east.sees(&around(10.0, 5.9)) && !east.sees(&around(10.0, 6.1)));
        let slanted = Viewport::new(Pose::new(0.0, 0.0, 0.6), (5.0, 5.0));
        assert!(slanted.sees(&around(6.0, 2.0)) && !slanted.sees(&around(9.0, 9.0)));
    }
}
