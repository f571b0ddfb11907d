//! The state of the planned vehicle, at its rear axle, along and across the path; its limits, and how fast a path can be driven.
//!
//! Source of the conversion from path coordinates: Werling et al. 2010, appendix I. Angles are kept as sine and cosine, since a plan computes about ten
//! thousand states and shows one in a hundred.
//!
//! Source of the limits: Althoff and Würsching, CommonRoad: Vehicle Models (2020); values from the package
//! `commonroad-vehicle-models` 3.0.2. The model's reference point is the middle of the rear axle.

use nearmiss_base::geometry::{PathFrame, Point, Pose, ReferencePath, normalize_angle};
use nearmiss_scene::scenario::{Motion, VehicleType};

use super::ReferenceTrack;
use super::profile::Start;
use super::settings::start;

/// A vehicle that rolls without slip: its rear axle moves along the heading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VehicleState {
    /// The middle of the rear axle; metres, radians.
    pub rear: Pose,
    /// m/s along the heading.
    pub velocity: f64,
    /// m/s² along the heading.
    pub acceleration: f64,
    /// Curvature of the rear axle's way, 1/m: the tangent of the steering angle by the wheelbase.
    pub curvature: f64,
}

impl VehicleState {
    /// The state of a vehicle whose body's centre moves like this and turns with `curvature` (1/m).
    #[must_use]
    pub fn of_centre(centre: &Motion, curvature: f64, limits: &Limits) -> Self {
        let back = centre.pose.forward() * limits.rear_to_centre;
        Self {
            rear: Pose {
                position: centre.pose.position - back,
                heading: centre.pose.heading,
            },
            velocity: centre.velocity,
            acceleration: centre.acceleration,
            curvature,
        }
    }

    /// The motion of the body's centre; its velocity is the part along the heading, which is the rear axle's.
    #[must_use]
    pub fn centre(&self, limits: &Limits) -> Motion {
        Motion {
            pose: Pose {
                position: self.rear.position + self.rear.forward() * limits.rear_to_centre,
                heading: normalize_angle(self.rear.heading),
            },
            velocity: self.velocity,
            acceleration: self.acceleration,
        }
    }
}

/// The start may lie this far from where the route has it, metres.
const FIRST: f64 = 20.0;

/// From one cycle to the next the place on the path moves less than this, metres.
const HINT: f64 = 15.0;

/// An obstacle that points farther away from the path than this cosine is not along it.
const ALONG: f64 = 0.1;

/// Arc length with its speed and acceleration, and the offset, of `now`; near arc length `hint` (m) where that is
/// known. Nothing for an obstacle that points across the path or away from it.
pub(super) fn place(
    guide: &ReferenceTrack,
    now: &VehicleState,
    hint: Option<f64>,
) -> Option<([f64; 3], Start)> {
    let path = &guide.path;
    let rear = &now.rear;
    let near = |s: f64, within: f64| path.project_near(&rear.position, s, within).ok();
    let at = hint
        .and_then(|s| near(s, HINT))
        .or_else(|| near(guide.start, FIRST))
        .or_else(|| path.project(&rear.position).ok())?;
    let profile = path.profile_at(at, rear.heading, now.curvature).ok()?;
    let point = path.at(at.s);
    let stretch = point.stretch(at).ok()?;
    let (sin, cos) = (rear.heading - point.heading).sin_cos();
    if cos <= ALONG {
        return None;
    }
    let tan = sin / cos;
    let s1 = now.velocity * cos / stretch;
    let drift = point.curvature_rate * at.d + point.curvature * profile.d_s;
    let turn = now.curvature * stretch / cos - point.curvature;
    let s2 = (now.acceleration * cos - s1 * s1 * (stretch * tan * turn - drift)) / stretch;
    let along = [at.s, s1, s2];
    Some((along, start([profile.d, profile.d_s, profile.d_ss], along)))
}

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

    pub fn state(&self) -> VehicleState {
        VehicleState {
            rear: Pose::new(self.x, self.y, self.sin.atan2(self.cos)),
            velocity: self.velocity,
            acceleration: self.acceleration,
            curvature: self.curvature,
        }
    }
}

/// The limits of one vehicle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Length of the body, metres.
    pub length: f64,
    /// Width of the body, metres.
    pub width: f64,
    /// Between the axles, metres.
    pub wheelbase: f64,
    /// From the rear axle forward to the centre of the body, metres.
    pub rear_to_centre: f64,
    /// Acceleration in any direction, m/s²: the radius of the friction circle.
    pub acceleration: f64,
    /// Above this speed (m/s) the engine's power limits the acceleration to `acceleration · switch_speed / v`.
    pub switch_speed: f64,
    /// Largest speed, m/s.
    pub speed: f64,
    /// Largest steering angle to either side, radians.
    pub steering: f64,
    /// Largest change of the steering angle, rad/s.
    pub steering_rate: f64,
}

/// Kinds of limits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Limit {
    /// The speed, or driving backwards.
    Speed,
    /// Acceleration or braking along the heading.
    Acceleration,
    /// The steering angle, as the curvature it gives.
    Curvature,
    /// The rate of the steering angle, as the change of curvature.
    CurvatureRate,
    /// The yaw rate: more than speed and largest steering angle give.
    YawRate,
    /// Acceleration along and across together.
    Friction,
}

impl Limit {
    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Speed => "speed",
            Self::Acceleration => "acceleration",
            Self::Curvature => "curvature",
            Self::CurvatureRate => "curvature rate",
            Self::YawRate => "yaw rate",
            Self::Friction => "friction circle",
        }
    }
}

impl std::fmt::Display for Limit {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

impl Limits {
    /// The limits of a benchmark vehicle.
    #[must_use]
    pub fn for_vehicle(vehicle: VehicleType) -> Self {
        let (steering, steering_rate, switch_speed, speed) = match vehicle {
            VehicleType::FordEscort => (0.910, 0.4, 4.755, 45.8),
            VehicleType::Bmw320i => (1.066, 0.4, 7.319, 50.8),
            VehicleType::VwVanagon => (1.023, 0.4, 7.824, 41.7),
            VehicleType::Truck => (0.550, 0.7103, 7.824, 22.22),
        };
        Self {
            length: vehicle.length(),
            width: vehicle.width(),
            wheelbase: vehicle.wheelbase(),
            rear_to_centre: vehicle.to_rear_axle(),
            acceleration: 11.5,
            switch_speed,
            speed,
            steering,
            steering_rate,
        }
    }

    /// The same vehicle with `share` (0 to 1) of its forces and of its steering: what is planned within them is still
    /// within the whole ones after rounding and between two steps.
    #[must_use]
    pub fn scaled(self, share: f64) -> Self {
        Self {
            acceleration: self.acceleration * share,
            steering: self.steering * share,
            steering_rate: self.steering_rate * share,
            ..self
        }
    }

    /// The tightest curvature that can be steered, 1/m.
    #[must_use]
    pub fn curvature(&self) -> f64 {
        self.steering.tan() / self.wheelbase
    }

    /// The largest acceleration forward at speed `v` (m/s), m/s².
    #[must_use]
    pub fn forward(&self, v: f64) -> f64 {
        self.acceleration * (self.switch_speed / v.max(self.switch_speed))
    }

    /// The steering angle that gives a curvature (1/m) of the rear axle's way, radians.
    #[must_use]
    pub fn steering_of(&self, curvature: f64) -> f64 {
        (curvature * self.wheelbase).atan()
    }
}

/// The speed at each metre of a path.
#[derive(Debug, Clone, PartialEq)]
pub struct CurvatureSpeedLimit {
    /// m/s at 0, 1, 2, … m.
    speeds: Vec<f64>,
}

/// The lateral acceleration that is driven in a bend, m/s².
const LATERAL: f64 = 6.0;

/// Deceleration towards a bend, m/s².
const BRAKING: f64 = 4.0;

/// The ego drives no faster than this for the bends' sake, m/s.
const FASTEST: f64 = 100.0;

impl CurvatureSpeedLimit {
    /// Those of `path`.
    #[must_use]
    pub fn new(path: &ReferencePath) -> Self {
        let metres = path.length().ceil().max(1.0) as usize;
        let curvature = |s: usize| path.at(s as f64).curvature.abs();
        let mut speeds: Vec<f64> = (0..=metres)
            .map(|s| (LATERAL / curvature(s).max(1e-9)).sqrt().min(FASTEST))
            .collect();
        for s in (0..metres).rev() {
            let reached = (speeds[s + 1].powi(2) + 2.0 * BRAKING).sqrt();
            speeds[s] = speeds[s].min(reached);
        }
        Self { speeds }
    }

    /// The speed at arc length `s` (m), m/s; beyond the ends that of the end.
    #[must_use]
    #[inline]
    pub fn speed(&self, s: f64) -> f64 {
        let place = s.max(0.0) as usize;
        self.speeds[place.min(self.speeds.len() - 1)]
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use nearmiss_base::geometry::{FrenetMotion, LateralProfile};

    use super::*;

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
            let found = state(&at, offset).unwrap().state();
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

    #[test]
    fn bends_slow_down_before_they_begin() {
        // Straight for 60 m, then a quarter of a circle of 10 m.
        let straight = (0..60).map(|x| Point::new(f64::from(x), 0.0));
        let turn = (0..=20).map(|i| {
            let (sin, cos) = (f64::from(i) * std::f64::consts::FRAC_PI_2 / 20.0).sin_cos();
            Point::new(60.0 + 10.0 * sin, 10.0 - 10.0 * cos)
        });
        let path = ReferencePath::new(straight.chain(turn)).unwrap();
        let bends = CurvatureSpeedLimit::new(&path);
        let in_it = bends.speed(68.0);
        assert!((in_it - (LATERAL * 10.0_f64).sqrt()).abs() < 0.3, "{in_it}");
        let before = bends.speed(30.0);
        let room = (before.powi(2) - in_it.powi(2)) / (2.0 * BRAKING);
        assert!((28.0..=33.0).contains(&room), "{room}");
        assert!(bends.speed(0.0) > before);
        assert_eq!(bends.speed(-5.0), bends.speed(0.0));
    }
}
