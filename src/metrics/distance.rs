//! Distance: the exact distance between the two bodies, 0 when they touch.

use super::{Encounter, Reading};

/// Metres between the nearest points of the two bodies.
pub(super) fn compute(encounter: &Encounter<'_>) -> Reading {
    Reading::Value(encounter.distance())
}
