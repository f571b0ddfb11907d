//! Predicts the motion of all road users from their observed history, as a few weighted hypotheses; deterministic.
//!
//! Predictions cannot access the future: see [`ObservedHistory`].

mod path;
mod present;

pub use path::Path;
pub use present::{Observed, ObservedHistory, Present, TrackedObject};

use std::sync::Arc;

use nearmiss_base::geometry::{Polyline, Pose, angle_between};

use crate::scenario::ObstacleType;
use path::Lanes;

/// How the future is thought to go on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Model {
    /// Straight on with the recorded velocity.
    ConstantVelocity,
    /// Straight on with the recorded velocity and acceleration, to standstill at most.
    ConstantAcceleration,
    /// Along the lanes, or on with the present turn, with accelerations that fade and are not quite known.
    AlongLanes,
}

/// Which way an obstacle goes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum PredictedPath {
    /// Straight on.
    Straight,
    /// On with the present turn, a little less or a little more of it.
    Turn,
    /// Along these lanelets.
    Lanes(Vec<i64>),
}

/// A line an obstacle may follow.
#[derive(Debug, Clone)]
pub struct Course {
    /// Which way.
    pub way: PredictedPath,
    /// Its line.
    pub path: Path,
    /// How likely, 0 to 1.
    pub weight: f64,
}

/// The hypotheses about an obstacle: each course at each speed.
#[derive(Debug, Clone)]
pub struct Prediction {
    /// The lines; their weights sum to 1.
    pub courses: Vec<Course>,
    /// Speeds along them, all equally likely.
    pub speeds: Vec<Speeds>,
}

/// One course at one speed.
#[derive(Debug, Clone)]
pub struct Trajectory {
    /// How likely, 0 to 1; those of a prediction sum to 1.
    pub weight: f64,
    /// The place of its course in [`Prediction::courses`].
    pub course: usize,
    /// The fastest it ever is, m/s, however the line bends.
    pub fastest: f64,
    /// Poses at 0, `tick`, 2 `tick`, … seconds from now.
    pub poses: Vec<Pose>,
}

impl Trajectory {
    /// The pose after so many seconds, straight between two of its poses, `tick` seconds apart; at its end the last one.
    #[must_use]
    pub fn pose_at(&self, seconds: f64, tick: f64) -> Pose {
        let (Some(end), ticks) = (self.poses.last(), (seconds / tick).max(0.0)) else {
            return Pose::new(0.0, 0.0, 0.0);
        };
        let place = ticks as usize;
        let (from, to) = match (self.poses.get(place), self.poses.get(place + 1)) {
            (Some(from), Some(to)) => (from, to),
            _ => return *end,
        };
        let share = ticks.fract();
        Pose {
            position: from.position + (to.position - from.position) * share,
            heading: from.heading + angle_between(from.heading, to.heading) * share,
        }
    }
}

/// Makes predictions for the participants of one past.
#[derive(Debug)]
pub struct Predictor<'a> {
    model: Model,
    lanes: Lanes<'a>,
}

/// Standard deviation of the acceleration along the line, m/s²: what SUMO's drivers and planners change within
/// a second or two without a cause that could be seen.
const LONGITUDINAL: f64 = 1.0;

/// Standard deviation of the acceleration across the line of an obstacle that follows no lane, m/s².
const LATERAL: f64 = 0.5;

/// The turn it adds is at most this, 1/m, however slow an obstacle is.
const MOST_CURVATURE: f64 = 0.1;

/// Seconds after which 1/e of an acceleration is left: manoeuvres last a few seconds.
const FADE: f64 = 2.0;

/// How likely an obstacle on a lane goes on along lanes instead of with its present turn: so likely that leaving the
/// lane for no visible reason is not critical by itself.
const LANES: f64 = 0.75;

/// The medians of five equally likely parts of the standard normal distribution.
const FIFTHS: [f64; 5] = [-1.2816, -0.5244, 0.0, 0.5244, 1.2816];

/// Three-point Gauss–Hermite quadrature of the standard normal distribution: places and weights.
const THREE: [(f64, f64); 3] = [
    (-1.732_050_808, 1.0 / 6.0),
    (0.0, 2.0 / 3.0),
    (1.732_050_808, 1.0 / 6.0),
];

impl<'a> Predictor<'a> {
    /// A predictor for the observed history `past`.
    #[must_use]
    pub fn new(past: &ObservedHistory<'a>, model: Model) -> Self {
        Self {
            model,
            lanes: Lanes::new(past.network()),
        }
    }

    /// The predicted motion of `seen` within `horizon` seconds.
    #[must_use]
    pub fn predict(&mut self, seen: &Observed<'_>, horizon: f64) -> Prediction {
        let present = match self.model {
            Model::AlongLanes => Present::estimate(seen),
            _ => Present::recorded(seen),
        };
        let speeds = self.speeds(&present, seen.who.parked);
        let reach = reach(&speeds, horizon);
        let courses = if self.model != Model::AlongLanes || seen.who.parked {
            vec![Course {
                way: PredictedPath::Straight,
                path: Path::Straight(present.pose),
                weight: 1.0,
            }]
        } else {
            self.courses(seen, &present, reach)
        };
        Prediction { courses, speeds }
    }

    /// The middle of the likeliest lane on from where `seen` is, `reach` metres long where the road goes on; nothing
    /// beside all lanes, or for pedestrians.
    #[must_use]
    pub fn likeliest_lane(&mut self, seen: &Observed<'_>, reach: f64) -> Option<Arc<Polyline>> {
        if seen.who.kind == Some(ObstacleType::Pedestrian) {
            return None;
        }
        let speed = Present::estimate(seen).speed;
        let ways = self.lanes.ways(seen, speed, reach);
        ways.into_iter().next().map(|way| way.line)
    }

    fn speeds(&self, present: &Present, parked: bool) -> Vec<Speeds> {
        let of = |acceleration: f64, fade| Speeds {
            speed: present.speed,
            acceleration,
            fade,
        };
        match self.model {
            _ if parked => vec![of(0.0, None)],
            Model::ConstantVelocity => vec![of(0.0, None)],
            Model::ConstantAcceleration => vec![of(present.acceleration, None)],
            Model::AlongLanes => FIFTHS
                .iter()
                .map(|z| of(present.acceleration + z * LONGITUDINAL, Some(FADE)))
                .collect(),
        }
    }

    fn courses(&mut self, seen: &Observed<'_>, present: &Present, reach: f64) -> Vec<Course> {
        // Pedestrians keep to no lane, and an obstacle that reverses is manoeuvring.
        let free = seen.who.kind == Some(ObstacleType::Pedestrian) || present.speed < 0.0;
        let lanes = if free {
            Vec::new()
        } else {
            self.lanes.ways(seen, present.speed, reach)
        };
        let total: f64 = lanes.iter().map(|way| way.weight).sum();
        let turning = if lanes.is_empty() { 1.0 } else { 1.0 - LANES };
        let spread = (LATERAL / present.speed.powi(2)).min(MOST_CURVATURE);
        let turns = THREE.iter().map(|(z, weight)| Course {
            way: PredictedPath::Turn,
            path: Path::Arc {
                start: present.pose,
                curvature: present.curvature + z * spread,
            },
            weight: turning * weight,
        });
        let along = lanes.into_iter().map(|way| Course {
            path: Path::along(way.line, &present.pose),
            way: PredictedPath::Lanes(way.lanelets),
            weight: LANES * way.weight / total,
        });
        turns.chain(along).collect()
    }
}

impl Prediction {
    /// Metres it gets at most within `horizon` seconds, whichever way.
    #[must_use]
    pub fn reach(&self, horizon: f64) -> f64 {
        reach(&self.speeds, horizon)
    }

    /// Every course at every speed, at `ticks` + 1 moments that are `tick` seconds apart.
    #[must_use]
    pub fn trajectories(&self, tick: f64, ticks: usize) -> Vec<Trajectory> {
        let share = 1.0 / self.speeds.len() as f64;
        let mut found = Vec::with_capacity(self.courses.len() * self.speeds.len());
        for (course, line) in self.courses.iter().enumerate() {
            for speeds in &self.speeds {
                let pose = |k: usize| line.path.pose_at(speeds.distance(k as f64 * tick));
                let poses: Vec<Pose> = (0..=ticks).map(pose).collect();
                let moved = |pair: &[Pose]| (pair[1].position - pair[0].position).norm() / tick;
                found.push(Trajectory {
                    weight: line.weight * share,
                    course,
                    fastest: poses.windows(2).map(moved).fold(0.0, f64::max),
                    poses,
                });
            }
        }
        found
    }
}

fn reach(speeds: &[Speeds], horizon: f64) -> f64 {
    let far = speeds.iter().map(|s| s.distance(horizon).abs());
    far.fold(0.0, f64::max)
}

/// A speed and an acceleration that decays to zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Speeds {
    /// m/s at the beginning; negative when reversing.
    pub speed: f64,
    /// m/s² at the beginning.
    pub acceleration: f64,
    /// Time constant of the decay, seconds; `None` for constant acceleration.
    pub fade: Option<f64>,
}

impl Speeds {
    /// Metres along the path after `t` seconds.
    ///
    /// No obstacle changes between forward and reverse: one that comes to a stop stays there, and one that stands only
    /// starts forward.
    #[must_use]
    pub fn distance(&self, t: f64) -> f64 {
        let t = self.stop().map_or(t, |stop| t.min(stop));
        let (v, a) = (self.speed, self.acceleration);
        match self.fade {
            None => v * t + a * t * t / 2.0,
            Some(tau) => v * t + a * tau * (t + tau * (-t / tau).exp_m1()),
        }
    }

    /// Seconds until it stands, if it ever does.
    #[must_use]
    pub fn stop(&self) -> Option<f64> {
        let (v, a) = (self.speed, self.acceleration);
        if v == 0.0 && a <= 0.0 {
            return Some(0.0);
        }
        if v * a >= 0.0 {
            return None;
        }
        match self.fade {
            None => Some(-v / a),
            Some(tau) => {
                let share = -v / (a * tau);
                (share < 1.0).then(|| -tau * (-share).ln_1p())
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn speeds(speed: f64, acceleration: f64, fade: Option<f64>) -> Speeds {
        Speeds {
            speed,
            acceleration,
            fade,
        }
    }

    #[test]
    fn braking_ends_at_standstill_and_never_in_reverse() {
        let brakes = speeds(10.0, -5.0, None);
        assert_eq!(brakes.stop(), Some(2.0));
        assert!((brakes.distance(1.0) - 7.5).abs() < 1e-12);
        assert!((brakes.distance(2.0) - 10.0).abs() < 1e-12);
        assert_eq!(brakes.distance(2.0), brakes.distance(9.0));
        let back = speeds(-4.0, 2.0, None);
        assert!((back.distance(9.0) + 4.0).abs() < 1e-12);
        let stands = speeds(0.0, -3.0, Some(2.0));
        assert_eq!(stands.distance(5.0), 0.0);
    }

    #[test]
    fn a_fading_acceleration_is_the_integral_of_its_speed() {
        for s in [speeds(8.0, 3.0, Some(2.0)), speeds(5.0, -6.0, Some(2.0))] {
            let (mut x, mut v, dt) = (0.0, s.speed, 1e-4);
            for k in 0..30_000 {
                let a = s.acceleration * (-f64::from(k) * dt / 2.0).exp();
                x += v * dt;
                v = (v + a * dt).max(0.0);
            }
            assert!((s.distance(3.0) - x).abs() < 5e-3, "{s:?}: {x}");
        }
        // 10 m/s are never lost to 4 m/s² that fade within 2 s: 8 m/s are.
        assert_eq!(speeds(10.0, -4.0, Some(2.0)).stop(), None);
        assert!(speeds(7.9, -4.0, Some(2.0)).stop().is_some());
    }
}
