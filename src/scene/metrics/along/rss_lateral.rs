//! Lateral safe distance of responsibility-sensitive safety, and how much more there is.
//!
//! With v₁ the velocity to the right of the left one and v₂ that to the left of the right one, which grow
//! by ρ·a during the response time: d = μ + [w(v₁) + w(v₂)]₊, w(v) = (v + v_ρ)/2·ρ + v_ρ²/(2·b) towards the
//! other, v_ρ = v + ρ·a; where v_ρ is negative it drives away, and brakes that too. Source: Shalev-Shwartz,
//! Shammah and Shashua, On a Formal Model of Safe and Scalable Self-driving Cars, 2017, definition 6 and lemma 4.

use super::super::{Danger, Encounter, Measure, Mirrored, Reading};
use super::LaneBody;
use crate::metrics::limits::Rss;

pub(in crate::metrics) const DISTANCE: Measure = Measure {
    id: "rss_lat",
    name: "RSS safe distance, lateral",
    unit: "m",
    danger: Danger::High,
    mirrored: Mirrored::Kept,
    reads_ahead: false,
    source: "Shalev-Shwartz et al. 2017, definition 6, across the ego's route",
    compute: |e| {
        e.ask(|c, other, i| Ok(safe(&c.ego_along(i)?, &c.along(other, i)?, &c.limits().rss)))
            .into()
    },
};

pub(in crate::metrics) const MARGIN: Measure = Measure {
    id: "rss_lat_margin",
    name: "RSS margin, lateral",
    unit: "m",
    danger: Danger::Low,
    mirrored: Mirrored::Kept,
    reads_ahead: false,
    source: "gap across the route minus rss_lat; see rss_margin",
    compute: |e: &Encounter<'_>| -> Reading {
        e.ask(|c, other, i| {
            Ok(margin(
                &c.ego_along(i)?,
                &c.along(other, i)?,
                &c.limits().rss,
            ))
        })
        .into()
    },
};

/// The lateral gap minus the safe distance, metres.
pub(super) fn margin(ego: &LaneBody, other: &LaneBody, rss: &Rss) -> f64 {
    ego.clearance(other) - safe(ego, other, rss)
}

/// Below this difference of offsets neither is the left one, metres: the longer distance counts.
const ALIKE: f64 = 1e-6;

/// The safe distance, metres.
fn safe(ego: &LaneBody, other: &LaneBody, rss: &Rss) -> f64 {
    let ways =
        |left: &LaneBody, right: &LaneBody| way(-left.velocity.y, rss) + way(right.velocity.y, rss);
    let aside = ego.at.d - other.at.d;
    let ways = if aside.abs() < ALIKE {
        ways(ego, other).max(ways(other, ego))
    } else if aside > 0.0 {
        ways(ego, other)
    } else {
        ways(other, ego)
    };
    rss.lateral_margin + ways.max(0.0)
}

/// The way towards the other, metres; negative away from it.
fn way(velocity: f64, rss: &Rss) -> f64 {
    let after = velocity + rss.response * rss.lateral_accelerate;
    (velocity + after) / 2.0 * rss.response + after * after.abs() / (2.0 * rss.lateral_brake)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metrics::limits::Limits;

    const RSS: &Rss = &Limits::SHIPPED.rss;

    #[test]
    fn the_formula_of_the_paper() {
        // At rest: 0.1 m in the response time and 0.2²/1.6 m of braking.
        assert!((way(0.0, RSS) - 0.125).abs() < 1e-12);
        assert!(
            (way(-1.0, RSS) - (-0.9 - 0.64 / 1.6)).abs() < 1e-12,
            "driving away"
        );
    }
}
