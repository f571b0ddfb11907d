//! The state of the planned vehicle, at its rear axle.

use super::Limits;
use nearmiss_base::geometry::{Pose, normalize_angle};
use nearmiss_scene::scenario::Motion;

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
