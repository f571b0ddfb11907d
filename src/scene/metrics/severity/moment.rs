//! A moment of the ego with an obstacle: what happened, and how severe it is.

use std::cmp::Ordering;
use std::fmt;

/// The hardest braking of road vehicles: gravity at a coefficient of friction of 1, m/s².
const HARDEST: f64 = 9.81;

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
                if *braking <= HARDEST {
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
