//! Distance of the closest encounter: the smallest distance of the recorded bodies from now on.
//!
//! At a step; 0 where the bodies touch, also between two steps. At the first step it is the minimum distance of the whole recording (MDC). Source: Eggert
//! 2014 (DCE).

use super::super::{Danger, Encounter, Measure, Mirrored, NoValue, Reading};

pub(in crate::metrics) const MEASURE: Measure = Measure {
    id: "dce",
    name: "distance of the closest encounter",
    unit: "m",
    danger: Danger::Low,
    mirrored: Mirrored::Kept,
    reads_ahead: true,
    source: "smallest recorded distance from now on (Eggert 2014)",
    compute,
};

fn compute(encounter: &Encounter<'_>) -> Reading {
    let closest = encounter.ask(|c, other, i| c.closest(other, i).ok_or(NoValue::Absent));
    closest.map(|c| c.distance).into()
}
