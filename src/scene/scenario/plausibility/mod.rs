//! Plausibility checks of a scenario, the same for all formats, and the bounds beyond which quantities are reported or errors.
//!
//! Readers refuse meaningless values (see the bounds below). Values that are readable and yet implausible are
//! found here once the scenario is built. A [`Finding`] says which element it is about; only the reader knows
//! where in the file that element is.

mod lanelets;
mod motion;
mod network;
mod obstacles;
mod problems;

pub use motion::{Row, doubts, missing as missing_steps};

use std::f64::consts::{PI, TAU};

use nearmiss_base::geometry::{Bounds, Point};

use super::{Scenario, Severity};
use crate::scenario::{Quantity, StateField};

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

/// The shortest and the longest time step that is read, seconds.
const TIME_STEPS: (f64, f64) = (0.001, 10.0);

/// Longer time steps are unusual, seconds.
const LONG_TIME_STEP: f64 = 1.0;

/// Later or earlier time steps are a mistake in the file.
pub const LATEST_STEP: i64 = 10_000_000;

/// Coordinates of no map projection are larger, metres: half the equator is 20,038 km long.
pub const LARGEST_COORDINATE: f64 = 2.5e7;

/// No quantity of a scenario is larger, whatever its unit.
pub const LARGEST_NUMBER: f64 = 1e9;

/// No shape is larger, metres.
const LARGEST_SHAPE: f64 = 1e5;

/// More points, states or members than this are not read.
pub const MOST_PARTS: usize = 1_000_000;

/// No measured value other than 0 is nearer to 0.
const SMALLEST_NUMBER: f64 = 1e-100;

/// No road user is faster, m/s.
pub const FASTEST: f64 = 100.0;

/// No vehicle reverses faster, m/s.
const FASTEST_BACKWARDS: f64 = 20.0;

/// Headings beyond this many turns look like degrees.
pub const MOST_TURNS: f64 = 3.0;

/// Why a time step of `seconds` is refused; `None` if it is valid.
pub fn refused_time_step(seconds: f64) -> Option<String> {
    let (shortest, longest) = TIME_STEPS;
    if seconds.is_nan() || seconds <= 0.0 {
        return Some("is not a positive number of seconds".into());
    }
    (!(shortest..=longest).contains(&seconds)).then(|| {
        format!(
            "is out of range: {shortest} s to {longest} s are supported; is it in another unit?"
        )
    })
}

/// Why a coordinate is refused; `None` if it is valid.
pub fn refused_coordinate(metres: f64) -> Option<String> {
    (metres.abs() > LARGEST_COORDINATE).then(|| {
        format!(
            "`{metres}` is implausible: coordinates are limited to ±{:.0} km",
            LARGEST_COORDINATE / 1e3
        )
    })
}

/// Why a length, width or radius is refused; `None` if it is valid.
pub fn refused_size(metres: f64) -> Option<String> {
    (metres.abs() > LARGEST_SHAPE).then(|| {
        format!(
            "`{metres}` is implausible: shapes are limited to {:.0} km",
            LARGEST_SHAPE / 1e3
        )
    })
}

/// The diagnostic for a number smaller than any measured one, if it is one.
pub fn is_tiny(value: f64) -> bool {
    value != 0.0 && value.abs() < SMALLEST_NUMBER
}

/// Why a quantity of a state is implausible, with its value; `None` if it is plausible.
pub fn doubtful(field: StateField, quantity: Quantity) -> Option<String> {
    let (from, to) = match quantity {
        Quantity::Exact(value) => (value, value),
        Quantity::Interval(from, to) => (from, to),
    };
    let value = if from.abs() > to.abs() { from } else { to };
    let (most, unit) = most(field)?;
    if value.abs() > most {
        let name = field.name();
        return Some(match field {
            StateField::Orientation => format!(
                "heading {value}, read as radians, is more than {MOST_TURNS} turns; is it in degrees?"
            ),
            _ => {
                let digits = if most.fract() == 0.0 { 0 } else { 2 };
                format!("{name} is {value} {unit}; no road user exceeds {most:.digits$} {unit}")
            }
        });
    }
    let backwards = field == StateField::Velocity && from < -FASTEST_BACKWARDS;
    backwards.then(|| format!("drives backwards at {} m/s", -from))
}

/// The largest magnitude that a quantity can have, and its unit; `None` if anything is possible.
fn most(field: StateField) -> Option<(f64, &'static str)> {
    use StateField as F;
    Some(match field {
        F::Orientation => (MOST_TURNS * TAU, "rad"),
        F::Velocity | F::VelocityY | F::VelocityYFront | F::VelocityYRear => (FASTEST, "m/s"),
        F::VelocityZ | F::VelocityZFront | F::VelocityZRear => (FASTEST, "m/s"),
        F::Acceleration | F::AccelerationY => (50.0, "m/s²"),
        F::YawRate | F::RollRate | F::PitchRate | F::RollRateFront | F::RollRateRear => {
            (20.0, "rad/s")
        }
        F::SlipAngle | F::HitchAngle => (PI, "rad"),
        F::SteeringAngle | F::RollAngle | F::PitchAngle | F::RollAngleFront | F::RollAngleRear => {
            (PI / 2.0, "rad")
        }
        F::SteeringAngleSpeed => (20.0, "rad/s"),
        F::PositionZ | F::PositionZFront | F::PositionZRear => (1e4, "m"),
        F::LeftFrontWheelAngularSpeed
        | F::RightFrontWheelAngularSpeed
        | F::LeftRearWheelAngularSpeed
        | F::RightRearWheelAngularSpeed
        | F::FrontWheelAngularSpeed
        | F::RearWheelAngularSpeed => (1e3, "rad/s"),
        F::DeltaYFront | F::DeltaYRear => (10.0, "m"),
        F::Curvature => (10.0, "1/m"),
        F::Jerk => (1e4, "m/s³"),
        F::LongitudinalPosition | F::LateralPosition => (1e6, "m"),
        F::CurvatureChange | F::CurvatureRate | F::Jounce | F::JerkDot | F::KappaDotDot => {
            return None;
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_steps_have_a_range() {
        for fine in [0.001, 0.04, 0.1, 1.0, 10.0] {
            assert_eq!(refused_time_step(fine), None, "{fine}");
        }
        for absurd in [
            0.0,
            -0.1,
            1e-6,
            9.9e-4,
            10.1,
            1e9,
            f64::NAN,
            f64::INFINITY,
            1e-320,
        ] {
            assert!(refused_time_step(absurd).is_some(), "{absurd}");
        }
    }

    #[test]
    fn each_quantity_has_its_own_limit() {
        let doubt = |field, value| doubtful(field, Quantity::Exact(value));
        assert_eq!(doubt(StateField::Orientation, -4.7), None);
        assert!(doubt(StateField::Orientation, 90.0).is_some_and(|said| said.contains("degrees")));
        assert_eq!(doubt(StateField::Velocity, 60.0), None);
        assert_eq!(doubt(StateField::Velocity, -3.0), None);
        assert!(
            doubt(StateField::Velocity, -45.0).is_some_and(|said| said.contains("backwards at 45"))
        );
        assert!(doubt(StateField::SteeringAngle, 30.0).is_some());
        let wide = Quantity::Interval(-400.0, 3.0);
        assert!(doubtful(StateField::Velocity, wide).is_some_and(|said| said.contains("-400")));
    }
}
