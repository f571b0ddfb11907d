//! One obstacle that reacts: its state, and its next step.

use super::course::Course;
use super::desired::Desired;
use super::idm::Idm;
use super::leader::{Ahead, Leader};
use super::neighbour::Neighbour;
use nearmiss_base::geometry::Footprint;
use nearmiss_scene::scenario::{HumanLimits, Motion, Obstacle};

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
        let limits = HumanLimits::of(obstacle.kind);
        Some(Self {
            s: course.at_step(step)?,
            v: motion.velocity.abs(),
            a: motion
                .acceleration
                .clamp(-limits.braking, limits.speeding_up),
            desired: Desired::new(&course, obstacle.track(), &limits, dt),
            idm: Idm::of(obstacle.kind),
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
