//! The table of measures.

use super::along::{
    brake_threat, crash_potential, drac, headway, integrated, lane_ttc, lateral_deceleration,
    longitudinal_deceleration, rss_lateral, rss_longitudinal, rss_margin, steer_threat,
    time_exposed, time_gap, time_headway,
};
use super::recorded::{
    closest_distance, encroachment, first_overlap, post_encroachment, time_to_closest,
    time_to_manoeuvre,
};
use super::{Measure, contact_speed, distance, frame, risk, time_to_collision, worst_case};

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
