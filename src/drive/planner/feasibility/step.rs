//! One step of the kinematic single-track model, integrated.
//!
//! Source: Althoff and Würsching, CommonRoad: Vehicle Models (2020), section III. The inputs are constant over the
//! step.

use nearmiss_base::geometry::{Pose, Vector};

/// A place of the rear axle with its speed.
#[derive(Debug, Clone, Copy)]
pub(super) struct Moment {
    pub step: i64,
    pub rear: Pose,
    /// m/s along the heading.
    pub velocity: f64,
}

/// Steering over a step: the integrated angle and rate, and the ones needed.
#[derive(Debug, Clone, Copy)]
pub(super) struct Turn {
    /// Steering angle at the beginning (rad) and its rate (rad/s), as they are integrated.
    pub angle: f64,
    pub rate: f64,
    /// Values compared with the limits, rad and rad/s.
    pub needed_angle: f64,
    pub needed_rate: f64,
    /// How much of that may be rounding, rad and rad/s.
    pub angle_slack: f64,
    pub rate_slack: f64,
    /// The mean acceleration across (m/s²) where the steering angle on the way is not known, only its mean.
    pub across: Option<f64>,
}

/// State reached by the inputs.
#[derive(Debug, Clone, Copy)]
pub(super) struct Reached {
    pub rear: Pose,
    /// The largest acceleration along and across together on the way, m/s².
    pub friction: f64,
}

/// Runge–Kutta steps within a step.
const PARTS: usize = 8;

/// Beyond this steering angle (rad) the model turns on the spot; no vehicle's limit comes near.
const SIDEWAYS: f64 = 1.5;

/// Place and heading.
type State = (Vector, f64);

/// Drives for `dt` seconds with constant `acceleration` (m/s²) and steering rate.
pub(super) fn simulate(
    from: &Moment,
    acceleration: f64,
    turn: &Turn,
    wheelbase: f64,
    dt: f64,
) -> Reached {
    let speed = |t: f64| from.velocity + acceleration * t;
    let yaw_rate = |t: f64| {
        let angle = (turn.angle + turn.rate * t).clamp(-SIDEWAYS, SIDEWAYS);
        speed(t) * angle.tan() / wheelbase
    };
    let slope = |t: f64, (_, heading): State| -> State {
        let (sin, cos) = heading.sin_cos();
        (Vector::new(cos, sin) * speed(t), yaw_rate(t))
    };
    let add = |(p, h): State, (dp, dh): State, by: f64| -> State { (p + dp * by, h + dh * by) };
    let needed = |t: f64| acceleration.hypot(speed(t) * yaw_rate(t));
    let part = dt / PARTS as f64;
    // Relative to where it begins: coordinates of maps are large.
    let mut at: State = (Vector::zeros(), from.rear.heading);
    let mut friction = needed(0.0);
    for i in 0..PARTS {
        let t = i as f64 * part;
        let k1 = slope(t, at);
        let k2 = slope(t + part / 2.0, add(at, k1, part / 2.0));
        let k3 = slope(t + part / 2.0, add(at, k2, part / 2.0));
        let k4 = slope(t + part, add(at, k3, part));
        for (k, weight) in [(k1, 1.0), (k2, 2.0), (k3, 2.0), (k4, 1.0)] {
            at = add(at, k, weight * part / 6.0);
        }
        friction = friction.max(needed(t + part));
    }
    Reached {
        rear: Pose {
            position: from.rear.position + at.0,
            heading: at.1,
        },
        friction,
    }
}
