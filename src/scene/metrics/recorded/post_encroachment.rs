//! Post-encroachment time: from one leaving the conflict area to the other entering it, as recorded.
//!
//! PET = t_entry(second) − t_exit(first), whichever is first. The conflict area is all places that both bodies sweep
//! in their whole recordings; exit is when a body last touches it and entry when it first does, at a step or between
//! two, where bodies go evenly. One value for the pair, the same at every step; who follows another has none, as both
//! are in it together. Source: Allen, Shin and Cooper 1978.

use super::super::{Danger, Encounter, Measure, Mirrored, Reading};

pub(in crate::metrics) const MEASURE: Measure = Measure {
    id: "pet",
    name: "post-encroachment time",
    unit: "s",
    danger: Danger::Low,
    mirrored: Mirrored::Kept,
    reads_ahead: true,
    source: "between leaving and entering the area that both bodies sweep (Allen 1978)",
    compute,
};

fn compute(encounter: &Encounter<'_>) -> Reading {
    let time = encounter.ask(|c, other, _| Ok(c.conflict(other).post_encroachment()? * c.dt()));
    time.into()
}
