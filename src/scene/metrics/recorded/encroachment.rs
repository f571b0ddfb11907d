//! Encroachment time: how long the ego's body is in the conflict area, as recorded.
//!
//! The conflict area is all places that both bodies sweep in their whole recordings; the time runs from when the
//! ego first touches it to when it last does, at a step or between two, where it goes evenly. One value for
//! the pair, the same at every step. Source: Allen, Shin and Cooper 1978.

use super::super::{Danger, Encounter, Measure, Mirrored, Reading};

pub(in crate::metrics) const MEASURE: Measure = Measure {
    id: "et",
    name: "encroachment time",
    unit: "s",
    danger: Danger::High,
    mirrored: Mirrored::Kept,
    reads_ahead: true,
    source: "time of the ego in the area that both bodies sweep (Allen 1978)",
    compute,
};

fn compute(encounter: &Encounter<'_>) -> Reading {
    let time = encounter.ask(|c, other, _| Ok(c.conflict(other).encroachment()? * c.dt()));
    time.into()
}
