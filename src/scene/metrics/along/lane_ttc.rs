//! Time to collision along the lane, with acceleration.
//!
//! The first t > 0 with Δd + Δv·t + ½Δa·t² = 0, where Δd is the headway, Δv the other's speed along the route
//! minus the ego's and Δa the same of the accelerations, all kept; 0 while the bodies touch. Source: Jansson, Collision Avoidance Theory,
//! 2005, eq. 5.26. The root is written so that Δa = 0 needs no case of its own.

use super::super::{Danger, Encounter, Measure, Mirrored, NoValue, Reading};
use super::Following;

pub(in crate::metrics) const MEASURE: Measure = Measure {
    id: "ttc_lane",
    name: "time to collision along the lane",
    unit: "s",
    danger: Danger::Low,
    mirrored: Mirrored::Kept,
    reads_ahead: false,
    source: "headway, speeds and accelerations along the lane (Jansson 2005, eq. 5.26); up to 100 s",
    compute,
};

/// Later collisions are none, seconds.
const HORIZON: f64 = 100.0;

fn compute(encounter: &Encounter<'_>) -> Reading {
    let following = encounter.ask(|c, other, index| c.following(other, index));
    match following {
        Err(NoValue::Contact) => Reading::Value(0.0),
        following => following.and_then(|f| time(&f)).into(),
    }
}

/// The time to collision of a follower, seconds.
pub(super) fn time(following: &Following) -> Result<f64, NoValue> {
    let (velocity, acceleration) = (following.velocity(), following.acceleration());
    match root(following.gap, velocity, acceleration) {
        Some(time) if time <= HORIZON => Ok(time),
        Some(_) => Err(NoValue::NoContact),
        None if velocity < 0.0 => Err(NoValue::NoContact),
        None => Err(NoValue::NotApproaching),
    }
}

/// The first time after now at which gap + v·t + ½a·t² is 0.
fn root(gap: f64, v: f64, a: f64) -> Option<f64> {
    let inside = v * v - 2.0 * a * gap;
    if inside < 0.0 {
        return None;
    }
    let below = inside.sqrt() - v;
    (below > 0.0).then(|| 2.0 * gap / below)
}

#[cfg(test)]
mod tests {
    use super::root;

    #[test]
    fn roots_solve_the_equation() {
        for (gap, v, a) in [
            (20., -5., 0.),
            (20., -5., 0.4),
            (20., 3., -1.),
            (20., -5., -1.),
            (20., 0., -2.),
        ] {
            let t: f64 = root(gap, v, a).unwrap_or_else(|| panic!("{gap} {v} {a}"));
            assert!(
                t > 0.0 && (gap + v * t + a * t * t / 2.0).abs() < 1e-9,
                "{t}"
            );
        }
        assert_eq!(root(20., 5., 0.), None, "moving apart");
        assert_eq!(root(20., -5., 2.), None, "the other speeds up in time");
        // 10 m at 5 m/s and −1 m/s²: 10 − 5t + t²/2 has no double root, its first is 5 − √5.
        assert!(root(10., -5., 1.).is_some_and(|t| (t - (5.0 - 5.0_f64.sqrt())).abs() < 1e-12));
    }
}
