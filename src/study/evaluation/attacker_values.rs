//! The template variables of an attacker: every limit that the gate holds its motion against.

use serde::Serialize;

use super::question::Case;
use super::values::plain;
use nearmiss_drive::generation::{Capability, SAME_PLACE, SAME_SPEED};

/// Limits that templates of all tasks know, m/s² and 1/m.
#[derive(Debug, Serialize)]
pub(super) struct LimitValues {
    pub acceleration: f64,
    pub deceleration: f64,
    pub lateral: f64,
    pub curvature: f64,
}

/// What one road user can do in its style, as the gate of changed motions asks it.
#[derive(Debug, Serialize)]
pub(super) struct AttackerValues {
    /// Its type, such as `car`.
    kind: &'static str,
    /// The style: `human` or `limit`.
    style: &'static str,
    /// Speeding up, m/s².
    acceleration: f64,
    /// Above this speed (m/s) the engine allows less: `power` over the speed, m/s².
    switch_speed: f64,
    /// m²/s³.
    power: f64,
    /// Braking, m/s².
    braking: f64,
    /// Across the heading, m/s².
    lateral: f64,
    /// Acceleration along and across together, m/s².
    friction: f64,
    /// Change of the acceleration along the heading, m/s³.
    jerk: f64,
    /// Speed, m/s.
    speed: f64,
    /// Smallest radius of the rear axle's way, m, and the curvature that is, 1/m.
    radius: f64,
    curvature: f64,
    /// Largest steering angle, rad.
    steering: f64,
    /// Change of the steering angle, rad/s.
    steering_rate: f64,
    /// Between the axles, m.
    wheelbase: f64,
    /// From the rear axle to the centre of the body, m.
    rear_to_centre: f64,
    /// Whether it has to stay on the road.
    on_road: bool,
    /// Less than this differs from the recorded motion nowhere: m and m/s.
    least_distance: f64,
    least_speed: f64,
}

impl AttackerValues {
    /// Those of the obstacle that a case describes.
    pub fn of(case: &Case) -> Option<Self> {
        let obstacle = case.scene.scenario.obstacle(case.options.obstacle?)?;
        let able = Capability::for_obstacle(obstacle, case.attack.style)?;
        let limits = &able.limits;
        let friction = limits.acceleration;
        let curvature = limits.curvature();
        Some(Self {
            kind: obstacle.kind.name(),
            style: case.attack.style.name(),
            acceleration: short(able.speeding_up.min(friction)),
            switch_speed: short(limits.switch_speed),
            power: short(friction * limits.switch_speed),
            braking: short(friction),
            lateral: short(able.lateral.min(friction)),
            friction: short(friction),
            jerk: short(able.jerk),
            speed: short(limits.speed),
            radius: up(1.0 / curvature),
            curvature: short(curvature),
            steering: short(limits.steering),
            steering_rate: plain(limits.steering_rate),
            wheelbase: plain(limits.wheelbase),
            rear_to_centre: plain(limits.rear_to_centre),
            on_road: able.on_road,
            least_distance: SAME_PLACE,
            least_speed: SAME_SPEED,
        })
    }

    /// The limits that templates of all tasks know.
    pub fn limits(&self) -> LimitValues {
        LimitValues {
            acceleration: self.acceleration,
            deceleration: self.braking,
            lateral: self.lateral,
            curvature: self.curvature,
        }
    }
}

/// A limit with three decimals, rounded to the safe side: what keeps to the number keeps to the limit.
fn short(limit: f64) -> f64 {
    (limit * 1e3 + 1e-6).floor() / 1e3
}

fn up(limit: f64) -> f64 {
    (limit * 1e3 - 1e-6).ceil() / 1e3
}
