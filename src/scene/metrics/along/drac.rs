//! Deceleration rate to avoid a crash, of the follower, with the one half.
//!
//! DRAC = ½·Δv² / Δd: constant braking that takes away the closing speed within the headway, the other keeping
//! its speed. Many papers leave out the half and get twice as much. Source: SUMO's device SSM; Almqvist,
//! Hydén and Risser 1991.

use super::super::{Danger, Encounter, Measure, Mirrored, NoValue, Reading};
use super::Following;

pub(in crate::metrics) const MEASURE: Measure = Measure {
    id: "drac",
    name: "deceleration rate to avoid a crash",
    unit: "m/s²",
    danger: Danger::High,
    mirrored: Mirrored::Kept,
    reads_ahead: false,
    source: "½·Δv²/Δd, with the half as in SUMO",
    compute,
};

fn compute(encounter: &Encounter<'_>) -> Reading {
    let following = encounter.ask(|c, other, index| c.following(other, index));
    following.and_then(|f| rate(&f)).into()
}

/// The deceleration, m/s², positive.
pub(super) fn rate(following: &Following) -> Result<f64, NoValue> {
    let closing = following.closing()?;
    Ok(closing * closing / (2.0 * following.gap))
}
