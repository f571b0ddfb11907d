//! Steer-threat number: the required lateral acceleration over the available one.
//!
//! STN = a_lat_req / a_lat,max, with a_lat,max the limit `steer_threat`; from 1 on steering alone does not help.
//! Source: Hosseini, Murgovski, de Campos and Sjöberg 2016.

use super::super::{Danger, Encounter, Measure, Mirrored, Reading};
use super::lateral_deceleration::required;

pub(in crate::metrics) const MEASURE: Measure = Measure {
    id: "stn",
    name: "steer-threat number",
    unit: "",
    danger: Danger::High,
    mirrored: Mirrored::Kept,
    reads_ahead: false,
    source: "a_lat_req over steer_threat (Hosseini 2016)",
    compute,
};

fn compute(encounter: &Encounter<'_>) -> Reading {
    let following = encounter.ask(|c, other, index| c.following(other, index));
    following
        .and_then(|f| Ok(required(&f)? / encounter.thresholds().limits.steer_threat))
        .into()
}
