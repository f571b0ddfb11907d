//! Headway: the free distance along the lane to the one ahead, from the ego's front to the other's rear.
//!
//! Both ends are those of the real bodies: of a turned box, its corners. Source: Jansson, Collision Avoidance
//! Theory, 2005.

use super::super::{Danger, Encounter, Measure, Mirrored, Reading};

pub(in crate::metrics) const MEASURE: Measure = Measure {
    id: "headway",
    name: "headway",
    unit: "m",
    danger: Danger::Low,
    mirrored: Mirrored::Kept,
    reads_ahead: false,
    source: "gap along the lane, front to rear (Jansson 2005)",
    compute,
};

fn compute(encounter: &Encounter<'_>) -> Reading {
    let following = encounter.ask(|c, other, index| c.following(other, index));
    following.map(|f| f.gap).into()
}
