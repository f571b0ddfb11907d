//! Positions, velocities and accelerations to the Frenet frame and back: what tests compare with.
//!
//! Velocities and accelerations are taken as vectors, which is the same as in [`super::frenet`]'s source without the
//! singularity at right angles to the path.

use super::{Frenet, FrenetError, Point, ReferencePath, Vector};

/// A motion along a reference path: each coordinate with its first and second derivative by time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrenetMotion {
    /// s in m, ṡ in m/s, s̈ in m/s².
    pub s: [f64; 3],
    /// d in m, ḋ in m/s, d̈ in m/s².
    pub d: [f64; 3],
}

/// A motion in the plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlaneMotion {
    /// Metres.
    pub position: Point,
    /// m/s.
    pub velocity: Vector,
    /// m/s².
    pub acceleration: Vector,
}

impl ReferencePath {
    /// The point of the plane at these coordinates.
    ///
    /// # Errors
    /// The offset is not within the radius of curvature there, or a coordinate is not finite.
    pub fn to_plane(&self, at: Frenet) -> Result<Point, FrenetError> {
        let here = self.checked(at)?.0;
        Ok(here.position + here.normal() * at.d)
    }

    /// The coordinates of a motion whose position has the coordinates `at`.
    ///
    /// # Errors
    /// The offset is not within the radius of curvature.
    pub fn motion_at(&self, at: Frenet, motion: &PlaneMotion) -> Result<FrenetMotion, FrenetError> {
        let (here, stretch) = self.checked(at)?;
        let (tangent, normal) = (here.tangent(), here.normal());
        let (kappa, kappa_s) = (here.curvature, here.curvature_rate);
        let s_dot = motion.velocity.dot(&tangent) / stretch;
        let d_dot = motion.velocity.dot(&normal);
        let turning = s_dot * (kappa_s * s_dot * at.d + 2.0 * kappa * d_dot);
        let s_ddot = (motion.acceleration.dot(&tangent) + turning) / stretch;
        let d_ddot = motion.acceleration.dot(&normal) - kappa * s_dot * s_dot * stretch;
        Ok(FrenetMotion {
            s: [at.s, s_dot, s_ddot],
            d: [at.d, d_dot, d_ddot],
        })
    }

    /// The motion in the plane that has these coordinates.
    ///
    /// # Errors
    /// The offset is not within the radius of curvature, or a coordinate is not finite.
    pub fn motion_to_plane(&self, motion: &FrenetMotion) -> Result<PlaneMotion, FrenetError> {
        let ([s, s_dot, s_ddot], [d, d_dot, d_ddot]) = (motion.s, motion.d);
        let (here, stretch) = self.checked(Frenet { s, d })?;
        let (tangent, normal) = (here.tangent(), here.normal());
        let (kappa, kappa_s) = (here.curvature, here.curvature_rate);
        let along = s_ddot * stretch - s_dot * (kappa_s * s_dot * d + 2.0 * kappa * d_dot);
        let across = d_ddot + kappa * s_dot * s_dot * stretch;
        Ok(PlaneMotion {
            position: here.position + normal * d,
            velocity: tangent * (s_dot * stretch) + normal * d_dot,
            acceleration: tangent * along + normal * across,
        })
    }
}
