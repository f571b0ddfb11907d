//! Checks the root of a scenario: its time step and its place on Earth.

use super::limits::LONG_TIME_STEP;
use super::{ElementRef, Findings};
use crate::scenario::Scenario;

/// The value that files write for unknown degrees.
const UNKNOWN_DEGREES: f64 = 999.0;

pub(super) fn check(scenario: &Scenario, found: &mut Findings) {
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
