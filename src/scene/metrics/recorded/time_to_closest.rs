//! Time to the closest encounter: when the recorded bodies are at their smallest distance from now on.
//!
//! At a step, or where the bodies touch between two; the first of several moments alike. Source: Eggert 2014 (TTCE).

use super::super::{Danger, Encounter, Measure, Mirrored, NoValue, Reading};

pub(in crate::metrics) const MEASURE: Measure = Measure {
    id: "ttce",
    name: "time to the closest encounter",
    unit: "s",
    danger: Danger::Low,
    mirrored: Mirrored::Kept,
    reads_ahead: true,
    source: "recorded time until dce (Eggert 2014)",
    compute,
};

fn compute(encounter: &Encounter<'_>) -> Reading {
    let time = encounter.ask(|c, other, i| {
        let closest = c.closest(other, i).ok_or(NoValue::Absent)?;
        Ok(c.time(i, closest.at))
    });
    time.into()
}
