//! The table of measures: what each is called, its unit, its source, and what is dangerous.

use super::{Encounter, NoValue, Reading, distance, risk, time_to_collision};

/// Which values of a measure are dangerous.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Danger {
    /// Small ones.
    Low,
    /// Neither: the measure describes.
    Neutral,
}

impl Danger {
    /// A word for the most dangerous value.
    #[must_use]
    pub fn extreme(self) -> &'static str {
        match self {
            Self::Low | Self::Neutral => "min",
        }
    }
}

/// A measure of one obstacle at one step.
#[derive(Debug)]
pub struct Measure {
    /// Short name for columns and the command line.
    pub id: &'static str,
    /// What it is called.
    pub name: &'static str,
    /// Its unit; empty for a score.
    pub unit: &'static str,
    /// Which values are dangerous.
    pub danger: Danger,
    /// Where its definition comes from.
    pub source: &'static str,
    /// Computes it.
    pub compute: fn(&Encounter<'_>) -> Reading,
}

/// Every measure, in the order of columns.
pub const MEASURES: &[Measure] = &[
    Measure {
        id: "distance",
        name: "distance",
        unit: "m",
        danger: Danger::Low,
        source: "exact distance of the bodies (GJK, parry)",
        compute: distance::compute,
    },
    Measure {
        id: "ttc",
        name: "time to collision",
        unit: "s",
        danger: Danger::Low,
        source: "Hayward 1972, bodies in the plane at constant velocity",
        compute: time_to_collision::compute,
    },
    Measure {
        id: "risk",
        name: "risk score",
        unit: "",
        danger: Danger::Low,
        source: "From Words to Collisions, with real bodies",
        compute: risk::compute,
    },
    Measure {
        id: "gap_long",
        name: "longitudinal gap",
        unit: "m",
        danger: Danger::Neutral,
        source: "ego frame, bumper to bumper",
        compute: |e| Reading::Value(e.relation().gap_long),
    },
    Measure {
        id: "gap_lat",
        name: "lateral gap",
        unit: "m",
        danger: Danger::Neutral,
        source: "ego frame, side to side",
        compute: |e| Reading::Value(e.relation().gap_lat),
    },
    Measure {
        id: "ttc_long",
        name: "time to close the longitudinal gap",
        unit: "s",
        danger: Danger::Low,
        source: "gap over closing speed, ego frame",
        compute: |e| or_not_approaching(e.relation().time_long()),
    },
    Measure {
        id: "ttc_lat",
        name: "time to close the lateral gap",
        unit: "s",
        danger: Danger::Low,
        source: "gap over closing speed, ego frame",
        compute: |e| or_not_approaching(e.relation().time_lat()),
    },
    Measure {
        id: "v_rel_long",
        name: "relative velocity, longitudinal",
        unit: "m/s",
        danger: Danger::Neutral,
        source: "ego frame",
        compute: |e| Reading::Value(e.relation().velocity.x),
    },
    Measure {
        id: "v_rel_lat",
        name: "relative velocity, lateral",
        unit: "m/s",
        danger: Danger::Neutral,
        source: "ego frame",
        compute: |e| Reading::Value(e.relation().velocity.y),
    },
    Measure {
        id: "a_rel_long",
        name: "relative acceleration, longitudinal",
        unit: "m/s²",
        danger: Danger::Neutral,
        source: "ego frame",
        compute: |e| Reading::Value(e.relation().acceleration.x),
    },
    Measure {
        id: "a_rel_lat",
        name: "relative acceleration, lateral",
        unit: "m/s²",
        danger: Danger::Neutral,
        source: "ego frame",
        compute: |e| Reading::Value(e.relation().acceleration.y),
    },
];

fn or_not_approaching(time: Option<f64>) -> Reading {
    time.map_or(Reading::None(NoValue::NotApproaching), Reading::Value)
}

/// The measure with this id.
#[must_use]
pub fn measure(id: &str) -> Option<&'static Measure> {
    MEASURES.iter().find(|m| m.id == id)
}
