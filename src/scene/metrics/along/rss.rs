//! Safe distances of responsibility-sensitive safety, and how much more there is.
//!
//! Same direction, of the rear vehicle r and the front vehicle f (definition 1 and lemma 2):
//! d = [v_r·ρ + ½·a·ρ² + (v_r + ρ·a)²/(2·b_min) − v_f²/(2·b_max)]₊. Opposite directions (definition 2):
//! both accelerate for ρ and brake, the one in its lane with b_min,correct, the other with b_min.
//! The ego is the one in its lane. Source: Shalev-Shwartz, Shammah and Shashua, On a Formal Model of Safe and
//! Scalable Self-driving Cars, 2017. Who is in front is told by the positions along the ego's route, whatever
//! the lane: RSS calls a situation dangerous where the lateral distance is too short as well, see `rss_margin`.
//!
//! Lateral safe distance of responsibility-sensitive safety, and how much more there is.
//!
//! With v₁ the velocity to the right of the left one and v₂ that to the left of the right one, which grow
//! by ρ·a during the response time: d = μ + [w(v₁) + w(v₂)]₊, w(v) = (v + v_ρ)/2·ρ + v_ρ²/(2·b) towards the
//! other, v_ρ = v + ρ·a; where v_ρ is negative it drives away, and brakes that too. Source: Shalev-Shwartz,
//! Shammah and Shashua, On a Formal Model of Safe and Scalable Self-driving Cars, 2017, definition 6 and lemma 4.
//!
//! Joint margin of responsibility-sensitive safety: how much more room there is than both safe distances ask for.
//!
//! The larger of the longitudinal and the lateral margin. RSS calls a situation dangerous only while both distances
//! are shorter than the safe ones, so this is negative then and only then. Source: Shalev-Shwartz, Shammah and
//! Shashua, On a Formal Model of Safe and Scalable Self-driving Cars, 2017.

use super::super::{Danger, Encounter, Measure, Reading};
use super::LaneBody;
use crate::metrics::limits::Rss;

/// What follows from both bodies along the ego's route.
fn of_lanes(encounter: &Encounter<'_>, value: fn(&LaneBody, &LaneBody, &Rss) -> f64) -> Reading {
    let found = encounter.ask(|c, other, i| {
        let (ego, other) = (c.ego_along(i)?, c.along(other, i)?);
        Ok(value(&ego, &other, &c.limits().rss))
    });
    found.into()
}

pub(in crate::metrics) const LONGITUDINAL_DISTANCE: Measure = Measure::new(
    "rss_long",
    "RSS safe distance, longitudinal",
    "m",
    Danger::High,
    "Shalev-Shwartz et al. 2017, definitions 1 and 2, along the ego's route",
    |e| of_lanes(e, longitudinal_distance),
);

pub(in crate::metrics) const LONGITUDINAL_MARGIN: Measure = Measure::new(
    "rss_long_margin",
    "RSS margin, longitudinal",
    "m",
    Danger::Low,
    "gap along the route minus rss_long; see rss_margin",
    |e| of_lanes(e, longitudinal_margin),
);

/// The longitudinal gap minus the safe distance, metres.
pub(super) fn longitudinal_margin(ego: &LaneBody, other: &LaneBody, rss: &Rss) -> f64 {
    let gap = (other.rear - ego.front)
        .max(ego.rear - other.front)
        .max(0.0);
    gap - longitudinal_distance(ego, other, rss)
}

/// The safe distance, metres.
fn longitudinal_distance(ego: &LaneBody, other: &LaneBody, rss: &Rss) -> f64 {
    let ego_behind = ego.at.s <= other.at.s;
    let (rear, front) = if ego_behind {
        (ego, other)
    } else {
        (other, ego)
    };
    let (rear, front) = (rear.velocity.x, front.velocity.x);
    if rear < 0.0 && front < 0.0 {
        // Both drive against the route: the one in front of the other is behind along it.
        return same_direction(-front, -rear, rss);
    }
    if front >= 0.0 {
        return same_direction(rear, front, rss);
    }
    let (of_rear, of_front) = if ego_behind {
        (rss.brake_correct, rss.brake_least)
    } else {
        (rss.brake_least, rss.brake_correct)
    };
    (stopping(rear, of_rear, rss) + stopping(-front, of_front, rss)).max(0.0)
}

fn same_direction(rear: f64, front: f64, rss: &Rss) -> f64 {
    (stopping(rear, rss.brake_least, rss) - front * front / (2.0 * rss.brake_most)).max(0.0)
}

/// Distance covered towards the other, metres: accelerating for the response time, then braking. A participant that
/// drives away is taken to stand after the response time.
fn stopping(velocity: f64, brake: f64, rss: &Rss) -> f64 {
    let after = (velocity + rss.response * rss.accelerate).max(0.0);
    velocity * rss.response
        + rss.accelerate * rss.response * rss.response / 2.0
        + after * after / (2.0 * brake)
}

pub(in crate::metrics) const LATERAL_DISTANCE: Measure = Measure::new(
    "rss_lat",
    "RSS safe distance, lateral",
    "m",
    Danger::High,
    "Shalev-Shwartz et al. 2017, definition 6, across the ego's route",
    |e| of_lanes(e, lateral_distance),
);

pub(in crate::metrics) const LATERAL_MARGIN: Measure = Measure::new(
    "rss_lat_margin",
    "RSS margin, lateral",
    "m",
    Danger::Low,
    "gap across the route minus rss_lat; see rss_margin",
    |e| of_lanes(e, lateral_margin),
);

/// The lateral gap minus the safe distance, metres.
pub(super) fn lateral_margin(ego: &LaneBody, other: &LaneBody, rss: &Rss) -> f64 {
    ego.clearance(other) - lateral_distance(ego, other, rss)
}

/// Below this difference of offsets neither is the left one, metres: the longer distance counts.
const OFFSET_TOLERANCE: f64 = 1e-6;

/// The safe distance, metres.
fn lateral_distance(ego: &LaneBody, other: &LaneBody, rss: &Rss) -> f64 {
    let ways = |left: &LaneBody, right: &LaneBody| {
        lateral_stopping(-left.velocity.y, rss) + lateral_stopping(right.velocity.y, rss)
    };
    let aside = ego.at.d - other.at.d;
    let ways = if aside.abs() < OFFSET_TOLERANCE {
        ways(ego, other).max(ways(other, ego))
    } else if aside > 0.0 {
        ways(ego, other)
    } else {
        ways(other, ego)
    };
    rss.lateral_margin + ways.max(0.0)
}

/// The way towards the other, metres; negative away from it.
fn lateral_stopping(velocity: f64, rss: &Rss) -> f64 {
    let after = velocity + rss.response * rss.lateral_accelerate;
    (velocity + after) / 2.0 * rss.response + after * after.abs() / (2.0 * rss.lateral_brake)
}

pub(in crate::metrics) const RSS_MARGIN: Measure = Measure::new(
    "rss_margin",
    "RSS margin",
    "m",
    Danger::Low,
    "larger of the two margins; dangerous below 0 (Shalev-Shwartz et al. 2017)",
    |e| {
        of_lanes(e, |ego, other, rss| {
            longitudinal_margin(ego, other, rss).max(lateral_margin(ego, other, rss))
        })
    },
);

#[cfg(test)]
mod tests {
    use super::*;

    use crate::metrics::limits::Limits;

    const RSS: &Rss = &Limits::SHIPPED.rss;

    #[test]
    fn the_formula_of_the_paper() {
        // ρ = 1, a = 3.5, b_min = 4, b_max = 8; both at 20 m/s.
        let expected = 20.0 + 1.75 + 23.5 * 23.5 / 8.0 - 400.0 / 16.0;
        assert!((same_direction(20.0, 20.0, RSS) - expected).abs() < 1e-12);
        assert_eq!(
            same_direction(0.0, 60.0, RSS),
            0.0,
            "the one in front is away"
        );
        assert!((stopping(10.0, 3.0, RSS) - (10.0 + 1.75 + 13.5 * 13.5 / 6.0)).abs() < 1e-12);
    }
}

#[cfg(test)]
mod rss_lateral_tests {
    use super::*;

    use crate::metrics::limits::Limits;

    const RSS: &Rss = &Limits::SHIPPED.rss;

    #[test]
    fn the_formula_of_the_paper() {
        // At rest: 0.1 m in the response time and 0.2²/1.6 m of braking.
        assert!((lateral_stopping(0.0, RSS) - 0.125).abs() < 1e-12);
        assert!(
            (lateral_stopping(-1.0, RSS) - (-0.9 - 0.64 / 1.6)).abs() < 1e-12,
            "driving away"
        );
    }
}
