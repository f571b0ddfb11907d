//! Plausibility checks of a scenario, the same for all formats.
//!
//! Readers refuse meaningless values (see [`limits`]). Values that are readable and yet implausible are
//! found here once the scenario is built. A [`Finding`] says which element it is about; only the reader knows
//! where in the file that element is.

mod lanelets;
pub mod limits;
mod motion;
mod network;
mod obstacles;
mod problems;

use nearmiss_base::geometry::{Bounds, Point};

use super::{Scenario, Severity};
use limits::LONG_TIME_STEP;

pub use motion::{Row, doubts, missing as missing_steps};

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
    check_header(scenario, &mut found);
    lanelets::check(&scenario.network, &mut found);
    network::check_links(&scenario.network, &mut found);
    network::check_traffic(scenario, &mut found);
    obstacles::check(scenario, &mut found);
    obstacles::check_overlaps(scenario, &mut found);
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
fn gap(a: &Bounds, b: &Bounds) -> f64 {
    let x = (a.min.x - b.max.x).max(b.min.x - a.max.x).max(0.0);
    let y = (a.min.y - b.max.y).max(b.min.y - a.max.y).max(0.0);
    x.hypot(y)
}

/// The value that files write for unknown degrees.
const UNKNOWN_DEGREES: f64 = 999.0;

fn check_header(scenario: &Scenario, found: &mut Findings) {
    let dt = scenario.dt();
    if dt > LONG_TIME_STEP {
        found.warn(
            ElementRef::Scenario,
            format!(
                "a time step of {dt} s is unusually long; between steps, all are taken to go straight and evenly"
            ),
        );
    }
    let Some(location) = &scenario.location else {
        return;
    };
    for (name, degrees, most) in [
        ("latitude", location.latitude, 90.0),
        ("longitude", location.longitude, 180.0),
    ] {
        let absurd =
            degrees.filter(|d| d.is_nan() || (d.abs() > most && d.abs() != UNKNOWN_DEGREES));
        if let Some(degrees) = absurd {
            found.warn(
                ElementRef::Location,
                format!("a {name} of {degrees}° is not on Earth"),
            );
        }
    }
    let transformation = location.transformation.as_ref();
    let scaling = transformation.and_then(|t| t.scaling);
    if let Some(scaling) = scaling.filter(|s| *s <= 0.0) {
        found.warn(
            ElementRef::Location,
            format!("the map scale {scaling} is implausible"),
        );
    }
}
