//! The joint: where a changed motion departs from the recording, with the steering angle and acceleration there.

use std::ops::RangeInclusive;

use super::run::{Findings, Flow, Run, SHARE};
use crate::generation::{Capability, Reason, Refusal};
use crate::planner::{Bound, Limits};
use nearmiss_base::geometry::{Vector, angle_between};
use nearmiss_scene::scenario::{Motion, Track};

/// Steering angles and accelerations of a recorded state, implied by its surroundings.
///
/// Recordings determine them badly: headings and speeds scatter, and many move the centre along the heading, where a
/// vehicle's rear axle would. So each is a range of all values that the recording implies around the state, before and
/// after. A change must reach its first step from some value in the range within its limits; limits that the recording
/// itself breaks there do not count against it.
#[derive(Debug, Clone, PartialEq)]
pub struct Joint {
    /// Steering angles, radians; `None` if the body hardly moves, and the wheels may stand anyhow.
    pub steering: Option<RangeInclusive<f64>>,
    /// Accelerations along the heading, m/s²: the said one, and those of the steps before and after.
    pub acceleration: RangeInclusive<f64>,
}

/// Steering angles are looked for this long before and after the state, seconds.
const AROUND: f64 = 0.3;

/// A shorter step says nothing about the steering angle, metres.
const STANDING: f64 = 0.01;

impl Joint {
    /// The joint at a recorded step of a track with `dt` seconds between two steps; `None` if none is recorded.
    #[must_use]
    pub fn at(track: &Track, step: i64, can: &Capability, dt: f64) -> Option<Self> {
        let here = track.at(step)?;
        let next = |from: i64| {
            let to = from.checked_add(1)?;
            Some((track.at(from)?, track.at(to)?))
        };
        let around = (AROUND / dt).ceil().clamp(1.0, 100.0) as i64;
        let ways = step.saturating_sub(around)..step.saturating_add(around);
        let angles = ways
            .filter_map(next)
            .filter_map(|(a, b)| steering(a, b, &can.limits));
        let steering = angles.fold(None, |range, (angle, _)| Some(widened(range, angle)));
        let beside = [step.saturating_sub(1), step].into_iter().filter_map(next);
        let accelerations = beside.map(|(a, b)| (b.velocity - a.velocity) / dt);
        let said = here.acceleration..=here.acceleration;
        Some(Self {
            steering,
            acceleration: accelerations.fold(said, |range, a| widened(Some(range), a)),
        })
    }
}

/// The mean steering angle from one motion to the next (rad), and the length of the rear axle's way (m).
fn steering(from: &Motion, to: &Motion, limits: &Limits) -> Option<(f64, f64)> {
    let rear = |m: &Motion| -> Vector {
        m.pose.position.coords - m.pose.forward() * limits.rear_to_centre
    };
    let chord = (rear(to) - rear(from)).norm();
    if chord < STANDING {
        return None;
    }
    let turned = angle_between(from.pose.heading, to.pose.heading);
    let half = turned / 2.0;
    let length = if half.abs() > 1e-6 {
        chord * half / half.sin()
    } else {
        chord
    };
    Some((limits.steering_of(turned / length), length))
}

fn widened(range: Option<RangeInclusive<f64>>, value: f64) -> RangeInclusive<f64> {
    match range {
        Some(range) => range.start().min(value)..=range.end().max(value),
        None => value..=value,
    }
}

/// How far a value is from a range.
pub(super) fn beyond(range: &RangeInclusive<f64>, value: f64) -> f64 {
    (range.start() - value).max(value - range.end()).max(0.0)
}

impl Run<'_> {
    pub fn joint(&self) -> Option<Joint> {
        let track = self.obstacle.track();
        Joint::at(track, self.motions[0].0, &self.can, self.dt())
    }

    /// The wheels can be turned from where they stood to where the first changed step needs them.
    pub fn joint_steering(&self, found: &mut Findings) -> Flow {
        let joint = self.joint().and_then(|joint| joint.steering);
        let (Some(range), Some(way)) = (joint, self.ways().next()) else {
            return Flow::Continue(());
        };
        let limits = &self.can.limits;
        let Some((angle, length)) = steering(way.from, way.to, limits) else {
            return Flow::Continue(());
        };
        let dt = self.dt();
        // The mean of a tangent is not the tangent of the mean; and headings and places are rounded.
        let slack = 2.0 * self.gate.rounding * (limits.wheelbase + 1.0) / length / dt;
        let most = limits.steering_rate * (1.0 + SHARE + ESTIMATE) + slack;
        let rate = beyond(&range, angle) / dt;
        if way.place == 0 && !self.is_exempt(0) && rate > most {
            let reason = Reason::Kinematics(Bound::SteeringRate);
            found.say(false, Refusal::at(way.step, reason).with(rate, most))?;
        }
        Flow::Continue(())
    }
}

/// The share of the steering rate that estimated angles may exceed it by, as in the single-track check.
const ESTIMATE: f64 = 0.02;
