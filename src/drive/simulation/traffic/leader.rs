//! What an obstacle that reacts keeps its distance to: bodies on its way, and those that reach a crossing first.

use nearmiss_base::geometry::{Footprint, Placed, Pose, angle_between};
use nearmiss_scene::scenario::prediction::Path;

use super::course::Course;
use super::reacting::Idm;
use super::trigger::{HORIZON, SAME_WAY, TICK, touch};

/// Something ahead.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Leader {
    /// Metres until the bodies would touch.
    pub gap: f64,
    /// m/s along the way.
    pub speed: f64,
    /// Whether it is only a reason to slow down comfortably.
    pub gentle: bool,
}

/// Of an obstacle that reacts: its body along the way ahead.
#[derive(Debug)]
pub struct Ahead<'a, F: Fn(f64) -> Pose> {
    /// Its place in the file's order.
    pub place: usize,
    /// Its body.
    pub footprint: &'a Footprint,
    /// Its pose after so many metres.
    pub pose: F,
    /// m/s.
    pub speed: f64,
    /// How it reacts.
    pub idm: Idm,
    /// Its strongest braking, m/s².
    pub braking: f64,
    poses: Vec<Pose>,
}

/// Metres between two places that are looked at; what is found is refined to 1/16 of it.
const SPACING: f64 = 1.0;

/// Farther ahead than this nothing is looked for, metres.
const LOOKAHEAD: f64 = 120.0;

/// A slower body does not cross a way but stands on it, m/s.
const CROSSING: f64 = 0.5;

/// Seconds between two bodies at a crossing that are enough for the second not to wait.
const CLEARANCE: f64 = 1.0;

/// Arrivals at a crossing that differ by less are a tie, seconds: the ego goes first, then the order of the file decides.
const TIE: f64 = 0.3;

impl<'a, F: Fn(f64) -> Pose> Ahead<'a, F> {
    /// The way ahead of an obstacle, as far as it has to look at its speed.
    pub fn new(
        place: usize,
        footprint: &'a Footprint,
        pose: F,
        speed: f64,
        idm: Idm,
        braking: f64,
    ) -> Self {
        let look = speed * speed / (2.0 * idm.deceleration) + 2.0 * speed + 15.0;
        let count = (look.min(LOOKAHEAD) / SPACING).ceil() as usize;
        let poses = (0..=count).map(|n| pose(n as f64 * SPACING)).collect();
        Self {
            place,
            footprint,
            pose,
            speed,
            idm,
            braking,
            poses,
        }
    }

    /// What `other` is to it; nothing where they do not meet.
    pub fn leader(&self, other: &Neighbour<'_>) -> Option<Leader> {
        let here = &self.poses[0];
        let apart = (here.position - other.body.pose.position).norm();
        let reach = self.footprint.reach() + other.body.footprint.reach();
        let look = self.poses.len() as f64 * SPACING;
        if apart > look + reach + HORIZON * other.speed.abs() {
            return None;
        }
        let mut crossing: Option<Crossing> = None;
        let ticks = (HORIZON / TICK).round() as usize;
        // A standing body is where it is.
        let ticks = if other.speed == 0.0 { 0 } else { ticks };
        for tick in 0..=ticks {
            let after = tick as f64 * TICK;
            let Some((gap, pose)) = self.touches(other, after) else {
                continue;
            };
            let there = other.after(after, Expected::Steady).pose.heading;
            let turn = angle_between(pose.heading, there);
            let along = other.speed * turn.cos();
            if tick == 0 && gap == 0.0 && here.to_local(&other.body.pose.position).x < 0.0 {
                return None;
            }
            // What is on the way now is followed, unless it only crosses it.
            if tick == 0 && (turn.abs() < SAME_WAY || other.speed < CROSSING) {
                return Some(Leader {
                    gap,
                    speed: along.max(0.0),
                    gentle: false,
                });
            }
            if turn.abs() < SAME_WAY && crossing.is_none() {
                return self.merging(other, gap, along, after);
            }
            let found = crossing.get_or_insert(Crossing {
                entry: gap,
                first: after,
                last: after,
            });
            found.entry = found.entry.min(gap);
            // At the end of what is looked at it may stay there.
            found.last = if tick == ticks { f64::INFINITY } else { after };
        }
        let crossing = crossing?;
        let waits = self.waits_for(other.place, &crossing);
        waits.then_some(Leader {
            gap: crossing.entry,
            speed: 0.0,
            gentle: false,
        })
    }

    /// A body that joins the same way `gap` metres ahead in `after` seconds: it is followed as if it were on the way
    /// already, if it gets there first.
    fn merging(&self, other: &Neighbour<'_>, gap: f64, along: f64, after: f64) -> Option<Leader> {
        let now = gap - along * after;
        let length = self.footprint.reach() + other.body.footprint.reach();
        // Its middle is behind this one's: it is the one that has to follow.
        let first = now + length > TIE * along.max(self.speed);
        first.then_some(Leader {
            gap: now.max(self.idm.standstill_gap / 2.0),
            speed: along.max(0.0),
            gentle: true,
        })
    }

    /// Whether the other body reaches a crossing first and is not gone in time, and one can still stop.
    fn waits_for(&self, other: Option<usize>, crossing: &Crossing) -> bool {
        let arrival = self.arrival(crossing.entry);
        let before = if (crossing.first - arrival).abs() < TIE {
            other.is_none_or(|other| other < self.place)
        } else {
            crossing.first < arrival
        };
        let stops = self.speed * self.speed / (2.0 * self.braking) <= crossing.entry;
        before && stops && arrival <= crossing.last + CLEARANCE
    }

    /// Seconds until it is so many metres farther, at the earliest.
    fn arrival(&self, distance: f64) -> f64 {
        let (v, a) = (self.speed, self.idm.acceleration);
        ((v * v + 2.0 * a * distance).sqrt() - v) / a
    }

    /// How far ahead it would touch a body that is where `other` is expected after so many seconds, and its pose there.
    fn touches(&self, other: &Neighbour<'_>, after: f64) -> Option<(f64, Pose)> {
        let body = other.after(after, Expected::Steady);
        let found = self
            .poses
            .iter()
            .position(|pose| touch(&self.footprint.at(*pose), &body))?;
        let Some(before) = found.checked_sub(1) else {
            return Some((0.0, self.poses[0]));
        };
        let (mut free, mut taken) = (before as f64 * SPACING, found as f64 * SPACING);
        for _ in 0..4 {
            let middle = f64::midpoint(free, taken);
            if touch(&self.footprint.at((self.pose)(middle)), &body) {
                taken = middle
            } else {
                free = middle
            }
        }
        Some((free, self.poses[found]))
    }
}

/// Where the ways of two bodies cross.
#[derive(Debug, Clone, Copy)]
struct Crossing {
    /// Metres until one would touch the other somewhere on its way.
    entry: f64,
    /// Seconds until the other is there, and until it is gone.
    first: f64,
    last: f64,
}

/// A road user, or a thing, as the others see it at one step.
#[derive(Debug, Clone)]
pub struct Neighbour<'a> {
    /// Its place in the file's order; `None` for the ego.
    pub place: Option<usize>,
    /// Its body.
    pub body: Placed<'a>,
    /// m/s along its way.
    pub speed: f64,
    /// m/s² along its way.
    pub acceleration: f64,
    /// Its way.
    pub way: ExpectedPath<'a>,
}

/// The way that a body is expected to take.
#[derive(Debug, Clone)]
pub enum ExpectedPath<'a> {
    /// Straight on.
    Straight,
    /// Along a path that begins where it is.
    Path(Path),
    /// Along a course, from this distance on.
    Course(&'a Course, f64),
}

/// How a body is expected to go on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Expected {
    /// As fast as now.
    Steady,
    /// Braking as it does now, to a stop.
    Braking,
}

impl<'a> Neighbour<'a> {
    /// Its body after so many seconds.
    #[must_use]
    pub fn after(&self, seconds: f64, expected: Expected) -> Placed<'a> {
        let distance = self.distance(seconds, expected);
        let pose = match &self.way {
            _ if distance == 0.0 => self.body.pose,
            ExpectedPath::Straight => Pose {
                position: self.body.pose.position + self.body.pose.forward() * distance,
                ..self.body.pose
            },
            ExpectedPath::Path(path) => path.pose_at(distance),
            ExpectedPath::Course(course, s) => course.pose_at(s + distance),
        };
        self.body.footprint.at(pose)
    }

    /// Metres that it is expected to drive within so many seconds.
    fn distance(&self, seconds: f64, expected: Expected) -> f64 {
        if expected == Expected::Steady || self.acceleration >= 0.0 || self.speed <= 0.0 {
            return self.speed * seconds;
        }
        let time = seconds.min(-self.speed / self.acceleration);
        time * (self.speed + self.acceleration * time / 2.0)
    }
}
