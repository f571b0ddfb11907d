//! Obstacles that react: when each begins to, and its next step by the Intelligent Driver Model.
//!
//! The Intelligent Driver Model: acceleration by own speed, desired speed, gap and closing speed.
//!
//! Source: Treiber, Hennecke and Helbing, Congested traffic states in empirical observations and microscopic
//! simulations, Physical Review E 62, 2000. Above the desired speed, where that formula brakes without bound, the free
//! term is that of the Improved IDM (Treiber and Kesting, Traffic Flow Dynamics, 2013, section 11.3.7).

use nearmiss_base::geometry::{Footprint, Placed, angle_between};
use nearmiss_scene::metrics::sides;
use nearmiss_scene::scenario::prediction::{Model, ObservedHistory, Path, Predictor};
use nearmiss_scene::scenario::{HumanLimits, Motion, Obstacle, ObstacleRole, ObstacleType};

use super::Reactive;
use super::course::{Ahead, Course, Desired, Expected, Leader, Neighbour};
use crate::simulation::ContactSide;

/// An obstacle that reacts.
#[derive(Debug, Clone)]
pub struct Reacting {
    /// Its way.
    pub course: Course,
    desired: Desired,
    idm: Idm,
    limits: HumanLimits,
    /// Metres along its way.
    pub s: f64,
    /// m/s.
    pub v: f64,
    /// m/s².
    pub a: f64,
    /// Time steps and motions since its last recorded state, that one included.
    pub motions: Vec<(i64, Motion)>,
}

impl Reacting {
    /// An obstacle that reacts from `step` on, along `course`; nothing where it is not there.
    #[must_use]
    pub fn new(obstacle: &Obstacle, course: Course, step: i64, dt: f64) -> Option<Self> {
        let motion = *obstacle.motion_at(step)?;
        let limits = HumanLimits::for_kind(obstacle.kind);
        Some(Self {
            s: course.at_step(step)?,
            v: motion.velocity.abs(),
            a: motion
                .acceleration
                .clamp(-limits.braking, limits.speeding_up),
            desired: Desired::new(&course, obstacle.track(), &limits, dt),
            idm: Idm::for_kind(obstacle.kind),
            limits,
            motions: vec![(step, motion)],
            course,
        })
    }

    /// Whether it has come to the end of its way.
    #[must_use]
    pub fn is_gone(&self) -> bool {
        self.s > self.course.length()
    }

    /// The acceleration of its next step, m/s²: the smallest that its desired speed, where it waits and any of the
    /// others ask for, within the limits of people.
    #[must_use]
    pub fn decide(
        &self,
        place: usize,
        footprint: &Footprint,
        others: &[Neighbour<'_>],
        dt: f64,
    ) -> f64 {
        let (step, _) = self.motions[self.motions.len() - 1];
        let free = self.idm.free(self.v, self.desired.speed(self.s));
        let ahead = Ahead::new(
            place,
            footprint,
            |distance| self.course.pose_at(self.s + distance),
            self.v,
            self.idm,
            self.limits.braking,
        );
        let others = others.iter().filter(|other| other.place != Some(place));
        let waiting = self.desired.waits_at(self.s, step).map(|at| Leader {
            gap: (at - self.s).max(0.0) + self.idm.standstill_gap,
            speed: 0.0,
            gentle: false,
        });
        let leaders = others
            .filter_map(|other| ahead.leader(other))
            .chain(waiting);
        let wanted = leaders.fold(free, |least, leader| {
            let towards = free - self.idm.interaction(self.v, leader.gap, leader.speed);
            let towards = if leader.gentle {
                towards.max(-self.idm.deceleration)
            } else {
                towards
            };
            least.min(towards)
        });
        let (limits, change) = (&self.limits, self.limits.jerk * dt);
        wanted
            .clamp(self.a - change, self.a + change)
            .clamp(-limits.braking, limits.speeding_up)
    }

    /// Goes on for a step of `dt` seconds with an acceleration (m/s²); it stops, and does not drive backwards.
    pub fn go_on(&mut self, acceleration: f64, dt: f64) {
        let next = self.v + acceleration * dt;
        let (s, v) = if next < 0.0 {
            // It stands before the step is over.
            (self.v * self.v / (-2.0 * acceleration), 0.0)
        } else {
            (f64::midpoint(self.v, next) * dt, next)
        };
        self.s += s;
        self.v = v;
        self.a = if v == 0.0 {
            acceleration.max(0.0)
        } else {
            acceleration
        };
        let (step, _) = self.motions[self.motions.len() - 1];
        let motion = self.motion();
        self.motions.push((step + 1, motion));
    }

    /// Its present motion.
    fn motion(&self) -> Motion {
        Motion {
            pose: self.course.pose_at(self.s),
            velocity: self.v,
            acceleration: self.a,
        }
    }

    /// Its motions, and those of `steps` more steps at its present speed, for forecasts that are told the future.
    #[must_use]
    pub fn foreseen(&self, steps: usize, dt: f64) -> Vec<(i64, Motion)> {
        let mut all = self.motions.clone();
        let (now, motion) = self.motions[self.motions.len() - 1];
        all.extend((1..=steps).map(|k| {
            let s = self.s + self.v * k as f64 * dt;
            let pose = self.course.pose_at(s);
            let later = Motion {
                pose,
                acceleration: 0.0,
                ..motion
            };
            (now + k as i64, later)
        }));
        all
    }
}

/// Parameters of the model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Idm {
    /// Time gap to the leader, seconds.
    pub time_gap: f64,
    /// Gap at standstill, metres.
    pub standstill_gap: f64,
    /// Largest acceleration on a free road, m/s².
    pub acceleration: f64,
    /// Comfortable deceleration, m/s².
    pub deceleration: f64,
}

/// Acceleration exponent.
const EXPONENT: f64 = 4.0;

/// A gap is no shorter than this in the formula, metres.
const MIN_GAP: f64 = 0.05;

impl Idm {
    /// The parameters for a kind of road user: those of Treiber and Kesting (2013), table 11.2, a time gap of 1 s,
    /// 2 m at standstill, 1 m/s² and 1.5 m/s². Cyclists and pedestrians stand closer, by our own choice.
    #[must_use]
    pub fn for_kind(kind: ObstacleType) -> Self {
        Self {
            time_gap: 1.0,
            standstill_gap: match kind {
                ObstacleType::Pedestrian => 0.5,
                ObstacleType::Bicycle => 1.0,
                _ => 2.0,
            },
            acceleration: 1.0,
            deceleration: 1.5,
        }
    }

    /// The gap wanted at speed `v` (m/s) behind a leader that is approached with `closing` m/s, metres.
    #[must_use]
    pub fn desired_gap(&self, v: f64, closing: f64) -> f64 {
        let braking = v * closing / (2.0 * (self.acceleration * self.deceleration).sqrt());
        self.standstill_gap + (v * self.time_gap + braking).max(0.0)
    }

    /// The acceleration on a free road at speed `v` where `wanted` is desired (both m/s), m/s².
    #[must_use]
    pub fn free(&self, v: f64, wanted: f64) -> f64 {
        if v <= wanted {
            let share = if wanted > 0.0 { v / wanted } else { 1.0 };
            self.acceleration * (1.0 - share.powf(EXPONENT))
        } else {
            let exponent = self.acceleration * EXPONENT / self.deceleration;
            -self.deceleration * (1.0 - (wanted.max(0.0) / v).powf(exponent))
        }
    }

    /// What a leader `gap` metres ahead with speed `leader` (m/s) takes off the free acceleration, m/s².
    #[must_use]
    pub fn interaction(&self, v: f64, gap: f64, leader: f64) -> f64 {
        let wanted = self.desired_gap(v, v - leader);
        self.acceleration * (wanted / gap.max(MIN_GAP)).powi(2)
    }
}

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
    match sides(own, other)[0] {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_gap_in_equilibrium_is_the_formulas() {
        let idm = Idm::for_kind(ObstacleType::Car);
        // At 10 m/s where 15 m/s are desired: (2 + 10·1) / √(1 − (10/15)⁴) = 13.40 m.
        let gap = 12.0 / (1.0 - (10.0_f64 / 15.0).powi(4)).sqrt();
        assert!((gap - 13.396).abs() < 1e-3, "{gap}");
        let acceleration = idm.free(10.0, 15.0) - idm.interaction(10.0, gap, 10.0);
        assert!(acceleration.abs() < 1e-12, "{acceleration}");
    }

    #[test]
    fn a_free_road_is_driven_at_the_desired_speed() {
        let idm = Idm::for_kind(ObstacleType::Car);
        assert_eq!(idm.free(0.0, 10.0), 1.0);
        assert_eq!(idm.free(10.0, 10.0), 0.0);
        // Twice as fast as desired: never more than comfortable braking.
        let slower = idm.free(20.0, 10.0);
        assert!((-1.5..-1.0).contains(&slower), "{slower}");
        assert_eq!(idm.free(5.0, 0.0), -1.5);
    }

    #[test]
    fn standing_at_the_standstill_gap_stays_there() {
        let idm = Idm::for_kind(ObstacleType::Car);
        assert_eq!(idm.free(0.0, 10.0) - idm.interaction(0.0, 2.0, 0.0), 0.0);
        // A leader that drives away opens the gap: 2 + max(0, 5 − 5·5/2√1.5) = 2.
        assert_eq!(idm.desired_gap(5.0, -5.0), 2.0);
    }
}
