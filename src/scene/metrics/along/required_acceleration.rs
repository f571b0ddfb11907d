//! The smallest accelerations with which the ego just does not touch the one ahead, and what is left of the available.
//!
//! At the time to collision along the lane t the bodies must be clear across the route: with the way D to the
//! left (or right) that is missing and the lateral velocity v already there, a = 2(D − v·t)/t², 0 where none is
//! needed. A magnitude, whatever the side. Source: Jansson, Collision Avoidance Theory, 2005, section 5.3.8.
//!
//! Steer-threat number: the required lateral acceleration over the available one.
//!
//! STN = a_lat_req / a_lat,max, with a_lat,max the limit `steer_threat`; from 1 on steering alone does not help.
//! Source: Hosseini, Murgovski, de Campos and Sjöberg 2016.
//!
//! Required longitudinal acceleration: the constant one with which the ego just does not reach the other.
//!
//! a = min(a_other − Δv² / (2Δd), 0), while it closes in; negative is braking. The other's acceleration is
//! taken to last. Source: Jansson, Collision Avoidance Theory, 2005, section 5.3.5.
//!
//! Brake-threat number: the required longitudinal deceleration over the available one.
//!
//! BTN = a_long_req / −a_max, with a_max the limit `brake_threat`; from 1 on braking alone does not help. Source:
//! Åsljung, Nilsson and Fredriksson 2017.

use super::super::{Danger, Encounter, Measure, Mirrored, NoValue, Reading};
use super::{Following, following};

pub(in crate::metrics) const LATERAL_ACCELERATION: Measure = Measure {
    id: "a_lat_req",
    name: "required lateral acceleration",
    unit: "m/s²",
    danger: Danger::High,
    mirrored: Mirrored::Kept,
    reads_ahead: false,
    source: "to be clear of the other's side at ttc_lane (Jansson 2005, 5.3.8); a magnitude",
    compute: lateral_acceleration,
};

fn lateral_acceleration(encounter: &Encounter<'_>) -> Reading {
    let following = encounter.ask(|c, other, index| c.following(other, index));
    following
        .and_then(|f| lateral_acceleration_required(&f))
        .into()
}

/// The required acceleration, m/s², not negative.
pub(super) fn lateral_acceleration_required(following: &Following) -> Result<f64, NoValue> {
    let time = following::lane_time_to_collision(following)?;
    let (ego, other) = (&following.ego, &following.other);
    let leftward = ego.velocity.y - other.velocity.y;
    let needed = |way: f64, velocity: f64| (2.0 * (way - velocity * time) / (time * time)).max(0.0);
    let left = needed(other.left - ego.right, leftward);
    let right = needed(ego.left - other.right, -leftward);
    Ok(left.min(right))
}

pub(in crate::metrics) const STEER_THREAT: Measure = Measure {
    id: "stn",
    name: "steer-threat number",
    unit: "",
    danger: Danger::High,
    mirrored: Mirrored::Kept,
    reads_ahead: false,
    source: "a_lat_req over steer_threat (Hosseini 2016)",
    compute: steer_threat,
};

fn steer_threat(encounter: &Encounter<'_>) -> Reading {
    let following = encounter.ask(|c, other, index| c.following(other, index));
    following
        .and_then(|f| {
            Ok(lateral_acceleration_required(&f)? / encounter.thresholds().limits.steer_threat)
        })
        .into()
}

pub(in crate::metrics) const LONGITUDINAL_ACCELERATION: Measure = Measure {
    id: "a_long_req",
    name: "required longitudinal acceleration",
    unit: "m/s²",
    danger: Danger::Low,
    mirrored: Mirrored::Kept,
    reads_ahead: false,
    source: "a_other − Δv²/(2Δd), at most 0 (Jansson 2005, 5.3.5); negative is braking",
    compute: longitudinal_acceleration,
};

fn longitudinal_acceleration(encounter: &Encounter<'_>) -> Reading {
    let following = encounter.ask(|c, other, index| c.following(other, index));
    following
        .and_then(|f| longitudinal_acceleration_required(&f))
        .into()
}

/// The required acceleration, m/s², not positive.
pub(super) fn longitudinal_acceleration_required(following: &Following) -> Result<f64, NoValue> {
    let closing = following.closing()?;
    Ok((following.other.acceleration - closing * closing / (2.0 * following.gap)).min(0.0))
}

pub(in crate::metrics) const BRAKE_THREAT: Measure = Measure {
    id: "btn",
    name: "brake-threat number",
    unit: "",
    danger: Danger::High,
    mirrored: Mirrored::Kept,
    reads_ahead: false,
    source: "a_long_req over −brake_threat (Åsljung 2017)",
    compute: brake_threat,
};

fn brake_threat(encounter: &Encounter<'_>) -> Reading {
    let following = encounter.ask(|c, other, index| c.following(other, index));
    let number = following.and_then(|f| {
        Ok(longitudinal_acceleration_required(&f)? / -encounter.thresholds().limits.brake_threat)
    });
    // Without a sign where nothing is required.
    number.map(|n| n + 0.0).into()
}
