//! An evasive manoeuvre: brake or accelerate, and steer to a lateral offset, up to the limits of tyres and steering.

use crate::planner::{Limits, ReferenceTrack, VehicleState};
use nearmiss_base::geometry::{Pose, normalize_angle};

/// An evasive manoeuvre that a driver begins and holds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EvasiveManoeuvre {
    /// Acceleration along the heading, m/s²; negative for braking. Bounded by the friction that steering leaves.
    pub acceleration: f64,
    /// The speed (m/s) at which braking or accelerating ends.
    pub until: f64,
    /// The target offset from the path, metres to the left.
    pub offset: f64,
    /// The share of the friction that steering may take, 0 to 1.
    pub grip: f64,
}

/// Integration substeps per step.
const PARTS: usize = 16;

/// Share of the limits to use, since the exact check comes afterwards.
const SHARE: f64 = 0.995;

/// Time constant of the heading (s), and a distance added to the one covered in it (m).
const TURNING: f64 = 0.25;
const AT_LEAST: f64 = 1.0;

/// The offset is corrected over this multiple of the turning distance.
const SLOWER: f64 = 2.5;

/// Range around the last arc length in which the path is projected on, metres.
const NEAR: f64 = 15.0;

impl EvasiveManoeuvre {
    /// The state one step of `dt` seconds later, with constant inputs; `None` past the end of the path. `hint` is the
    /// arc length (m) along the path.
    pub(super) fn step(
        &self,
        at: &VehicleState,
        guide: &ReferenceTrack,
        hint: &mut Option<f64>,
        limits: &Limits,
        dt: f64,
    ) -> Option<VehicleState> {
        let v = at.velocity.max(0.0);
        let by_grip = self.grip * SHARE * limits.acceleration / (v * v).max(1.0);
        let most = by_grip.min(SHARE * limits.curvature());
        // A standing vehicle does not steer.
        let wanted = if v > 0.0 {
            self.curvature(at, guide, hint, most)?
        } else {
            at.curvature
        };
        let angle = limits.steering_of(at.curvature);
        let fastest = SHARE * limits.steering_rate;
        let turn = (limits.steering_of(wanted.clamp(-most, most)) - angle) / dt;
        let rate = turn.clamp(-fastest, fastest);
        let end = (angle + rate * dt).tan() / limits.wheelbase;
        let acceleration = self.along(at, end, limits, dt);
        let part = dt / PARTS as f64;
        let rear = at.rear;
        let (mut x, mut y, mut heading) = (rear.position.x, rear.position.y, rear.heading);
        for i in 0..PARTS {
            let t = (i as f64 + 0.5) * part;
            let speed = v + acceleration * t;
            let curvature = (angle + rate * t).tan() / limits.wheelbase;
            let middle = heading + speed * curvature * part / 2.0;
            x += speed * part * middle.cos();
            y += speed * part * middle.sin();
            heading += speed * curvature * part;
        }
        let velocity = (v + acceleration * dt).max(0.0);
        Some(VehicleState {
            rear: Pose::new(x, y, normalize_angle(heading)),
            velocity,
            acceleration: if velocity > 0.0 { acceleration } else { 0.0 },
            curvature: end,
        })
    }

    /// Acceleration along the heading while the curvature changes to `end`, m/s².
    fn along(&self, at: &VehicleState, end: f64, limits: &Limits, dt: f64) -> f64 {
        let v = at.velocity.max(0.0);
        let towards = (self.until - v) / dt;
        let wanted = if self.acceleration < 0.0 {
            self.acceleration.max(towards.min(0.0))
        } else {
            self.acceleration.min(towards.max(0.0))
        };
        let faster = v + wanted.max(0.0) * dt;
        let across = faster * faster * at.curvature.abs().max(end.abs());
        let squared = (SHARE * limits.acceleration).powi(2) - across * across;
        let room = squared.max(0.0).sqrt();
        let forward = (SHARE * limits.forward(faster)).min((limits.speed - v).max(0.0) / dt);
        wanted.clamp(-room.min(v / dt), room.min(forward))
    }

    /// The curvature (1/m) that leads to the offset, at most `most`.
    ///
    /// From the target heading, half of `most` suffices to straighten up before the offset is passed.
    fn curvature(
        &self,
        at: &VehicleState,
        guide: &ReferenceTrack,
        hint: &mut Option<f64>,
        most: f64,
    ) -> Option<f64> {
        let path = &guide.path;
        let near = match *hint {
            Some(s) => path.project_near(&at.rear.position, s, NEAR),
            None => path.project(&at.rear.position),
        };
        let on = near.ok()?;
        *hint = Some(on.s);
        let point = path.at(on.s);
        let way = at.velocity * TURNING + AT_LEAST;
        let off = self.offset - on.d;
        let aim = (off.abs() / (SLOWER * way)).min((most * off.abs()).sqrt());
        let turn = aim.copysign(off) - normalize_angle(at.rear.heading - point.heading);
        let stretch = (1.0 - point.curvature * on.d).max(0.1);
        Some(point.curvature / stretch + turn / way)
    }
}
