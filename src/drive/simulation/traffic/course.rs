//! The way of one obstacle by distance: its recorded poses, the lane beyond their end, and how fast it wants to be there.

use nearmiss_base::geometry::{Pose, angle_between};
use nearmiss_scene::scenario::prediction::Path;
use nearmiss_scene::scenario::{HumanLimits, Track};

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
