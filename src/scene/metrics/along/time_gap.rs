//! Time gap: the headway over the ego's speed along the lane.
//!
//! t = Δs / ṡ_ego: the time in which the ego gets to where the other's rear is now, at its present speed.
//! Source: SUMO's device SSM (TGAP).

use super::super::{Danger, Encounter, Measure, Mirrored, NoValue, Reading};

pub(in crate::metrics) const MEASURE: Measure = Measure {
    id: "time_gap",
    name: "time gap",
    unit: "s",
    danger: Danger::Low,
    mirrored: Mirrored::Kept,
    reads_ahead: false,
    source: "headway over the ego's speed (TGAP of SUMO)",
    compute,
};

/// Slower than this a vehicle stands, m/s.
const SLOWEST: f64 = 0.1;

fn compute(encounter: &Encounter<'_>) -> Reading {
    let following = encounter.ask(|c, other, index| c.following(other, index));
    let gap = following.and_then(|f| {
        let speed = f.ego.velocity.x;
        if speed < SLOWEST {
            Err(NoValue::Standing)
        } else {
            Ok(f.gap / speed)
        }
    });
    gap.into()
}
