//! Time exposed time to collision: how long, from now to the end of the recording, it is too short.
//!
//! TET = Σ dt·[TTC < τ] with the time to collision along the lane and τ the limit `tau`. Steps at which the bodies
//! overlap along the lane have none and do not count. Source: Minderhoud and Bovy 2001.

use super::super::{Danger, Encounter, Measure, Mirrored, Reading};

pub(in crate::metrics) const MEASURE: Measure = Measure {
    id: "tet",
    name: "time exposed time to collision",
    unit: "s",
    danger: Danger::High,
    mirrored: Mirrored::Kept,
    reads_ahead: true,
    source: "time with ttc_lane below tau, from now on (Minderhoud and Bovy 2001)",
    compute,
};

fn compute(encounter: &Encounter<'_>) -> Reading {
    let exposure = encounter.ask(|c, other, index| c.exposure(other, index));
    exposure.map(|e| e.exposed).into()
}
