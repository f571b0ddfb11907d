//! The only conversion between nalgebra, used by the program, and parry's own vectors.

use parry2d_f64::math;

use super::{Point, Pose, Vector};

pub(super) fn point(p: &Point) -> math::Vector {
    math::Vector::new(p.x, p.y)
}

pub(super) fn vector(v: &Vector) -> math::Vector {
    math::Vector::new(v.x, v.y)
}

pub(super) fn pose(p: &Pose) -> math::Pose {
    math::Pose::new(point(&p.position), p.heading)
}
