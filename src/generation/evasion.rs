//! An evasive manoeuvre: brake or accelerate, and steer to a lateral offset, up to the limits of tyres and steering.

use crate::geometry::{Pose, normalize_angle};
use crate::planner::{Limits, ReferenceTrack, VehicleState};

/// An evasive manoeuvre that a driver may begin and hold.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Evasion {
    /// Acceleration along the heading, m/s²; below 0 for braking. Steering comes first: what it leaves of the friction
    /// is the most.
    pub acceleration: f64,
    /// The speed (m/s) from which on it is neither braked nor accelerated any more.
    pub until: f64,
    /// The offset from the path that is steered to, metres to the left.
    pub offset: f64,
    /// The share of the friction that steering may take, 0 to 1.
    pub grip: f64,
}

/// Parts of a step in which the motion is integrated.
const PARTS: usize = 16;

/// The share of the limits that is used: the exact check comes after.
const SHARE: f64 = 0.995;

/// Seconds in which the heading is brought to what is wanted, and metres added to the way of that time.
const TURNING: f64 = 0.25;
const AT_LEAST: f64 = 1.0;

/// The offset is made good in this many times the way of turning.
const SLOWER: f64 = 2.5;

/// The path is looked for this far from where it was left, metres.
const NEAR: f64 = 15.0;

impl Evasion {
    /// The state a step of `dt` seconds later; inputs are constant in it. `hint` is the arc length (m) along the path.
    ///
    /// Nothing where the path has ended.
    pub(super) fn step(
        &self,
        at: &VehicleState,
        guide: &ReferenceTrack,
        hint: &mut Option<f64>,
        limits: &Limits,
        dt: f64,
    ) -> Option<VehicleState> {
        let v = at.velocity.max(0.0);
        let most = self.grip * SHARE * limits.acceleration / (v * v).max(1.0);
        let most = most.min(SHARE * limits.curvature());
        // Who stands does not steer.
        let wanted = match v > 0.0 {
            true => self.curvature(at, guide, hint, most)?,
            false => at.curvature,
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

    /// Acceleration along the heading while the curvature goes from the present one to `end`, m/s².
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
        let room = (SHARE * limits.acceleration).powi(2) - across * across;
        let room = room.max(0.0).sqrt();
        let forward = (SHARE * limits.forward(faster)).min((limits.speed - v).max(0.0) / dt);
        wanted.clamp(-room.min(v / dt), room.min(forward))
    }

    /// The curvature that leads to the offset, 1/m, where `most` can be steered.
    ///
    /// The heading that is aimed at is the one from which half of `most` straightens up before the offset is passed.
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
