//! Time to collision in the plane: when the two bodies touch if both keep velocity and heading.
//!
//! Swept, not sampled. The two-dimensional form of the measure of Hayward (1972).

use super::{Danger, Encounter, Measure, Mirrored, NoValue, Reading};
use nearmiss_base::geometry::Contact;

pub(super) const MEASURE: Measure = Measure {
    id: "ttc",
    name: "time to collision",
    unit: "s",
    danger: Danger::Low,
    mirrored: Mirrored::Kept,
    reads_ahead: false,
    source: "Hayward 1972, bodies in the plane at constant velocity",
    compute,
};

/// Contacts later than this are not looked for, seconds.
pub const HORIZON: f64 = 10.0;

/// Seconds to contact; 0 in contact, whatever the velocities.
fn compute(encounter: &Encounter<'_>) -> Reading {
    let contact = encounter.ego_placed().contact(
        &encounter.ego.velocity_vector(),
        &encounter.other_placed(),
        &encounter.other.velocity_vector(),
        HORIZON,
    );
    match contact {
        Contact::Now => Reading::Value(0.0),
        Contact::In(time) => Reading::Value(time),
        Contact::NotWithinHorizon => Reading::None(NoValue::NoContact),
    }
}

#[cfg(test)]
mod tests {
    use super::super::relation::tests::{motion, with};
    use super::*;

    #[test]
    fn following_and_crossing() {
        let follow = with(motion(0., 0., 0., 10.), motion(14., 0., 0., 5.), compute);
        assert!(follow.value().is_some_and(|t| (t - 2.0).abs() < 1e-6));
        let up = std::f64::consts::FRAC_PI_2;
        // Both reach the crossing at the same time; the fronts meet before the centres do.
        let cross = with(
            motion(-20., 0., 0., 10.),
            motion(0., -20., up, 10.),
            compute,
        );
        assert!(
            cross.value().is_some_and(|t| t > 1.5 && t < 2.0),
            "{cross:?}"
        );
        let past = with(motion(0., 0., 0., 10.), motion(14., 5., 0., 5.), compute);
        assert_eq!(past, Reading::None(NoValue::NoContact));
    }
}
