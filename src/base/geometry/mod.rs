//! Plane geometry: poses, footprints with exact distances, polylines and polygons.
//!
//! Lengths are metres, angles radians (counter-clockwise, 0 along +x), times seconds.
//! This is the only module that knows parry's own vector types.

mod area;
mod curve;
mod footprint;
mod frenet;
mod polygon;
mod reference_path;
mod shape;
mod sweep;

pub use area::{Area, Outside};
pub use curve::{Polyline, Projection, distance_to_segment};
pub use footprint::{Contact, Footprint, Gap, Placed, Tip};
pub use frenet::{Frenet, FrenetError, FrenetMotion, LateralProfile, PlaneMotion};
pub use polygon::{
    Bounds, BoxTree, Rings, contains, convex_hull, convex_overlap, part_within, ring_within,
    within_at,
};
pub use reference_path::{PathFrame, PathPoint, ReferencePath, ReferencePathError};
pub use shape::{SemiTrailer, Shape, ShapeError, Truck};
pub use sweep::Sweep;

use std::f64::consts::{PI, TAU};

use parry2d_f64::math;

/// A point in the plane, metres.
pub type Point = nalgebra::Point2<f64>;

/// A displacement (m), velocity (m/s) or acceleration (m/s²) in the plane.
pub type Vector = nalgebra::Vector2<f64>;

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

/// `angle` brought into (−π, π].
#[must_use]
pub fn normalize_angle(angle: f64) -> f64 {
    let wrapped = angle.rem_euclid(TAU);
    if wrapped > PI { wrapped - TAU } else { wrapped }
}

/// The signed turn from `from` to `to`, in (−π, π].
#[must_use]
pub fn angle_between(from: f64, to: f64) -> f64 {
    normalize_angle(to - from)
}

fn point(p: &Point) -> math::Vector {
    math::Vector::new(p.x, p.y)
}

fn vector(v: &Vector) -> math::Vector {
    math::Vector::new(v.x, v.y)
}

fn pose(p: &Pose) -> math::Pose {
    math::Pose::new(point(&p.position), p.heading)
}

#[cfg(test)]
mod frenet_tests;

#[cfg(test)]
mod sweep_tests;

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

    #[test]
    fn wraps_to_the_half_open_circle() {
        assert!((normalize_angle(3.0 * PI) - PI).abs() < 1e-12);
        assert!((normalize_angle(-PI) - PI).abs() < 1e-12);
        assert!((angle_between(3.0, -3.0) - (TAU - 6.0)).abs() < 1e-12);
    }
}
