//! Recorded time to collision, TTC*: the time until the recorded bodies first overlap.
//!
//! At a step or between two: 0 while they overlap. Unlike `ttc` it predicts nothing. Source: the TTC* of CommonRoad-CriMe (Lin and Althoff 2023).

use super::super::{Danger, Encounter, Measure, Mirrored, NoValue, Reading};

pub(in crate::metrics) const MEASURE: Measure = Measure {
    id: "ttc_star",
    name: "time to the recorded overlap",
    unit: "s",
    danger: Danger::Low,
    mirrored: Mirrored::Kept,
    reads_ahead: true,
    source: "recorded time until the bodies overlap (TTC* of CriMe)",
    compute,
};

fn compute(encounter: &Encounter<'_>) -> Reading {
    let time = encounter.ask(|c, other, i| {
        let closest = c.closest(other, i).ok_or(NoValue::Absent)?;
        let contact = closest.contact.ok_or(NoValue::NoRecordedOverlap)?;
        Ok(c.time(i, contact))
    });
    time.into()
}
