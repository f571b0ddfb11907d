//! A moment of the ego with an obstacle: what happened, how severe it is, and crossings that passed closely.

use std::cmp::Ordering;
use std::fmt;

use nearmiss_base::geometry::Placed;

use super::{Graded, LATEST_PASS, NEAR_MISS, PairPaths, STANDING, same_direction};
use crate::metrics::Encounter;
use crate::metrics::recorded::conflict;

/// The hardest braking of road vehicles: gravity at a coefficient of friction of 1, m/s².
const MAX_BRAKING: f64 = 9.81;

/// What makes a moment matter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Hazard {
    /// The bodies touch.
    Contact {
        /// The speed of one relative to the other, m/s.
        closing_speed: f64,
        /// Whether what is touched is a region that the obstacle may be in, and not its body.
        is_possible: bool,
    },
    /// Both are on courses that end in contact.
    Course {
        /// Time to contact, seconds.
        seconds: f64,
        /// The braking that avoids it after a reaction, m/s².
        braking: f64,
    },
    /// One crosses the path of the other.
    Crossing {
        /// Post-encroachment time, seconds; nothing where one waits for the other.
        seconds: Option<f64>,
        /// Their smallest distance, metres.
        metres: f64,
    },
    /// One comes before the other.
    CutIn {
        /// The time that the one behind needs for the gap, seconds.
        seconds: f64,
        /// The gap, metres.
        metres: f64,
    },
    /// Nothing but near.
    Near {
        /// Their distance, metres.
        metres: f64,
    },
}

impl fmt::Display for Hazard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Contact {
                is_possible: true, ..
            } => write!(f, "possible contact with a predicted occupancy"),
            Self::Contact { closing_speed, .. } => write!(f, "contact at {closing_speed:.1} m/s"),
            Self::Course { seconds, braking } => {
                write!(f, "contact in {seconds:.1} s as they go; ")?;
                if *braking <= MAX_BRAKING {
                    write!(f, "avoided with {braking:.1} m/s² after a reaction")
                } else {
                    write!(f, "no braking avoids it")
                }
            }
            Self::Crossing {
                seconds: Some(seconds),
                metres,
            } => write!(f, "crosses {seconds:.1} s apart, {metres:.1} m"),
            Self::Crossing { metres, .. } => write!(f, "crosses {metres:.1} m apart"),
            Self::CutIn { seconds, metres } => {
                write!(f, "cuts in {seconds:.1} s, {metres:.1} m ahead")
            }
            Self::Near { metres } => write!(f, "nearest, {metres:.1} m"),
        }
    }
}

/// How severe a moment is. The less, the more severe.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Grade {
    /// The bodies touch.
    Contact,
    /// On a course to contact that takes hard braking soon.
    Conflict,
    /// A crossing or cut-in within a second or a metre.
    NearMiss,
    /// On a course to contact within 3 s.
    Course,
    /// On a course to contact within 5 s.
    Ahead,
    /// A crossing or cut-in within 2 s.
    Pass,
    /// On a course to contact within 10 s.
    LaterCourse,
    /// One follows the other.
    Following,
    /// Straight on there would be contact, but that is not where the road goes.
    StraightCourse,
    /// Near, and at least one moves.
    Near,
    /// Both stand, or the other is parked.
    Standing,
}

impl Grade {
    /// The severity as a number, 0 (contact) to 5 (nothing of note).
    #[must_use]
    pub fn number(self) -> u8 {
        match self {
            Self::Contact => 0,
            Self::Conflict => 1,
            Self::NearMiss => 2,
            Self::Course => 3,
            Self::Ahead | Self::Pass => 4,
            Self::LaterCourse
            | Self::Following
            | Self::StraightCourse
            | Self::Near
            | Self::Standing => 5,
        }
    }
}

/// What the numbers of severities are called, from 0.
pub const SEVERITY_NAMES: [&str; 6] = [
    "contact",
    "conflict",
    "near miss",
    "course",
    "later",
    "none",
];

/// The most severe moment with one obstacle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CriticalMoment {
    /// The obstacle.
    pub obstacle: i64,
    /// The step.
    pub step: i64,
    /// How severe it is.
    pub grade: Grade,
    /// Why.
    pub hazard: Hazard,
    /// The less, the more severe among those of the same grade.
    pub(super) order: f64,
}

impl CriticalMoment {
    /// The more severe one first; of two alike in a recording the earlier.
    #[must_use]
    pub fn compare(&self, other: &Self) -> Ordering {
        self.compare_across(other).then(self.step.cmp(&other.step))
    }

    /// Whether it is the moment that matters of the two, which are of the same pair and in the order of time: the first
    /// contact, however hard a later one is, for after it nothing is as recorded; else the more severe one.
    #[must_use]
    pub fn precedes(&self, earlier: &Self) -> bool {
        earlier.grade != Grade::Contact && self.compare(earlier).is_lt()
    }

    /// The more severe one first, of moments of different recordings.
    #[must_use]
    pub fn compare_across(&self, other: &Self) -> Ordering {
        let grade = self.grade.cmp(&other.grade);
        grade.then(self.order.total_cmp(&other.order))
    }
}

/// Who waits for another that crosses would have touched it within this time, seconds.
const YIELDED: f64 = 3.0;

/// Bodies that never come nearer than this do not pass closely, metres: 2 s at 40 m/s.
const MAX_DISTANCE: f64 = 80.0;

/// What of the pair passed closely.
pub(super) fn passes(pair: &PairPaths<'_, '_>) -> Vec<Graded> {
    let mut all = Vec::new();
    all.extend(crossing(pair));
    all.extend(cut_ins(pair));
    all
}

/// The crossing of both paths, at the step at which the bodies are nearest.
fn crossing(pair: &PairPaths<'_, '_>) -> Option<Graded> {
    let context = pair.context;
    let steps = context.steps().zip(context.distances(pair.participant));
    let present = steps.filter_map(|(step, distance)| Some((step, (*distance)?)));
    let (step, metres) = present.min_by(|a, b| a.1.total_cmp(&b.1))?;
    if metres > MAX_DISTANCE {
        return None;
    }
    let nearest = context.encounter(pair.participant, step)?;
    let [ego, other] = [nearest.ego, nearest.other].map(|motion| motion.pose.forward());
    let seconds = (!same_direction(&ego, &other))
        .then(|| (conflict::POST_ENCROACHMENT_TIME.compute)(&nearest).value())
        .flatten();
    // An area that both sweep for long is left and entered far apart.
    let fastest = nearest.ego.velocity.abs().max(nearest.other.velocity.abs());
    let seconds = seconds.map(|seconds| seconds.max(metres / fastest.max(STANDING)));
    let close = match seconds {
        Some(seconds) => seconds.min(metres),
        // Without an area that both sweep, one waited: how near it came counts, if it would have come to contact.
        None if metres <= NEAR_MISS && yielded(pair, step) => metres,
        None => return None,
    };
    let grade = grade(seconds.unwrap_or(f64::INFINITY), metres)?;
    Some((step, grade, close, Hazard::Crossing { seconds, metres }))
}

/// Whether shortly before a step both were on courses along their ways that end in contact.
fn yielded(pair: &PairPaths<'_, '_>, step: i64) -> bool {
    let context = pair.context;
    let before = (YIELDED / context.dt()).ceil() as i64;
    let steps = (step - before).max(context.steps().start)..=step;
    steps.rev().any(|step| {
        let encounter = context.encounter(pair.participant, step);
        encounter.is_some_and(|encounter| {
            let course = super::course::meet(pair.ego, &pair.other, &encounter, step);
            course.is_some_and(|course| course.crosses && course.seconds <= YIELDED)
        })
    })
}

/// Each step at which one of the two comes onto the way of the other, before or behind it.
fn cut_ins(pair: &PairPaths<'_, '_>) -> Vec<Graded> {
    let mut found = Vec::new();
    let mut before = None;
    for step in pair.context.steps() {
        let encounter = pair.context.encounter(pair.participant, step);
        let Some(encounter) = encounter.filter(near_and_along) else {
            before = None;
            continue;
        };
        let (ego, other) = (encounter.ego_placed(), encounter.other_placed());
        let wide = half_width(&ego) + half_width(&other);
        let on = [
            pair.other.aside(&ego.pose.position),
            pair.ego.aside(&other.pose.position),
        ]
        .map(|aside| aside.map(|aside| aside < wide));
        let was: Option<[Option<bool>; 2]> = before.replace(on);
        let comes = |(was, on)| (was, on) == (Some(false), Some(true));
        if !was.is_some_and(|was| was.into_iter().zip(on).any(comes)) {
            continue;
        }
        let metres = encounter.distance();
        let between = other.pose.position - ego.pose.position;
        let behind = if between.dot(&ego.pose.forward()) > 0.0 {
            encounter.ego
        } else {
            encounter.other
        };
        let seconds = metres / behind.velocity.abs();
        if let Some(grade) = grade(seconds, metres) {
            let hazard = Hazard::CutIn { seconds, metres };
            found.push((step, grade, seconds.min(metres), hazard));
        }
    }
    found
}

/// Whether both move the same way, and one could be where the other is soon.
fn near_and_along(encounter: &Encounter<'_>) -> bool {
    let speeds = [encounter.ego, encounter.other].map(|motion| motion.velocity.abs());
    let [ego, other] = [encounter.ego, encounter.other].map(|motion| motion.pose.forward());
    let reachable = encounter.distance() <= LATEST_PASS * speeds[0].max(speeds[1]);
    let moving = speeds.into_iter().all(|speed| speed >= STANDING);
    reachable && moving && same_direction(&ego, &other)
}

/// Half of how wide a body is across its heading, metres.
fn half_width(body: &Placed<'_>) -> f64 {
    let across = body.footprint.corners().iter().map(|corner| corner.y.abs());
    across.fold(0.0, f64::max)
}

fn grade(seconds: f64, metres: f64) -> Option<Grade> {
    match seconds.min(metres) {
        close if close <= NEAR_MISS => Some(Grade::NearMiss),
        _ if seconds <= LATEST_PASS => Some(Grade::Pass),
        _ => None,
    }
}
