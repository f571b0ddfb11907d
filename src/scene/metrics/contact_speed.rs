//! Closing speed at contact: how fast one body moves relative to the other when they first touch.
//!
//! The length of the difference of both velocities at the first contact of the recording, at a step or between two, as
//! recorded; between two steps velocities change evenly. It measures how severe a collision is: with the masses it gives
//! the change of velocity delta-v of each. One value for the pair, the same at every step. Source: Shelby, Delta-V as a
//! measure of traffic conflict severity, 2011; Laureshyn et al., In search of the severity dimension of traffic events,
//! 2017.

use super::{Danger, Encounter, Measure, Mirrored, NoValue, Reading};

pub(super) const MEASURE: Measure = Measure {
    id: "contact_speed",
    name: "closing speed at contact",
    unit: "m/s",
    danger: Danger::High,
    mirrored: Mirrored::Kept,
    reads_ahead: true,
    source: "relative speed at the first recorded contact (Shelby 2011)",
    compute,
};

fn compute(encounter: &Encounter<'_>) -> Reading {
    let speed = encounter.ask(|context, other, _| {
        let first = context.contacts(other).first();
        first.map(|c| c.closing_speed).ok_or(NoValue::NeverTouched)
    });
    speed.into()
}
