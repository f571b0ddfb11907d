//! Squared distance: that of the bodies, in square metres.

use super::{Danger, Encounter, Measure, Mirrored, Reading};

pub(super) const MEASURE: Measure = Measure {
    id: "distance_squared",
    name: "squared distance",
    unit: "m²",
    danger: Danger::Low,
    mirrored: Mirrored::Kept,
    reads_ahead: false,
    source: "the distance of the bodies, squared",
    compute,
};

fn compute(encounter: &Encounter<'_>) -> Reading {
    Reading::Value(encounter.distance().powi(2))
}
