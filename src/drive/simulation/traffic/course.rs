//! The way of an obstacle by distance, how fast it wants to be there, and whom it keeps its distance to.

use nearmiss_base::geometry::{Footprint, Placed, Pose, angle_between};
use nearmiss_scene::scenario::prediction::Path;
use nearmiss_scene::scenario::{HumanLimits, Track};

use super::reacting::{HORIZON, Idm, SAME_WAY, TICK, touch};

/// A way, by the distance driven on it since the first recorded state.
#[derive(Debug, Clone)]
pub struct Course {
    /// Distances in metres, each larger than the one before, and the poses there.
    places: Vec<(f64, Pose)>,
    /// Time steps and the distance at them, in order.
    steps: Vec<(i64, f64)>,
    /// The way on, from the last pose.
    beyond: Path,
    /// Metres of it.
    more: f64,
}

/// Longer ways are jumps of a damaged recording, metres: such an obstacle follows it.
pub(super) const MAX_LENGTH: f64 = 100_000.0;

/// Displacements below this are no way, metres.
const STANDSTILL: f64 = 1e-3;

/// Recorded speeds below this are driving backwards, m/s.
const BACKWARDS: f64 = -0.3;

impl Course {
    /// The recorded way, continued straight; nothing where nothing is recorded, or it is driven backwards.
    #[must_use]
    pub fn recorded(track: &Track) -> Option<Self> {
        if track.iter().any(|(_, motion)| motion.velocity < BACKWARDS) {
            return None;
        }
        let (mut places, mut steps): (Vec<(f64, Pose)>, Vec<_>) = (Vec::new(), Vec::new());
        for (step, motion) in track.iter() {
            match places.last() {
                None => places.push((0.0, motion.pose)),
                Some((s, last)) => {
                    let moved = (motion.pose.position - last.position).norm();
                    if moved > STANDSTILL {
                        places.push((s + moved, motion.pose));
                    }
                }
            }
            steps.push((step, places.last()?.0));
        }
        let (length, last) = *places.last()?;
        if length > MAX_LENGTH {
            return None;
        }
        Some(Self {
            places,
            steps,
            beyond: Path::Straight(last),
            more: 0.0,
        })
    }

    /// The same, with `path` from its last pose for `length` metres.
    #[must_use]
    pub fn continued(self, path: Path, length: f64) -> Self {
        Self {
            beyond: path,
            more: length.max(0.0),
            ..self
        }
    }

    /// Metres of it that were recorded.
    #[must_use]
    pub fn recorded_length(&self) -> f64 {
        self.places.last().map_or(0.0, |(s, _)| *s)
    }

    /// Metres of it.
    #[must_use]
    pub fn length(&self) -> f64 {
        self.recorded_length() + self.more
    }

    /// The last recorded pose.
    #[must_use]
    pub fn last(&self) -> Option<&Pose> {
        self.places.last().map(|(_, pose)| pose)
    }

    /// The distance at a recorded step.
    #[must_use]
    pub fn at_step(&self, step: i64) -> Option<f64> {
        let found = self.steps.binary_search_by_key(&step, |(at, _)| *at).ok()?;
        Some(self.steps[found].1)
    }

    /// The recorded steps and the distances at them.
    #[must_use]
    pub fn steps(&self) -> &[(i64, f64)] {
        &self.steps
    }

    /// The pose at distance `s` (m); before the beginning the first one.
    #[must_use]
    pub fn pose_at(&self, s: f64) -> Pose {
        let next = self.places.partition_point(|(at, _)| *at < s);
        match (
            next.checked_sub(1).map(|i| self.places[i]),
            self.places.get(next),
        ) {
            (Some((from, a)), Some((to, b))) => a.towards(b, (s - from) / (to - from)),
            (Some((end, _)), None) => self.beyond.pose_at(s - end),
            (None, _) => self.places[0].1,
        }
    }
}

/// Desired speeds along a course, and where it waits until when.
#[derive(Debug, Clone)]
pub struct Desired {
    /// m/s at 0, 1, 2, … m.
    speeds: Vec<f64>,
    stops: Vec<Stop>,
}

/// A place at which an obstacle stood.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Stop {
    /// Metres along its course.
    place: f64,
    /// The first step at which it moves again.
    until: i64,
}

/// Recorded speeds below this are standing, m/s.
const STANDING: f64 = 0.2;

/// Shorter stands are part of slow driving, seconds.
const SHORTEST_STOP: f64 = 1.0;

/// Who stopped at a place would otherwise stay there for ever: no slower than this is desired, m/s, unless it never was
/// as fast.
const CREEPING: f64 = 3.0;

/// The bend of a lane is measured over this length, metres.
const CHORD: f64 = 6.0;

/// Deceleration towards a bend beyond the recording, m/s².
const BRAKING: f64 = 1.5;

/// Share of the lateral acceleration that people bear at most that they drive bends with.
const IN_BENDS: f64 = 0.5;

impl Desired {
    /// Those of an obstacle that was recorded as `track` on `course`; time steps are `dt` seconds long.
    #[must_use]
    pub fn new(course: &Course, track: &Track, limits: &HumanLimits, dt: f64) -> Self {
        let recorded: Vec<(f64, f64)> = course
            .steps()
            .iter()
            .filter_map(|(step, s)| Some((*s, track.at(*step)?.velocity.abs())))
            .collect();
        let fastest = recorded.iter().map(|(_, v)| *v).fold(0.0, f64::max);
        let floor = CREEPING.min(fastest);
        let end = course.recorded_length();
        let bend = |s: f64| {
            let turn = angle_between(
                course.pose_at(s - CHORD / 2.0).heading,
                course.pose_at(s + CHORD / 2.0).heading,
            );
            (IN_BENDS * limits.lateral * CHORD / turn.abs().max(1e-6)).sqrt()
        };
        let metres = course.length().ceil().max(1.0) as usize;
        let mut speeds: Vec<f64> = (0..=metres)
            .map(|metre| {
                let s = metre as f64;
                let wanted = at(&recorded, s).max(floor);
                let wanted = if s > end { wanted.min(bend(s)) } else { wanted };
                wanted.min(limits.speed)
            })
            .collect();
        for metre in (end.ceil() as usize..metres).rev() {
            let reached = (speeds[metre + 1].powi(2) + 2.0 * BRAKING).sqrt();
            speeds[metre] = speeds[metre].min(reached);
        }
        Self {
            speeds,
            stops: stops(course, track, dt),
        }
    }

    /// The desired speed at distance `s` (m), m/s.
    #[must_use]
    pub fn speed(&self, s: f64) -> f64 {
        let last = self.speeds.len() - 1;
        let place = s.clamp(0.0, last as f64);
        let (from, share) = (place as usize, place.fract());
        let next = self.speeds[(from + 1).min(last)];
        self.speeds[from] + (next - self.speeds[from]) * share
    }

    /// The next place, metres along the course, at which an obstacle that is at distance `s` at `step` still waits as it
    /// was recorded to: at a light, or for what was there.
    #[must_use]
    pub fn waits_at(&self, s: f64, step: i64) -> Option<f64> {
        let ahead = self
            .stops
            .iter()
            .filter(|stop| step < stop.until)
            .map(|stop| stop.place)
            .filter(|place| *place >= s - 0.5);
        ahead.min_by(f64::total_cmp)
    }
}

/// The speed at a distance among recorded ones, whose distances never shrink.
fn at(recorded: &[(f64, f64)], s: f64) -> f64 {
    let next = recorded.partition_point(|(at, _)| *at < s);
    match (next.checked_sub(1).map(|i| recorded[i]), recorded.get(next)) {
        (Some((from, a)), Some((to, b))) => a + (b - a) * (s - from) / (to - from),
        (Some((_, v)), None) => v,
        (None, first) => first.map_or(0.0, |(_, v)| *v),
    }
}

fn stops(course: &Course, track: &Track, dt: f64) -> Vec<Stop> {
    let mut found = Vec::new();
    let mut since: Option<i64> = None;
    for (step, place) in course.steps() {
        let stands = track.at(*step).is_some_and(|m| m.velocity.abs() < STANDING);
        match (stands, since) {
            (true, None) => since = Some(*step),
            (false, Some(from)) => {
                if (step - from) as f64 * dt >= SHORTEST_STOP {
                    found.push(Stop {
                        place: *place,
                        until: *step,
                    });
                }
                since = None;
            }
            _ => {}
        }
    }
    // It stood to the end of the recording.
    if let (Some(_), Some((_, place))) = (since, course.steps().last()) {
        found.push(Stop {
            place: *place,
            until: i64::MAX,
        });
    }
    found
}

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
