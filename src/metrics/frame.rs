//! Gaps, relative velocities and accelerations in the ego's own frame: x forward, y left.

use super::{Danger, Measure, Mirrored, NoValue, Reading};

pub(super) const GAP_LONG: Measure = Measure {
    id: "gap_long",
    name: "longitudinal gap",
    unit: "m",
    danger: Danger::Neutral,
    mirrored: Mirrored::Kept,
    source: "ego frame, bumper to bumper",
    compute: |e| Reading::Value(e.relation().gap_long),
};

pub(super) const GAP_LAT: Measure = Measure {
    id: "gap_lat",
    name: "lateral gap",
    unit: "m",
    danger: Danger::Neutral,
    mirrored: Mirrored::Negated,
    source: "ego frame, side to side",
    compute: |e| Reading::Value(e.relation().gap_lat),
};

pub(super) const TTC_LONG: Measure = Measure {
    id: "ttc_long",
    name: "time to close the longitudinal gap",
    unit: "s",
    danger: Danger::Low,
    mirrored: Mirrored::Kept,
    source: "gap over closing speed, ego frame",
    compute: |e| or_not_approaching(e.relation().time_long()),
};

pub(super) const TTC_LAT: Measure = Measure {
    id: "ttc_lat",
    name: "time to close the lateral gap",
    unit: "s",
    danger: Danger::Low,
    mirrored: Mirrored::Kept,
    source: "gap over closing speed, ego frame",
    compute: |e| or_not_approaching(e.relation().time_lat()),
};

pub(super) const V_REL_LONG: Measure = Measure {
    id: "v_rel_long",
    name: "relative velocity, longitudinal",
    unit: "m/s",
    danger: Danger::Neutral,
    mirrored: Mirrored::Kept,
    source: "ego frame",
    compute: |e| Reading::Value(e.relation().velocity.x),
};

pub(super) const V_REL_LAT: Measure = Measure {
    id: "v_rel_lat",
    name: "relative velocity, lateral",
    unit: "m/s",
    danger: Danger::Neutral,
    mirrored: Mirrored::Negated,
    source: "ego frame",
    compute: |e| Reading::Value(e.relation().velocity.y),
};

pub(super) const A_REL_LONG: Measure = Measure {
    id: "a_rel_long",
    name: "relative acceleration, longitudinal",
    unit: "m/s²",
    danger: Danger::Neutral,
    mirrored: Mirrored::Kept,
    source: "ego frame",
    compute: |e| Reading::Value(e.relation().acceleration.x),
};

pub(super) const A_REL_LAT: Measure = Measure {
    id: "a_rel_lat",
    name: "relative acceleration, lateral",
    unit: "m/s²",
    danger: Danger::Neutral,
    mirrored: Mirrored::Negated,
    source: "ego frame",
    compute: |e| Reading::Value(e.relation().acceleration.y),
};

fn or_not_approaching(time: Option<f64>) -> Reading {
    time.ok_or(NoValue::NotApproaching).into()
}
