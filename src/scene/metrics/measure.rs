//! A measure: what it is called, its unit, its source, and what is dangerous.

use super::own::Formula;
use super::{Encounter, NoValue, Reading};

/// Which values of a measure are dangerous.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Danger {
    /// Small ones; of required accelerations, the most negative.
    Low,
    /// Large ones.
    High,
    /// Neither: the measure describes.
    Neutral,
}

impl Danger {
    /// A word for the most dangerous value.
    #[must_use]
    pub fn extreme(self) -> &'static str {
        match self {
            Self::Low | Self::Neutral => "min",
            Self::High => "max",
        }
    }

    /// Whether a value is as dangerous as another one; where neither is dangerous, no.
    #[must_use]
    pub fn reaches(self, value: f64, threshold: f64) -> bool {
        match self {
            Self::Low => value <= threshold,
            Self::High => value >= threshold,
            Self::Neutral => false,
        }
    }

    /// Orders two values, the more dangerous one first; of a measure that only describes, the lower one.
    #[must_use]
    pub fn compare(self, a: f64, b: f64) -> std::cmp::Ordering {
        match self {
            Self::Low | Self::Neutral => a.total_cmp(&b),
            Self::High => b.total_cmp(&a),
        }
    }
}

/// The behaviour of a measure under mirroring of the scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mirrored {
    /// It stays.
    Kept,
    /// Its sign turns: it counts to the left.
    Negated,
}

/// How a measure is computed.
#[derive(Debug, Clone, Copy)]
pub(super) enum Compute {
    /// By the program.
    Code(fn(&Encounter<'_>) -> Reading),
    /// By a formula of the user's.
    Formula(&'static Formula),
}

/// A measure of one obstacle at one step.
#[derive(Debug)]
pub struct Measure {
    /// Short name for columns and the command line.
    pub id: &'static str,
    /// Its name.
    pub name: &'static str,
    /// Its unit; empty for a score.
    pub unit: &'static str,
    /// Which values are dangerous.
    pub danger: Danger,
    /// Its behaviour under mirroring.
    pub mirrored: Mirrored,
    /// Whether it reads recorded steps after the one that it is computed at: then it tells the future, and no model that
    /// is judged may ask for it.
    pub reads_ahead: bool,
    /// The source of its definition.
    pub source: &'static str,
    /// How it is computed.
    pub(super) compute: Compute,
}

/// The id of the risk score.
pub(super) const RISK: &str = "risk";

/// Measures that need places alone, and so have values for regions of occupancy sets.
const OF_PLACES: [&str; 6] = ["distance", "gap_long", "gap_lat", "dce", "ttce", "ttc_star"];

impl Measure {
    /// One that the program computes from what is there at the step, the same in a mirrored scene.
    pub(super) const fn new(
        id: &'static str,
        name: &'static str,
        unit: &'static str,
        danger: Danger,
        source: &'static str,
        compute: fn(&Encounter<'_>) -> Reading,
    ) -> Self {
        Self {
            id,
            name,
            unit,
            danger,
            mirrored: Mirrored::Kept,
            reads_ahead: false,
            source,
            compute: Compute::Code(compute),
        }
    }

    /// The same of steps after the one that it is computed at.
    pub(super) const fn reading_ahead(mut self) -> Self {
        self.reads_ahead = true;
        self
    }

    /// The same with another sign in a mirrored scene.
    pub(super) const fn negated(mut self) -> Self {
        self.mirrored = Mirrored::Negated;
        self
    }

    /// Its value in an encounter. With a region of an occupancy set, where an obstacle may be and whose velocity is not
    /// known, only measures of places have values, and the risk score where the region touches the ego.
    #[must_use]
    pub fn evaluate(&self, encounter: &Encounter<'_>) -> Reading {
        if encounter.is_with_occupancy() && !self.is_of_places() {
            let is_contact = self.is_ordinal() && encounter.distance() == 0.0;
            if !is_contact {
                return Reading::None(NoValue::Occupancy);
            }
        }
        self.compute(encounter)
    }

    /// The same with whatever the other is.
    #[must_use]
    pub fn compute(&self, encounter: &Encounter<'_>) -> Reading {
        match self.compute {
            Compute::Code(compute) => compute(encounter),
            Compute::Formula(formula) => formula.reading(encounter),
        }
    }

    /// Whether it needs places alone.
    pub(super) fn is_of_places(&self) -> bool {
        match self.compute {
            Compute::Code(_) => OF_PLACES.contains(&self.id),
            Compute::Formula(formula) => formula.facts.of_places,
        }
    }

    /// Its formula, where it is the user's own.
    #[must_use]
    pub fn formula(&self) -> Option<&'static str> {
        match self.compute {
            Compute::Code(_) => None,
            Compute::Formula(formula) => Some(&formula.text),
        }
    }

    /// Whether its values are levels, between which there is nothing: the risk score. They are drawn as steps.
    #[must_use]
    pub fn is_ordinal(&self) -> bool {
        self.id == RISK
    }

    /// Word for the most dangerous value. Of levels it is not "min": the lowest risk score is the highest danger.
    #[must_use]
    pub fn extreme(&self) -> &'static str {
        if self.is_ordinal() {
            "lowest"
        } else {
            self.danger.extreme()
        }
    }

    /// Name of an axis of its values, by its short or its long name; it says which end of levels is the danger.
    #[must_use]
    pub fn axis_name(&self, name: &str) -> String {
        match (self.is_ordinal(), self.unit) {
            (true, _) => format!("{name}, 0 = collision"),
            (false, "") => name.to_string(),
            (false, unit) => format!("{name} ({unit})"),
        }
    }
}
