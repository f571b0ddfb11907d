//! Vehicle limits: those of the kinematic single-track model, and how fast a path can be driven.
//!
//! Source: Althoff and Würsching, CommonRoad: Vehicle Models (2020); values from the package
//! `commonroad-vehicle-models` 3.0.2. The model's reference point is the middle of the rear axle.

use nearmiss_base::geometry::ReferencePath;
use nearmiss_scene::scenario::VehicleType;

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

    use super::*;
    use nearmiss_base::geometry::Point;

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
