//! Brake-threat number: the required longitudinal deceleration over the available one.
//!
//! BTN = a_long_req / −a_max, with a_max the limit `brake_threat`; from 1 on braking alone does not help. Source:
//! Åsljung, Nilsson and Fredriksson 2017.

use super::super::{Danger, Encounter, Measure, Mirrored, Reading};
use super::longitudinal_deceleration::required;

pub(in crate::metrics) const MEASURE: Measure = Measure {
    id: "btn",
    name: "brake-threat number",
    unit: "",
    danger: Danger::High,
    mirrored: Mirrored::Kept,
    reads_ahead: false,
    source: "a_long_req over −brake_threat (Åsljung 2017)",
    compute,
};

fn compute(encounter: &Encounter<'_>) -> Reading {
    let following = encounter.ask(|c, other, index| c.following(other, index));
    let number =
        following.and_then(|f| Ok(required(&f)? / -encounter.thresholds().limits.brake_threat));
    // Without a sign where nothing is required.
    number.map(|n| n + 0.0).into()
}
