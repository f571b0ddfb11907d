//! Plausibility checks of a scenario, the same for all formats.
//!
//! Readers refuse meaningless values (see [`limits`]). Values that are readable and yet implausible are
//! found here once the scenario is built. A [`Finding`] says which element it is about; only the reader knows
//! where in the file that element is.

mod bodies;
mod header;
mod lanelets;
pub(crate) mod limits;
mod lines;
mod links;
mod motion;
mod obstacles;
mod overlaps;
mod problems;
mod times;
mod traffic;

pub(crate) use motion::{Row, doubts};
pub(crate) use times::missing as missing_steps;

use super::{Scenario, Severity};
use crate::geometry::{Bounds, Point};

/// Which element of a scenario; numbers are places in the scenario's lists.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum ElementRef {
    /// The root and its attributes.
    Scenario,
    /// The location on Earth.
    Location,
    Lanelet(usize),
    Sign(usize),
    Light(usize),
    Intersection(usize),
    Obstacle(usize),
    /// A state of an obstacle, in the order of [`super::Obstacle::states`].
    State {
        obstacle: usize,
        state: usize,
    },
    /// The initial state of a planning problem.
    Start(usize),
    Goal {
        problem: usize,
        goal: usize,
    },
}

/// A contradiction or implausibility.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Finding {
    pub severity: Severity,
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
pub(crate) fn check(scenario: &Scenario) -> Vec<Finding> {
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
pub(crate) fn and_more(first: String, more: usize) -> String {
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
