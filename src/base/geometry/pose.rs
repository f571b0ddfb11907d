//! A position with a heading, and the frame it spans.

use super::{Point, Vector};

/// A position and a heading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// Position, metres.
    pub position: Point,
    /// Heading, radians.
    pub heading: f64,
}

impl Pose {
    /// A pose at (`x`, `y`) metres pointing along `heading` radians.
    #[must_use]
    pub fn new(x: f64, y: f64, heading: f64) -> Self {
        Self {
            position: Point::new(x, y),
            heading,
        }
    }

    /// The unit vector along the heading.
    #[must_use]
    pub fn forward(&self) -> Vector {
        Vector::new(self.heading.cos(), self.heading.sin())
    }

    /// The unit vector to the left of the heading.
    #[must_use]
    pub fn left(&self) -> Vector {
        Vector::new(-self.heading.sin(), self.heading.cos())
    }

    /// A world vector in this frame: x forward, y left.
    #[must_use]
    pub fn vector_to_local(&self, v: &Vector) -> Vector {
        Vector::new(v.dot(&self.forward()), v.dot(&self.left()))
    }

    /// A world point in this frame: x forward, y left.
    #[must_use]
    pub fn to_local(&self, p: &Point) -> Point {
        Point::from(self.vector_to_local(&(p - self.position)))
    }

    /// A point of this frame in the world.
    #[must_use]
    pub fn to_world(&self, p: &Point) -> Point {
        self.position + self.forward() * p.x + self.left() * p.y
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn local_and_back() {
        let pose = Pose::new(3.0, -2.0, 2.1);
        let p = Point::new(7.5, 1.25);
        assert!((pose.to_world(&pose.to_local(&p)) - p).norm() < 1e-12);
        let left = Pose::new(0.0, 0.0, 0.0).to_local(&Point::new(0.0, 1.0));
        assert!(left.y > 0.0, "left is positive");
    }
}
