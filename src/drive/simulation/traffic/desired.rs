//! How fast an obstacle wants to be at each place of its way: as fast as it was recorded there.

use super::course::Course;
use nearmiss_base::geometry::angle_between;
use nearmiss_scene::scenario::{HumanLimits, Track};

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
