//! Converts path coordinates to vehicle states without computing angles.
//!
//! Source: Werling et al. 2010, appendix I. Angles are kept as sine and cosine, since a plan computes about ten
//! thousand states and shows one in a hundred.

use super::VehicleState;
use nearmiss_base::geometry::{PathFrame, Point, Pose};

/// A moment of a motion along the path: where it is along, and the path there.
#[derive(Debug, Clone, Copy)]
pub(super) struct Station {
    /// Arc length (m), its speed (m/s) and acceleration (m/s²).
    pub s: [f64; 3],
    /// The inverse of the speed, s/m.
    pub slower: f64,
    /// The speed that is wanted here, and that the rules allow, m/s.
    pub wanted: f64,
    pub allowed: f64,
    pub position: Point,
    pub cos: f64,
    pub sin: f64,
    /// 1/m and 1/m².
    pub curvature: f64,
    pub curvature_rate: f64,
}

impl Station {
    pub fn new(s: [f64; 3], at: &PathFrame, (wanted, allowed): (f64, f64)) -> Self {
        Self {
            s,
            slower: s[1].recip(),
            wanted,
            allowed,
            position: at.position,
            cos: at.tangent.x,
            sin: at.tangent.y,
            curvature: at.curvature,
            curvature_rate: at.curvature_rate,
        }
    }
}

/// Offset from the path (m) with its first and second derivative by the arc length.
pub(super) type Offset = [f64; 3];

/// A state with the heading as cosine and sine.
#[derive(Debug, Clone, Copy)]
pub(super) struct Moved {
    /// The rear axle, metres.
    pub x: f64,
    pub y: f64,
    pub cos: f64,
    pub sin: f64,
    pub velocity: f64,
    pub acceleration: f64,
    pub curvature: f64,
}

/// Motions closer to the path's centre of curvature than this share of its radius are rejected.
const NEAREST: f64 = 0.05;

/// The state at a station with an offset; `None` if the offset all but reaches the centre of curvature.
#[inline]
pub(super) fn state(at: &Station, offset: Offset) -> Option<Moved> {
    let [d, d1, d2] = offset;
    let (k, k1) = (at.curvature, at.curvature_rate);
    let stretch = 1.0 - k * d;
    if stretch < NEAREST {
        return None;
    }
    let (closer, [_, s1, s2]) = (stretch.recip(), at.s);
    if d1 == 0.0 {
        // Along the path, as all are whose offset has changed.
        return Some(Moved {
            x: at.position.x - at.sin * d,
            y: at.position.y + at.cos * d,
            cos: at.cos,
            sin: at.sin,
            velocity: s1 * stretch,
            acceleration: s2 * stretch - s1 * s1 * (k1 * d),
            curvature: (d2 * closer + k) * closer,
        });
    }
    let tan = d1 * closer;
    // Divisions are what takes time here.
    let over_cos = (1.0 + tan * tan).sqrt();
    let cos = over_cos.recip();
    let sin = tan * cos;
    let drift = k1 * d + k * d1;
    let curvature = ((d2 + drift * tan) * cos * cos * closer + k) * cos * closer;
    let turn = curvature * stretch * over_cos - k;
    Some(Moved {
        x: at.position.x - at.sin * d,
        y: at.position.y + at.cos * d,
        cos: at.cos * cos - at.sin * sin,
        sin: at.sin * cos + at.cos * sin,
        velocity: s1 * stretch * over_cos,
        acceleration: (s2 * stretch + s1 * s1 * (stretch * tan * turn - drift)) * over_cos,
        curvature,
    })
}

impl Moved {
    pub fn from_state(state: &VehicleState) -> Self {
        let (sin, cos) = state.rear.heading.sin_cos();
        Self {
            x: state.rear.position.x,
            y: state.rear.position.y,
            cos,
            sin,
            velocity: state.velocity,
            acceleration: state.acceleration,
            curvature: state.curvature,
        }
    }

    pub fn whole(&self) -> VehicleState {
        VehicleState {
            rear: Pose::new(self.x, self.y, self.sin.atan2(self.cos)),
            velocity: self.velocity,
            acceleration: self.acceleration,
            curvature: self.curvature,
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use nearmiss_base::geometry::{FrenetMotion, LateralProfile, ReferencePath};

    /// The same state by the vectors of the geometry, which has its own tests.
    #[test]
    fn states_are_those_of_the_frenet_frame() {
        let line = (0..40).map(|i| {
            let x = f64::from(i) * 2.0;
            Point::new(x, 8.0 * (x / 18.0).sin())
        });
        let path = ReferencePath::new(line).unwrap();
        for (s, s1, s2, offset) in [
            (11.0, 8.0, -1.0, [0.7, 0.1, -0.02]),
            (30.0, 3.0, 2.0, [-1.5, -0.3, 0.05]),
            (52.5, 0.0, 0.5, [0.2, 0.0, 0.01]),
        ] {
            let at = Station::new([s, s1, s2], &path.frame_at(s), (0.0, 0.0));
            let found = state(&at, offset).unwrap().whole();
            let [d, d1, d2] = offset;
            let motion = FrenetMotion {
                s: [s, s1, s2],
                d: [d, d1 * s1, d2 * s1 * s1 + d1 * s2],
            };
            let plane = path.motion_to_plane(&motion).unwrap();
            let profile = LateralProfile {
                d,
                d_s: d1,
                d_ss: d2,
            };
            let (heading, curvature) = path.heading_and_curvature(s, &profile).unwrap();
            assert!((found.rear.position - plane.position).norm() < 1e-9);
            assert!((found.rear.heading - heading).abs() < 1e-9);
            assert!((found.curvature - curvature).abs() < 1e-9);
            let forward = found.rear.forward();
            assert!((plane.velocity - forward * found.velocity).norm() < 1e-9);
            assert!((plane.acceleration.dot(&forward) - found.acceleration).abs() < 1e-9);
        }
    }
}
