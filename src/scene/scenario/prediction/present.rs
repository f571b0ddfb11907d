//! A scene as known at the end of a window, without any later motion, and the present states in it.

use std::ops::RangeInclusive;

use nearmiss_base::geometry::{Footprint, Placed, Pose, angle_between};

use crate::scenario::{
    LaneletNetwork, Motion, Obstacle, ObstacleRole, ObstacleType, Scenario, Scene, Window,
};

/// Where an obstacle is and how it moves now.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Present {
    /// Where.
    pub pose: Pose,
    /// m/s along the heading; negative when reversing.
    pub speed: f64,
    /// m/s² along the heading.
    pub acceleration: f64,
    /// Of the path it is on, 1/m; positive in left turns.
    pub curvature: f64,
}

/// Older motion is ignored, seconds.
const MEMORY: f64 = 0.3;

/// Where time steps are long, the last three count if they are not longer ago than this, seconds.
const LONGEST_MEMORY: f64 = 1.0;

/// A shorter path shows no curvature, metres.
const MIN_PATH_LENGTH: f64 = 1.0;

/// Slower than this is standing, m/s: files round to centimetres.
const STANDSTILL: f64 = 0.1;

/// Nothing on a road turns tighter (1/m), is faster (m/s), or has tyres for more (m/s²): what is beyond is an
/// error of the recording and not carried on.
const TIGHTEST: f64 = 0.2;
const FASTEST: f64 = 100.0;
const STRONGEST: f64 = 10.0;

impl Present {
    /// The present as it was recorded, without curvature.
    #[must_use]
    pub fn recorded(seen: &Observed<'_>) -> Self {
        let moving = if seen.who.parked { 0.0 } else { 1.0 };
        Self {
            pose: seen.motion.pose,
            speed: bounded(seen.motion.velocity * moving, FASTEST),
            acceleration: bounded(seen.motion.acceleration * moving, STRONGEST),
            curvature: 0.0,
        }
    }

    /// The present, worked out from positions and headings of the last 0.3 s.
    ///
    /// Speed and acceleration are a straight line fitted to the displacements: files tell velocities of
    /// different moments, some of the step to come; positions are what they agree on. An obstacle that was seen only
    /// once has the recorded values, and one that was seen twice the recorded acceleration.
    #[must_use]
    pub fn estimate(seen: &Observed<'_>) -> Self {
        let recorded = Self::recorded(seen);
        if seen.who.parked {
            return recorded;
        }
        let recent = recent(seen);
        let (mut line, mut length, mut turn) = (Line::default(), 0.0, 0.0);
        for pair in recent.windows(2) {
            let ((before, a), (after, b)) = (&pair[0], &pair[1]);
            let middle = a.pose.forward().lerp(&b.pose.forward(), 0.5);
            let along = (b.pose.position - a.pose.position).dot(&middle);
            let (before, after) = (seen.ago(*before), seen.ago(*after));
            line.add(-f64::midpoint(before, after), along / (before - after));
            length += along;
            turn += angle_between(a.pose.heading, b.pose.heading);
        }
        let Some((speed, slope)) = line.at_zero() else {
            return recorded;
        };
        let curvature = if length.abs() >= MIN_PATH_LENGTH {
            bounded(turn / length, TIGHTEST)
        } else {
            0.0
        };
        Self {
            speed: if speed.abs() < STANDSTILL {
                0.0
            } else {
                bounded(speed, FASTEST)
            },
            acceleration: slope.map_or(recorded.acceleration, |a| bounded(a, STRONGEST)),
            curvature,
            ..recorded
        }
    }
}

/// `value` clamped to ±`most`; 0 for NaN.
fn bounded(value: f64, most: f64) -> f64 {
    if value.is_nan() {
        0.0
    } else {
        value.clamp(-most, most)
    }
}

fn recent<'a>(seen: &Observed<'a>) -> &'a [(i64, Motion)] {
    // Half a microsecond covers the dust of binary fractions.
    let since = |memory: f64| {
        let old = |(step, _): &(i64, Motion)| seen.ago(*step) > memory + 5e-7;
        seen.motions.partition_point(old)
    };
    let three = seen.motions.len().saturating_sub(3);
    let from = since(MEMORY).min(three.max(since(LONGEST_MEMORY)));
    &seen.motions[from..]
}

/// Least squares of a straight line.
#[derive(Default)]
struct Line {
    n: f64,
    x: f64,
    y: f64,
    xx: f64,
    xy: f64,
}

impl Line {
    fn add(&mut self, x: f64, y: f64) {
        self.n += 1.0;
        self.x += x;
        self.y += y;
        self.xx += x * x;
        self.xy += x * y;
    }

    /// The value at 0 and the slope; a single point has no slope and is the value.
    fn at_zero(&self) -> Option<(f64, Option<f64>)> {
        if self.n == 0.0 {
            return None;
        }
        let spread = self.n * self.xx - self.x * self.x;
        if self.n < 2.0 || spread <= 0.0 {
            return Some((self.y / self.n, None));
        }
        let slope = (self.n * self.xy - self.x * self.y) / spread;
        Some(((self.y - slope * self.x) / self.n, Some(slope)))
    }
}

/// The road, and the motion of all road users during a window.
///
/// It holds slices that end at the window's last step instead of the tracks themselves, so code that is given
/// a history cannot look into the future of the ego or of an obstacle. It does not hold the ego's goal either.
#[derive(Debug, Clone)]
pub struct ObservedHistory<'a> {
    network: &'a LaneletNetwork,
    now: i64,
    ego: Option<Observed<'a>>,
    others: Vec<Observed<'a>>,
    sets: Vec<&'a Obstacle>,
}

/// An obstacle without its future motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TrackedObject {
    /// Its id.
    pub id: i64,
    /// Its type; `None` for the ego.
    pub kind: Option<ObstacleType>,
    /// Whether it stands for ever.
    pub parked: bool,
}

/// A participant during a window, there at its last step.
#[derive(Debug, Clone, Copy)]
pub struct Observed<'a> {
    /// The object.
    pub who: TrackedObject,
    /// The region it covers now, in its own frame.
    pub footprint: &'a Footprint,
    /// Now.
    pub motion: &'a Motion,
    /// Steps and motions of the window, in order; the last is now. Never empty.
    pub motions: &'a [(i64, Motion)],
    /// Seconds between two time steps.
    pub dt: f64,
}

impl<'a> Observed<'a> {
    /// Its body now.
    #[must_use]
    pub fn placed(&self) -> Placed<'a> {
        self.footprint.at(self.motion.pose)
    }

    /// Seconds from `step` to now.
    #[must_use]
    pub fn ago(&self, step: i64) -> f64 {
        let now = self.motions.last().map_or(step, |(now, _)| *now);
        (now - step) as f64 * self.dt
    }

    fn at_end(
        who: TrackedObject,
        footprint: &'a Footprint,
        motions: &'a [(i64, Motion)],
        end: Option<i64>,
        dt: f64,
    ) -> Option<Self> {
        let (step, motion) = motions.last()?;
        end.is_none_or(|end| end == *step).then_some(Self {
            who,
            footprint,
            motion,
            motions,
            dt,
        })
    }
}

impl<'a> ObservedHistory<'a> {
    /// The history of `scene` up to the end of `window`.
    #[must_use]
    pub fn from_window(scene: &'a Scene, window: &Window) -> Self {
        let (now, dt, steps) = (window.last(), scene.scenario.dt(), window.steps());
        let who = TrackedObject {
            id: scene.ego.id,
            kind: None,
            parked: false,
        };
        let ego = scene.ego.track.during(&steps);
        let (sets, others): (Vec<_>, Vec<_>) = scene
            .participants()
            .partition(|p| p.obstacle.is_set_based());
        let others = others
            .into_iter()
            .filter_map(|p| observed(p.obstacle, p.footprint_at(now), &steps, dt));
        Self {
            network: &scene.scenario.network,
            now,
            ego: Observed::at_end(who, scene.ego_footprint_at(now), ego, Some(now), dt),
            others: others.collect(),
            sets: sets.into_iter().map(|p| p.obstacle).collect(),
        }
    }

    /// What was known of everyone in `scenario` but `without` during `steps`, the last of which is now; none is the
    /// ego.
    #[must_use]
    pub fn of_traffic(
        scenario: &'a Scenario,
        steps: RangeInclusive<i64>,
        without: Option<i64>,
    ) -> Self {
        let (now, dt) = (*steps.end(), scenario.dt());
        let obstacles = scenario.obstacles.iter();
        let others = obstacles.filter_map(|obstacle| {
            let bodily = matches!(obstacle.role, ObstacleRole::Static | ObstacleRole::Dynamic);
            let footprint = obstacle.footprint_at(now)?;
            let there = bodily && Some(obstacle.id) != without;
            there.then(|| observed(obstacle, footprint, &steps, dt))?
        });
        Self {
            network: &scenario.network,
            now,
            ego: None,
            others: others.collect(),
            sets: Vec::new(),
        }
    }

    /// Those whose occupancy sets say where they may be, which is a prediction and known now.
    #[must_use]
    pub fn sets(&self) -> &[&'a Obstacle] {
        &self.sets
    }

    /// The road.
    #[must_use]
    pub fn network(&self) -> &'a LaneletNetwork {
        self.network
    }

    /// The present: the window's last step.
    #[must_use]
    pub fn now(&self) -> i64 {
        self.now
    }

    /// The ego; nothing in a gap of its recording.
    #[must_use]
    pub fn ego(&self) -> Option<&Observed<'a>> {
        self.ego.as_ref()
    }

    /// The other road users present now, in the file's order.
    #[must_use]
    pub fn others(&self) -> &[Observed<'a>] {
        &self.others
    }
}

/// An obstacle during `steps`; `None` if it is absent at the last one.
fn observed<'a>(
    obstacle: &'a Obstacle,
    footprint: &'a Footprint,
    steps: &RangeInclusive<i64>,
    dt: f64,
) -> Option<Observed<'a>> {
    let parked = obstacle.role == ObstacleRole::Static;
    let who = TrackedObject {
        id: obstacle.id,
        kind: Some(obstacle.kind),
        parked,
    };
    let track = obstacle.track();
    // An obstacle that stands for ever has one state, which holds at all times.
    let (motions, end) = if parked {
        (track.during(&(i64::MIN..=i64::MAX)), None)
    } else {
        (track.during(steps), Some(*steps.end()))
    };
    Observed::at_end(who, footprint, motions, end, dt)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::super::TrackedObject;
    use super::*;
    use nearmiss_base::geometry::{Footprint, Shape};

    fn present(dt: f64, steps: &[i64], pose: impl Fn(f64) -> Pose) -> Present {
        let motions: Vec<(i64, Motion)> = steps
            .iter()
            .map(|&step| {
                let motion = Motion {
                    pose: pose(step as f64 * dt),
                    velocity: 77.0,
                    acceleration: 7.0,
                };
                (step, motion)
            })
            .collect();
        let footprint = Footprint::new(Shape::rectangle(4.0, 2.0)).unwrap();
        Present::estimate(&Observed {
            who: TrackedObject {
                id: 1,
                kind: None,
                parked: false,
            },
            footprint: &footprint,
            motion: &motions[motions.len() - 1].1,
            motions: &motions,
            dt,
        })
    }

    #[test]
    fn positions_tell_speed_acceleration_and_turn() {
        let brakes = |t: f64| Pose::new(12.0 * t - 1.5 * t * t, 4.0, 0.0);
        let p = present(0.1, &[0, 1, 2, 3, 4, 5], brakes);
        assert!((p.speed - 10.5).abs() < 1e-9 && (p.acceleration + 3.0).abs() < 1e-9);
        assert_eq!(p.curvature, 0.0);
        let back = present(0.1, &[0, 1, 2, 3], |t| Pose::new(-2.0 * t, 0.0, 0.0));
        assert!((back.speed + 2.0).abs() < 1e-9);
        // 8 m/s on a circle of 20 m to the right.
        let circle = |t: f64| {
            let turn = 0.4 * t;
            Pose::new(20.0 * turn.sin(), 20.0 * (turn.cos() - 1.0), -turn)
        };
        let p = present(0.1, &[0, 1, 2, 3, 4], circle);
        assert!((p.curvature + 0.05).abs() < 1e-4, "{p:?}");
        assert!((p.speed - 8.0).abs() < 1e-2, "{p:?}");
    }

    #[test]
    fn few_steps_long_steps_and_gaps() {
        let drives = |t: f64| Pose::new(9.0 * t, 0.0, 0.0);
        let once = present(0.1, &[4], drives);
        assert_eq!((once.speed, once.acceleration), (77.0, 7.0));
        let twice = present(0.1, &[3, 4], drives);
        assert!((twice.speed - 9.0).abs() < 1e-9 && twice.acceleration == 7.0);
        let slow = present(0.4, &[0, 1, 2], drives);
        assert!((slow.speed - 9.0).abs() < 1e-9 && slow.acceleration.abs() < 1e-9);
        // Old motion is ignored.
        let gap = present(0.1, &[0, 60], drives);
        assert_eq!(gap.speed, 77.0);
    }

    #[test]
    fn a_jump_is_not_carried_on() {
        let jump = |t: f64| Pose::new(if t > 0.25 { 1e9 } else { 0.0 }, 0.0, 0.0);
        let p = present(0.1, &[0, 1, 2, 3], jump);
        assert!(p.speed <= FASTEST && p.acceleration <= STRONGEST);
        let nowhere = present(0.1, &[0, 1, 2], |_| Pose::new(f64::MAX, f64::MIN, 0.0));
        assert!(nowhere.speed.is_finite() && nowhere.acceleration.is_finite());
    }
}
