//! One sampled trajectory: its cost, or why it was rejected.

use super::Limit;
use super::lateral::Lateral;

/// Why a candidate is not driven.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Rejection {
    /// The vehicle cannot do it.
    Limit(Limit),
    /// It is inside the path's curve, where no offset is defined.
    InsideCurve,
    /// The body would leave the road.
    OffRoad,
    /// It would touch the predicted body of this obstacle.
    Contact(i64),
    /// Another one costs less than this one up to here; see [`Planner::only_best`](super::Planner::only_best).
    Costlier,
}

impl Rejection {
    /// In a word or two, the same for all obstacles.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Limit(limit) => limit.name(),
            Self::InsideCurve => "inside the curve",
            Self::OffRoad => "off the road",
            Self::Contact(_) => "contact",
            Self::Costlier => "costlier",
        }
    }
}

/// The terms of the cost, each with its weight already.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Cost {
    /// Jerk along and across the path.
    pub jerk: f64,
    /// Acceleration.
    pub acceleration: f64,
    /// Difference from the wanted speed.
    pub speed: f64,
    /// Distance to the path.
    pub offset: f64,
    /// Closeness to others.
    pub clearance: f64,
    /// Too close behind an obstacle.
    pub following: f64,
    /// Contacts that are possible, not likely.
    pub risk: f64,
    /// Faster than the rules of the road allow.
    pub rules: f64,
}

impl Cost {
    /// All terms with their names, in the order of the fields.
    #[must_use]
    pub fn terms(&self) -> [(&'static str, f64); 8] {
        [
            ("jerk", self.jerk),
            ("acceleration", self.acceleration),
            ("speed", self.speed),
            ("offset", self.offset),
            ("clearance", self.clearance),
            ("following", self.following),
            ("risk", self.risk),
            ("rules", self.rules),
        ]
    }

    /// Their sum.
    #[must_use]
    pub fn total(&self) -> f64 {
        self.terms().iter().map(|(_, value)| value).sum()
    }
}

/// A sampled trajectory.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate {
    /// Which of the plan's profiles it follows.
    pub(super) profile: usize,
    pub(super) lateral: Lateral,
    /// What it costs, up to where it was rejected.
    pub cost: Cost,
    /// Step (from now) and reason of its end; `None` for one that can be driven.
    pub rejected: Option<(usize, Rejection)>,
}
