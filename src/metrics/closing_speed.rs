//! Closing speed: how fast the two bodies approach each other.

use super::{Danger, Encounter, Measure, Mirrored, Reading};

pub(super) const MEASURE: Measure = Measure {
    id: "closing_speed",
    name: "closing speed",
    unit: "m/s",
    danger: Danger::High,
    mirrored: Mirrored::Kept,
    source: "rate at which the distance of the centres falls",
    compute,
};

/// Metres a second at which the centres approach each other.
fn compute(encounter: &Encounter<'_>) -> Reading {
    Reading::Value(encounter.distance())
}
