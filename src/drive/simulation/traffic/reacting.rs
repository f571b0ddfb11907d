//! One obstacle that reacts: its state, and its next step by the Intelligent Driver Model.
//!
//! The Intelligent Driver Model: acceleration by own speed, desired speed, gap and closing speed.
//!
//! Source: Treiber, Hennecke and Helbing, Congested traffic states in empirical observations and microscopic
//! simulations, Physical Review E 62, 2000. Above the desired speed, where that formula brakes without bound, the free
//! term is that of the Improved IDM (Treiber and Kesting, Traffic Flow Dynamics, 2013, section 11.3.7).

use nearmiss_base::geometry::Footprint;
use nearmiss_scene::scenario::{HumanLimits, Motion, Obstacle, ObstacleType};

use super::course::{Course, Desired};
use super::leader::{Ahead, Leader, Neighbour};

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
