//! Required longitudinal acceleration: the constant one with which the ego just does not reach the other.
//!
//! a = min(a_other − Δv² / (2Δd), 0), while it closes in; negative is braking. The other's acceleration is
//! taken to last. Source: Jansson, Collision Avoidance Theory, 2005, section 5.3.5.

use super::super::{Danger, Encounter, Measure, Mirrored, NoValue, Reading};
use super::Following;

pub(in crate::metrics) const MEASURE: Measure = Measure {
    id: "a_long_req",
    name: "required longitudinal acceleration",
    unit: "m/s²",
    danger: Danger::Low,
    mirrored: Mirrored::Kept,
    reads_ahead: false,
    source: "a_other − Δv²/(2Δd), at most 0 (Jansson 2005, 5.3.5); negative is braking",
    compute,
};

fn compute(encounter: &Encounter<'_>) -> Reading {
    let following = encounter.ask(|c, other, index| c.following(other, index));
    following.and_then(|f| required(&f)).into()
}

/// The required acceleration, m/s², not positive.
pub(super) fn required(following: &Following) -> Result<f64, NoValue> {
    let closing = following.closing()?;
    Ok((following.other.acceleration - closing * closing / (2.0 * following.gap)).min(0.0))
}
