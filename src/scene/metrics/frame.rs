//! Gaps, relative velocities and accelerations in the ego's own frame: x forward, y left.

use super::{Danger, Measure, Mirrored, NoValue, Reading, Relation};

pub(super) const GAP_LONG: Measure = Measure {
    id: "gap_long",
    name: "longitudinal gap",
    unit: "m",
    danger: Danger::Neutral,
    mirrored: Mirrored::Kept,
    reads_ahead: false,
    source: "ego frame, bumper to bumper",
    compute: |e| Reading::Value(e.relation().gap_long),
};

pub(super) const GAP_LAT: Measure = Measure {
    id: "gap_lat",
    name: "lateral gap",
    unit: "m",
    danger: Danger::Neutral,
    mirrored: Mirrored::Negated,
    reads_ahead: false,
    source: "ego frame, side to side",
    compute: |e| Reading::Value(e.relation().gap_lat),
};

pub(super) const TTC_LONG: Measure = Measure {
    id: "ttc_long",
    name: "time to close the longitudinal gap",
    unit: "s",
    danger: Danger::Low,
    mirrored: Mirrored::Kept,
    reads_ahead: false,
    source: "gap over closing speed, ego frame",
    compute: |e| to_close(&e.relation(), |r| r.gap_long, Relation::time_long),
};

pub(super) const TTC_LAT: Measure = Measure {
    id: "ttc_lat",
    name: "time to close the lateral gap",
    unit: "s",
    danger: Danger::Low,
    mirrored: Mirrored::Kept,
    reads_ahead: false,
    source: "gap over closing speed, ego frame",
    compute: |e| to_close(&e.relation(), |r| r.gap_lat, Relation::time_lat),
};

pub(super) const V_REL_LONG: Measure = Measure {
    id: "v_rel_long",
    name: "relative velocity, longitudinal",
    unit: "m/s",
    danger: Danger::Neutral,
    mirrored: Mirrored::Kept,
    reads_ahead: false,
    source: "ego frame",
    compute: |e| Reading::Value(e.relation().velocity.x),
};

pub(super) const V_REL_LAT: Measure = Measure {
    id: "v_rel_lat",
    name: "relative velocity, lateral",
    unit: "m/s",
    danger: Danger::Neutral,
    mirrored: Mirrored::Negated,
    reads_ahead: false,
    source: "ego frame",
    compute: |e| Reading::Value(e.relation().velocity.y),
};

pub(super) const A_REL_LONG: Measure = Measure {
    id: "a_rel_long",
    name: "relative acceleration, longitudinal",
    unit: "m/s²",
    danger: Danger::Neutral,
    mirrored: Mirrored::Kept,
    reads_ahead: false,
    source: "ego frame",
    compute: |e| Reading::Value(e.relation().acceleration.x),
};

pub(super) const A_REL_LAT: Measure = Measure {
    id: "a_rel_lat",
    name: "relative acceleration, lateral",
    unit: "m/s²",
    danger: Danger::Neutral,
    mirrored: Mirrored::Negated,
    reads_ahead: false,
    source: "ego frame",
    compute: |e| Reading::Value(e.relation().acceleration.y),
};

/// The time to close a gap, which is 0 where the bodies overlap along its axis.
fn to_close(
    relation: &Relation,
    gap: fn(&Relation) -> f64,
    time: fn(&Relation) -> Option<f64>,
) -> Reading {
    let none = if gap(relation) == 0.0 {
        NoValue::Overlapping
    } else {
        NoValue::NotApproaching
    };
    time(relation).ok_or(none).into()
}

#[cfg(test)]
mod tests {
    use super::super::relation::tests::{motion, with};
    use super::*;

    #[test]
    fn without_a_gap_there_is_nothing_to_close() {
        let ahead = |measure: &Measure, v| {
            let (ego, other) = (motion(0., 0., 0., 10.), motion(14., 0., 0., v));
            with(ego, other, measure.compute)
        };
        assert!(
            ahead(&TTC_LONG, 5.)
                .value()
                .is_some_and(|t| (t - 2.0).abs() < 1e-9)
        );
        assert_eq!(
            ahead(&TTC_LONG, 15.),
            Reading::None(NoValue::NotApproaching)
        );
        assert_eq!(ahead(&TTC_LAT, 5.), Reading::None(NoValue::Overlapping));
    }
}
