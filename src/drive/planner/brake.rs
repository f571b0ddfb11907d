//! The emergency stop: full braking along the path, within what steering and friction allow.

use super::{Limits, ReferenceTrack, VehicleState};
use nearmiss_base::geometry::{Pose, normalize_angle};

/// Parts of a step in which the motion is integrated.
const PARTS: usize = 8;

/// How the wheels are turned back to the path: by the offset (1/m²) and by the heading (1/m).
const BY_OFFSET: f64 = 0.06;
const BY_HEADING: f64 = 0.4;

/// The share of the friction circle that braking may take where no steering is needed.
const SHARE: f64 = 0.98;

/// The states of an emergency stop from `now`, one a step of `dt` seconds, with `share` (0 to 1)
/// of what friction leaves for braking; inputs are constant within a step.
pub(super) fn brake(
    now: &VehicleState,
    guide: &ReferenceTrack,
    hint: Option<f64>,
    limits: &Limits,
    share: f64,
    dt: f64,
    steps: usize,
) -> Vec<VehicleState> {
    let mut states = vec![*now];
    let mut at = *now;
    let mut hint = hint;
    for _ in 0..steps {
        let wanted = wanted_curvature(&at, guide, &mut hint);
        at = step(&at, wanted, limits, share, dt);
        states.push(at);
    }
    states
}

/// The curvature that leads back to the path, 1/m; the present curvature beyond its end.
fn wanted_curvature(at: &VehicleState, guide: &ReferenceTrack, hint: &mut Option<f64>) -> f64 {
    let path = &guide.path;
    let near = hint.and_then(|s| path.project_near(&at.rear.position, s, 10.0).ok());
    let Some(on) = near else {
        return at.curvature;
    };
    *hint = Some(on.s);
    let point = path.at(on.s);
    let turn = normalize_angle(at.rear.heading - point.heading);
    point.curvature - BY_OFFSET * on.d - BY_HEADING * turn
}

fn step(at: &VehicleState, wanted: f64, limits: &Limits, share: f64, dt: f64) -> VehicleState {
    let v = at.velocity.max(0.0);
    // The curvature that friction allows at this speed, with a share left for braking.
    let most = (0.8 * limits.acceleration / (v * v).max(1.0)).min(limits.curvature());
    let (angle, wanted) = (
        limits.steering_of(at.curvature),
        limits.steering_of(wanted.clamp(-most, most)),
    );
    let rate = ((wanted - angle) / dt).clamp(-limits.steering_rate, limits.steering_rate);
    let end = (angle + rate * dt).tan() / limits.wheelbase;
    let across = v * v * at.curvature.abs().max(end.abs());
    let room = (SHARE * limits.acceleration).powi(2) - across * across;
    let braking = (room.max(0.0).sqrt() * share).min(v / dt);
    let part = dt / PARTS as f64;
    let (mut x, mut y, mut heading) = (at.rear.position.x, at.rear.position.y, at.rear.heading);
    for i in 0..PARTS {
        let t = (i as f64 + 0.5) * part;
        let speed = v - braking * t;
        let curvature = (angle + rate * t).tan() / limits.wheelbase;
        let middle = heading + speed * curvature * part / 2.0;
        x += speed * part * middle.cos();
        y += speed * part * middle.sin();
        heading += speed * curvature * part;
    }
    let velocity = (v - braking * dt).max(0.0);
    VehicleState {
        rear: Pose::new(x, y, normalize_angle(heading)),
        velocity,
        acceleration: if velocity > 0.0 { -braking } else { 0.0 },
        curvature: end,
    }
}
