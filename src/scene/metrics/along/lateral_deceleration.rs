//! Required lateral acceleration: the smaller of the constant ones with which the ego passes left or right.
//!
//! At the time to collision along the lane t the bodies must be clear across the route: with the way D to the
//! left (or right) that is missing and the lateral velocity v already there, a = 2(D − v·t)/t², 0 where none is
//! needed. A magnitude, whatever the side. Source: Jansson, Collision Avoidance Theory, 2005, section 5.3.8.

use super::super::{Danger, Encounter, Measure, Mirrored, NoValue, Reading};
use super::{Following, lane_ttc};

pub(in crate::metrics) const MEASURE: Measure = Measure {
    id: "a_lat_req",
    name: "required lateral acceleration",
    unit: "m/s²",
    danger: Danger::High,
    mirrored: Mirrored::Kept,
    reads_ahead: false,
    source: "to be clear of the other's side at ttc_lane (Jansson 2005, 5.3.8); a magnitude",
    compute,
};

fn compute(encounter: &Encounter<'_>) -> Reading {
    let following = encounter.ask(|c, other, index| c.following(other, index));
    following.and_then(|f| required(&f)).into()
}

/// The required acceleration, m/s², not negative.
pub(super) fn required(following: &Following) -> Result<f64, NoValue> {
    let time = lane_ttc::time(following)?;
    let (ego, other) = (&following.ego, &following.other);
    let leftward = ego.velocity.y - other.velocity.y;
    let needed = |way: f64, velocity: f64| (2.0 * (way - velocity * time) / (time * time)).max(0.0);
    let left = needed(other.left - ego.right, leftward);
    let right = needed(ego.left - other.right, -leftward);
    Ok(left.min(right))
}
