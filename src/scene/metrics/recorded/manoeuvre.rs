//! Emergency manoeuvres of the ego: where it is some time after it began to brake, accelerate or steer.

use crate::metrics::limits::Limits;
use crate::scenario::Motion;
use nearmiss_base::geometry::{Point, Pose};

/// The ego's manoeuvre to avoid a collision. Only the acceleration given here changes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::metrics) enum Manoeuvre {
    /// Full braking straight ahead, until it stands.
    Brake,
    /// Full acceleration straight ahead.
    KickDown,
    /// Full lateral acceleration to the left.
    Left,
    /// Full lateral acceleration to the right.
    Right,
}

impl Manoeuvre {
    /// The pose after `time` seconds, from `start` on.
    ///
    /// A point mass with constant acceleration along or across its first heading; while it steers, the
    /// body turns into the direction of its motion (Jansson 2005, 5.3).
    pub fn pose(self, start: &Motion, time: f64, limits: &Limits) -> Pose {
        let (v, sign) = (start.velocity.abs(), 1.0_f64.copysign(start.velocity));
        let (along, across, turn) = match self {
            Self::Brake => {
                let time = time.min(v / limits.full_braking);
                (v * time - limits.full_braking * time * time / 2.0, 0.0, 0.0)
            }
            Self::KickDown => (v * time + limits.kick_down * time * time / 2.0, 0.0, 0.0),
            Self::Left | Self::Right => {
                let side = if self == Self::Left { 1.0 } else { -1.0 };
                let most = limits.evasion.min(v * v * limits.tightest);
                let turn = if v > 0.0 {
                    (most * time / v).atan()
                } else {
                    0.0
                };
                (
                    v * time,
                    side * most * time * time / 2.0,
                    side * sign * turn,
                )
            }
        };
        Pose {
            position: start.pose.to_world(&Point::new(sign * along, across)),
            heading: start.pose.heading + turn,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: &Limits = &Limits::SHIPPED;

    #[test]
    fn braking_stops_and_steering_goes_aside() {
        let start = Motion {
            pose: Pose::new(0.0, 0.0, 0.0),
            velocity: 8.0,
            acceleration: 0.0,
        };
        let stood = Manoeuvre::Brake.pose(&start, 9.0, LIMITS);
        assert!((stood.position.x - 64.0 / (2.0 * LIMITS.full_braking)).abs() < 1e-12);
        let aside = Manoeuvre::Right.pose(&start, 0.5, LIMITS);
        assert!((aside.position.y + LIMITS.evasion / 8.0).abs() < 1e-12 && aside.heading < 0.0);
        assert!(
            (Manoeuvre::KickDown.pose(&start, 2.0, LIMITS).position.x
                - 16.0
                - 2.0 * LIMITS.kick_down)
                .abs()
                < 1e-12
        );
    }
}
