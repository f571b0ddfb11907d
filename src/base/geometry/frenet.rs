//! Coordinates along a reference path, headings and curvatures beside it, and motions in its frame and back.
//!
//! Source: Werling, Ziegler, Kammel and Thrun, Optimal Trajectory Generation for Dynamic Street
//! Scenarios in a Frenet Frame, ICRA 2010.
//!
//! Positions, velocities and accelerations to the Frenet frame and back: what tests compare with.
//!
//! Velocities and accelerations are taken as vectors, which is the same as in [`self`]'s source without the
//! singularity at right angles to the path.

use super::{PathPoint, Point, ReferencePath, Vector, normalize_angle};

/// A position beside a reference path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frenet {
    /// Arc length, metres; below 0 and above the path's length beyond its ends.
    pub s: f64,
    /// Offset, metres; positive on the left.
    pub d: f64,
}

/// A lateral profile over the arc length: d, d' = dd/ds and d'' = d²d/ds².
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LateralProfile {
    /// Metres.
    pub d: f64,
    /// Without a unit.
    pub d_s: f64,
    /// 1/m.
    pub d_ss: f64,
}

/// Why something has no coordinates along a path, or coordinates no place.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum FrenetError {
    /// Two points of the path are equally near.
    #[error("the path is equally near, at {distance} m, at s = {} m and s = {} m", .s.0, .s.1)]
    Ambiguous {
        /// Both arc lengths, metres, the smaller one first.
        s: (f64, f64),
        /// Distance of both, metres.
        distance: f64,
    },
    /// The offset reaches the centre of the path's curvature or lies beyond it.
    #[error("at s = {s} m an offset of {d} m is not within the radius of the curve, {radius} m")]
    BeyondCurvature {
        /// Metres.
        s: f64,
        /// Metres.
        d: f64,
        /// Radius of curvature, metres, positive.
        radius: f64,
    },
    /// No point of the path near the hint lies square to it.
    #[error("nothing of the path between s = {from} m and s = {to} m is beside it")]
    NotNear {
        /// Where the search began, metres.
        from: f64,
        /// Where it ended, metres.
        to: f64,
    },
    /// The heading is at right angles to the path, so d' is not a number.
    #[error("the heading is at right angles to the path at s = {s} m")]
    RightAngle {
        /// Metres.
        s: f64,
    },
    /// A coordinate is not a finite number.
    #[error("a coordinate is not a finite number")]
    NotFinite,
}

/// Below this 1 − κd counts as 0: the normals of the path meet there.
const SINGULAR: f64 = 1e-9;

/// Below this a cosine counts as 0.
const SQUARE: f64 = 1e-9;

impl PathPoint {
    /// The unit vector along the path.
    #[must_use]
    pub fn tangent(&self) -> Vector {
        Vector::new(self.heading.cos(), self.heading.sin())
    }

    /// The unit vector to the left of the path.
    #[must_use]
    pub fn normal(&self) -> Vector {
        Vector::new(-self.heading.sin(), self.heading.cos())
    }

    /// 1 − κd: how much shorter or longer the way at offset `d` is than the path.
    ///
    /// # Errors
    /// The offset is not within the radius of curvature.
    pub fn stretch(&self, at: Frenet) -> Result<f64, FrenetError> {
        let stretch = 1.0 - self.curvature * at.d;
        if stretch > SINGULAR {
            return Ok(stretch);
        }
        Err(FrenetError::BeyondCurvature {
            s: at.s,
            d: at.d,
            radius: self.curvature.abs().recip(),
        })
    }
}

impl ReferencePath {
    pub(super) fn checked(&self, at: Frenet) -> Result<(PathPoint, f64), FrenetError> {
        if !(at.s.is_finite() && at.d.is_finite()) {
            return Err(FrenetError::NotFinite);
        }
        let here = self.at(at.s);
        let stretch = here.stretch(at)?;
        Ok((here, stretch))
    }

    /// Heading (rad) and curvature (1/m) of what follows `profile` at arc length `s`, at any speed.
    ///
    /// # Errors
    /// The offset is not within the radius of curvature, or a coordinate is not finite.
    pub fn heading_and_curvature(
        &self,
        s: f64,
        profile: &LateralProfile,
    ) -> Result<(f64, f64), FrenetError> {
        let (here, stretch) = self.checked(Frenet { s, d: profile.d })?;
        let delta = profile.d_s.atan2(stretch);
        let (cos, tan) = (delta.cos(), profile.d_s / stretch);
        let drift = here.curvature_rate * profile.d + here.curvature * profile.d_s;
        let curvature =
            ((profile.d_ss + drift * tan) * cos * cos / stretch + here.curvature) * cos / stretch;
        Ok((normalize_angle(here.heading + delta), curvature))
    }

    /// The lateral profile of a motion with `heading` (rad) and `curvature` (1/m) at the coordinates `at`.
    ///
    /// Against the path too: d' is by the path's own arc length.
    ///
    /// # Errors
    /// The heading is at right angles to the path, or the offset is not within the radius of curvature.
    pub fn profile_at(
        &self,
        at: Frenet,
        heading: f64,
        curvature: f64,
    ) -> Result<LateralProfile, FrenetError> {
        let (here, stretch) = self.checked(at)?;
        let (sin, cos) = (heading - here.heading).sin_cos();
        if cos.abs() < SQUARE {
            return Err(FrenetError::RightAngle { s: at.s });
        }
        let tan = sin / cos;
        let d_s = stretch * tan;
        let drift = here.curvature_rate * at.d + here.curvature * d_s;
        let bend = curvature * stretch / cos - here.curvature;
        Ok(LateralProfile {
            d: at.d,
            d_s,
            d_ss: -drift * tan + stretch / (cos * cos) * bend,
        })
    }
}

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
