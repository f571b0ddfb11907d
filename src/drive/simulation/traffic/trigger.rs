//! When an obstacle begins to react: where its recorded motion leads into a body, and comfortable braking is only just
//! enough.

use super::course::Course;
use super::idm::Idm;
use super::neighbour::{Expected, Neighbour};
use crate::simulation::ContactSide;
use crate::simulation::collision::sides;
use nearmiss_base::geometry::{Footprint, Placed, angle_between};
use nearmiss_scene::scenario::Obstacle;

/// An obstacle that follows its recording.
#[derive(Debug, Clone, Copy)]
pub struct Follower<'a> {
    /// Who.
    pub obstacle: &'a Obstacle,
    /// Its way.
    pub course: &'a Course,
    /// Now.
    pub step: i64,
    /// Seconds between two steps.
    pub dt: f64,
    /// How it would react.
    pub idm: Idm,
}

/// So far ahead people look, seconds.
pub const HORIZON: f64 = 5.0;

/// Moments that are looked at are so far apart, seconds.
pub const TICK: f64 = 0.2;

/// Milder braking of another body is not taken for the beginning of a stop, m/s².
const BRAKE_LIGHTS: f64 = 0.5;

/// Bodies that point less apart than this drive the same way, radians.
pub const SAME_WAY: f64 = std::f64::consts::FRAC_PI_4;

impl Follower<'_> {
    /// Whether it has to begin to react to `other` now.
    ///
    /// Its recorded motion has to touch the other body, expected along its way as fast as now or braking on as it does
    /// now, with the front, within 5 s; and comfortable braking from the next step on must not be enough any more to
    /// stay half of the standstill gap away. So an obstacle that was recorded to brake in time, or that is run into by
    /// another one, does not react.
    #[must_use]
    pub fn is_concerned(&self, other: &Neighbour<'_>) -> bool {
        let Some(now) = self.obstacle.motion_at(self.step) else {
            return false;
        };
        let Some(footprint) = self.obstacle.footprint_at(self.step) else {
            return false;
        };
        let apart = (now.pose.position - other.body.pose.position).norm();
        let reach = footprint.reach() + other.body.footprint.reach();
        let fastest = now.velocity.abs() + FASTER;
        if apart > reach + HORIZON * (fastest + other.speed.abs()) {
            return false;
        }
        let ways = if other.acceleration < -BRAKE_LIGHTS {
            &[Expected::Steady, Expected::Braking][..]
        } else {
            &[Expected::Steady][..]
        };
        ways.iter().any(|expected| {
            self.runs_into(footprint, other, *expected)
                && self.brakes_too_late(footprint, now.velocity.abs(), other, *expected)
        })
    }

    fn ticks(&self) -> impl Iterator<Item = i64> + use<> {
        let stride = ((TICK / self.dt).round() as i64).max(1);
        let last = (HORIZON / self.dt).round() as i64;
        (1..)
            .map(move |n| n * stride)
            .take_while(move |k| *k <= last.max(stride))
    }

    /// Whether its recorded motion touches `other`, and it is the one that runs into the other.
    fn runs_into(&self, footprint: &Footprint, other: &Neighbour<'_>, expected: Expected) -> bool {
        for k in self.ticks() {
            let Some(motion) = self.obstacle.motion_at(self.step + k) else {
                return false;
            };
            let (own, there) = (
                footprint.at(motion.pose),
                other.after(k as f64 * self.dt, expected),
            );
            if touch(&own, &there) {
                return is_the_cause(&own, &there);
            }
        }
        false
    }

    /// Whether comfortable braking after one more step does not keep it away from `other`.
    fn brakes_too_late(
        &self,
        footprint: &Footprint,
        v: f64,
        other: &Neighbour<'_>,
        expected: Expected,
    ) -> bool {
        let Some(s) = self.course.at_step(self.step) else {
            return false;
        };
        let next = self.course.at_step(self.step + 1);
        let s = next.unwrap_or(s + v * self.dt);
        let stopping = v / self.idm.deceleration;
        self.ticks().any(|k| {
            let after = k as f64 * self.dt;
            let time = (after - self.dt).clamp(0.0, stopping);
            let driven = time * (v - self.idm.deceleration * time / 2.0);
            let pose = self
                .course
                .pose_at(s + driven + self.idm.standstill_gap / 2.0);
            touch(&footprint.at(pose), &other.after(after, expected))
        })
    }
}

/// A recorded obstacle may become faster than it is now by this, m/s.
const FASTER: f64 = 10.0;

/// Whether two bodies touch.
pub fn touch(a: &Placed<'_>, b: &Placed<'_>) -> bool {
    let reach = a.footprint.reach() + b.footprint.reach();
    (a.pose.position - b.pose.position).norm() <= reach && a.distance(b) <= 0.0
}

/// Whether `own` runs into `other`, not the other way round: it touches with its front, or drives the same way from
/// behind or beside.
fn is_the_cause(own: &Placed<'_>, other: &Placed<'_>) -> bool {
    let ahead = own.pose.to_local(&other.pose.position).x > 0.0;
    let same = angle_between(own.pose.heading, other.pose.heading).abs() < SAME_WAY;
    match sides(own, other).0 {
        ContactSide::Front => ahead,
        ContactSide::Left | ContactSide::Right => ahead && same,
        ContactSide::Rear => false,
    }
}
