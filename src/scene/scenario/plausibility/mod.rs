//! Plausibility checks of a scenario, the same for all formats.
//!
//! Readers refuse meaningless values (see [`limits`]). Values that are readable and yet implausible are
//! found here once the scenario is built. A [`Finding`] says which element it is about; only the reader knows
//! where in the file that element is.

mod bodies;
mod header;
mod lanelets;
pub mod limits;
mod lines;
mod links;
mod motion;
mod obstacles;
mod overlaps;
mod problems;
mod times;
mod traffic;

pub use motion::{Row, doubts};
pub use times::missing as missing_steps;

use super::{Scenario, Severity};
use nearmiss_base::geometry::{Bounds, Point};

/// Which element of a scenario; numbers are places in the scenario's lists.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ElementRef {
    /// The root and its attributes.
    Scenario,
    /// The location on Earth.
    Location,
    /// A lanelet.
    Lanelet(usize),
    /// A traffic sign.
    Sign(usize),
    /// A traffic light.
    Light(usize),
    /// An intersection.
    Intersection(usize),
    /// An obstacle.
    Obstacle(usize),
    /// A state of an obstacle, in the order of [`super::Obstacle::states`].
    State {
        /// The obstacle.
        obstacle: usize,
        /// The state.
        state: usize,
    },
    /// The initial state of a planning problem.
    Start(usize),
    /// A goal of a planning problem.
    Goal {
        /// The problem.
        problem: usize,
        /// The goal.
        goal: usize,
    },
}

/// A contradiction or implausibility.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Finding {
    /// How grave it is.
    pub severity: Severity,
    /// What it is about.
    pub about: ElementRef,
    /// The problem, and the assumption made.
    pub message: String,
}

/// Findings so far.
#[derive(Debug, Default)]
struct Findings(Vec<Finding>);

impl Findings {
    fn push(&mut self, severity: Severity, about: ElementRef, message: impl Into<String>) {
        let message = message.into();
        self.0.push(Finding {
            severity,
            about,
            message,
        });
    }

    fn warn(&mut self, about: ElementRef, message: impl Into<String>) {
        self.push(Severity::Warning, about, message);
    }

    fn note(&mut self, about: ElementRef, message: impl Into<String>) {
        self.push(Severity::Note, about, message);
    }
}

/// Everything in a scenario that cannot be true, or hardly.
pub fn check(scenario: &Scenario) -> Vec<Finding> {
    let mut found = Findings::default();
    header::check(scenario, &mut found);
    lanelets::check(&scenario.network, &mut found);
    links::check(&scenario.network, &mut found);
    traffic::check(scenario, &mut found);
    obstacles::check(scenario, &mut found);
    overlaps::check(scenario, &mut found);
    problems::check(scenario, &mut found);
    found.0
}

/// The first of several like things and how many follow it, as in `… (and 3 more)`.
pub fn and_more(first: String, more: usize) -> String {
    match more {
        0 => first,
        more => format!("{first} (and {more} more)"),
    }
}

/// Distance from a point to a box, metres; 0 inside.
fn beyond(bounds: &Bounds, p: &Point) -> f64 {
    bounds.squared_distance(p).sqrt()
}

/// Distance between two boxes, metres; 0 where they meet.
fn apart(a: &Bounds, b: &Bounds) -> f64 {
    let x = (a.min.x - b.max.x).max(b.min.x - a.max.x).max(0.0);
    let y = (a.min.y - b.max.y).max(b.min.y - a.max.y).max(0.0);
    x.hypot(y)
}
