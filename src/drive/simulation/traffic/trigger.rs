//! When an obstacle begins to react, which ones do at a step, and the way that they have before them.

use nearmiss_base::geometry::{Footprint, Placed, angle_between};
use nearmiss_scene::scenario::prediction::{Model, ObservedHistory, Path, Predictor};
use nearmiss_scene::scenario::{Motion, Obstacle, ObstacleRole};

use super::course::Course;
use super::leader::{Expected, Neighbour};
use super::reacting::{Idm, Reacting};
use super::world::Reactive;
use crate::simulation::ContactSide;
use crate::simulation::collision::sides;

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
        let fastest = now.velocity.abs() + MAX_SPEED_GAIN;
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
const MAX_SPEED_GAIN: f64 = 10.0;

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

/// A body that is no farther than this from where it was recorded, metres, and no faster or slower by more than this,
/// m/s, moves as it was recorded.
const AS_RECORDED: f64 = 0.5;

/// The lane beyond the recording is followed so far, metres; beside all lanes one goes straight on.
const EXTENSION: f64 = 300.0;
const STRAIGHT_ON: f64 = 100.0;

/// Seconds of a recording whose last part says which lane is followed.
const MEMORY: f64 = 1.0;

impl Reactive<'_> {
    /// The obstacles that begin to react at a step, by place: those that the ego concerns, or one that reacts already.
    pub fn begin_at(&self, step: i64, ego: &Neighbour<'_>) -> Vec<(usize, Reacting)> {
        let reacting = self.reacting.keys();
        let reacting: Vec<Neighbour<'_>> = reacting
            .filter_map(|place| self.neighbour(*place, step))
            .collect();
        let places = (0..self.scenario.obstacles.len()).filter(|p| !self.reacting.contains_key(p));
        let begins = places.filter(|place| {
            let others = std::iter::once(ego).chain(&reacting);
            self.follower(*place, step).is_some_and(|follower| {
                { others }.any(|other| {
                    follower.is_concerned(other) && !self.is_as_recorded(&follower, other)
                })
            })
        });
        begins
            .filter_map(|place| Some((place, self.begin(place, step)?)))
            .collect()
    }

    /// An obstacle that follows its recording on from a step.
    fn follower(&self, place: usize, step: i64) -> Option<Follower<'_>> {
        let obstacle = self.body(place)?;
        let moves = obstacle.role == ObstacleRole::Dynamic;
        obstacle.track().at(step + 1).filter(|_| moves)?;
        Some(Follower {
            obstacle,
            course: self.course(place)?,
            step,
            dt: self.driver.dt(),
            idm: Idm::for_kind(obstacle.kind),
        })
    }

    /// Whether another body moves as it was recorded, and the recording goes well: then what is expected of it is wrong,
    /// and the recording is right.
    fn is_as_recorded(&self, follower: &Follower<'_>, other: &Neighbour<'_>) -> bool {
        let steps = (HORIZON / follower.dt).round() as i64;
        let recorded = |step| self.recorded(other, step);
        let Some((motion, _)) = recorded(follower.step) else {
            return false;
        };
        let apart = (motion.pose.position - other.body.pose.position).norm();
        if apart > AS_RECORDED || (motion.velocity - other.speed).abs() > AS_RECORDED {
            return false;
        }
        (follower.step..=follower.step + steps).all(|step| {
            let own = follower.obstacle.placed_at(step);
            let (Some(own), Some((_, there))) = (own, recorded(step)) else {
                return true;
            };
            !touch(&own, &there)
        })
    }

    /// The recorded motion and body of the ego or an obstacle.
    fn recorded(&self, who: &Neighbour<'_>, step: i64) -> Option<(Motion, Placed<'_>)> {
        match who.place {
            Some(place) => {
                let obstacle: &Obstacle = &self.scenario.obstacles[place];
                Some((*obstacle.motion_at(step)?, obstacle.placed_at(step)?))
            }
            None => {
                let scene = self.driver.recorded()?;
                Some((*scene.ego.track.at(step)?, scene.ego_at(step)?))
            }
        }
    }

    fn begin(&self, place: usize, step: i64) -> Option<Reacting> {
        let course = self.onward(place, self.course(place)?.clone());
        let obstacle = &self.scenario.obstacles[place];
        Reacting::new(obstacle, course, step, self.driver.dt())
    }

    /// A recorded way with what comes after it: the lane that it leads to, or straight on beside all lanes.
    fn onward(&self, place: usize, course: Course) -> Course {
        let obstacle = &self.scenario.obstacles[place];
        let last = obstacle.track().steps().end - 1;
        let memory = (MEMORY / self.driver.dt()).round() as i64;
        let past = ObservedHistory::of_traffic(self.scenario, last - memory..=last, None);
        let seen = past.others().iter().find(|seen| seen.who.id == obstacle.id);
        let lane = seen.and_then(|seen| {
            let mut predictor = Predictor::new(&past, Model::AlongLanes);
            predictor.likeliest_lane(seen, EXTENSION)
        });
        let Some(end) = course.last().copied() else {
            return course;
        };
        match lane {
            Some(line) => {
                let left = line.length() - line.project(&end.position).s;
                course.continued(Path::along(line, &end), left.min(EXTENSION))
            }
            None => course.continued(Path::Straight(end), STRAIGHT_ON),
        }
    }
}
