//! Time integrated time to collision: by how much, from now to the end of the recording, it is too short.
//!
//! TIT = Σ dt·(τ − TTC) over the steps with TTC < τ, with the time to collision along the lane and τ the limit `tau`.
//! Source: Minderhoud and Bovy 2001.

use super::super::{Danger, Encounter, Measure, Mirrored, Reading};

pub(in crate::metrics) const MEASURE: Measure = Measure {
    id: "tit",
    name: "time integrated time to collision",
    unit: "s²",
    danger: Danger::High,
    mirrored: Mirrored::Kept,
    reads_ahead: true,
    source: "tau minus ttc_lane, integrated from now on (Minderhoud and Bovy 2001)",
    compute,
};

fn compute(encounter: &Encounter<'_>) -> Reading {
    let exposure = encounter.ask(|c, other, index| c.exposure(other, index));
    exposure.map(|e| e.integrated).into()
}
