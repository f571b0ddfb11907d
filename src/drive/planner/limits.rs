//! Vehicle limits: those of the kinematic single-track model.
//!
//! Source: Althoff and Würsching, CommonRoad: Vehicle Models (2020); values from the package
//! `commonroad-vehicle-models` 3.0.2. The model's reference point is the middle of the rear axle.

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
