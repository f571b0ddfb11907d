//! The table of measures: what each is called, its unit, its source, and what is dangerous.

use super::along::{
    brake_threat, crash_potential, drac, headway, integrated, lane_ttc, lateral_deceleration,
    longitudinal_deceleration, rss_lateral, rss_longitudinal, rss_margin, steer_threat,
    time_exposed, time_gap, time_headway,
};
use super::recorded::{
    closest_distance, encroachment, first_overlap, post_encroachment, time_to_closest,
    time_to_manoeuvre,
};
use super::{
    Encounter, Reading, contact_speed, distance, frame, risk, time_to_collision, worst_case,
};

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
    /// Computes it.
    pub compute: fn(&Encounter<'_>) -> Reading,
}

/// Measures that need places alone, and so have values for regions of occupancy sets.
const OF_PLACES: [&str; 6] = ["distance", "gap_long", "gap_lat", "dce", "ttce", "ttc_star"];

impl Measure {
    /// Its value in an encounter. With a region of an occupancy set, where an obstacle may be and whose velocity is not
    /// known, only measures of places have values, and the risk score where the region touches the ego.
    #[must_use]
    pub fn of(&self, encounter: &Encounter<'_>) -> Reading {
        if encounter.is_with_occupancy() && !OF_PLACES.contains(&self.id) {
            let is_contact = self.is_ordinal() && encounter.distance() == 0.0;
            if !is_contact {
                return Reading::None(super::NoValue::Occupancy);
            }
        }
        (self.compute)(encounter)
    }

    /// Whether its values are levels, between which there is nothing: the risk score. They are drawn as steps.
    #[must_use]
    pub fn is_ordinal(&self) -> bool {
        self.id == super::risk::MEASURE.id
    }

    /// Word for the most dangerous value. Of levels it is not "min": the lowest risk score is the highest danger.
    #[must_use]
    pub fn extreme(&self) -> &'static str {
        if self.is_ordinal() {
            "worst"
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

/// Every measure, in the order of columns.
pub const MEASURES: &[Measure] = &[
    distance::MEASURE,
    time_to_collision::MEASURE,
    risk::MEASURE,
    frame::GAP_LONG,
    frame::GAP_LAT,
    frame::TTC_LONG,
    frame::TTC_LAT,
    frame::V_REL_LONG,
    frame::V_REL_LAT,
    frame::A_REL_LONG,
    frame::A_REL_LAT,
    closest_distance::MEASURE,
    time_to_closest::MEASURE,
    first_overlap::MEASURE,
    contact_speed::MEASURE,
    worst_case::MEASURE,
    headway::MEASURE,
    time_gap::MEASURE,
    time_headway::MEASURE,
    lane_ttc::MEASURE,
    longitudinal_deceleration::MEASURE,
    lateral_deceleration::MEASURE,
    drac::MEASURE,
    brake_threat::MEASURE,
    steer_threat::MEASURE,
    time_exposed::MEASURE,
    integrated::MEASURE,
    crash_potential::MEASURE,
    encroachment::MEASURE,
    post_encroachment::MEASURE,
    time_to_manoeuvre::BRAKE,
    time_to_manoeuvre::KICK_DOWN,
    time_to_manoeuvre::STEER,
    time_to_manoeuvre::REACT,
    rss_longitudinal::DISTANCE,
    rss_longitudinal::MARGIN,
    rss_lateral::DISTANCE,
    rss_lateral::MARGIN,
    rss_margin::MEASURE,
];

/// The measure with this id.
#[must_use]
pub fn measure(id: &str) -> Option<&'static Measure> {
    MEASURES.iter().find(|m| m.id == id)
}
