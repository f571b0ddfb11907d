//! Distance: the exact distance between the two bodies, 0 when they touch.

use super::{Danger, Encounter, Measure, Mirrored, Reading};

pub(super) const MEASURE: Measure = Measure {
    id: "distance",
    name: "distance",
    unit: "m",
    danger: Danger::Low,
    mirrored: Mirrored::Kept,
    reads_ahead: false,
    source: "exact distance of the bodies (GJK, parry)",
    compute,
};

/// Metres between the nearest points of the two bodies.
fn compute(encounter: &Encounter<'_>) -> Reading {
    Reading::Value(encounter.distance())
}
