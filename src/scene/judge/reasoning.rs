//! Number formats of the judge's reasoning, shared by both tasks.

use crate::metrics::{Contact, Encounter, MEASURES, RISK_LEVELS, Reading};
use crate::scenario::{Participant, Scene};

/// `car 30308`.
pub(super) fn name(participant: &Participant<'_>) -> String {
    format!("{} {}", participant.obstacle.kind, participant.obstacle.id)
}

/// `step 143 (14.3 s)`.
pub(super) fn moment(scene: &Scene, step: i64) -> String {
    format!("step {step} ({:.1} s)", scene.time_of(step))
}

/// `at step 143 (14.3 s)`, or `between steps 3 and 4, at 1.75 s`.
pub(super) fn touching(scene: &Scene, contact: &Contact) -> String {
    if contact.overlaps {
        format!("at {}", moment(scene, contact.step))
    } else {
        format!(
            "between steps {} and {}, at {:.2} s",
            contact.step - 1,
            contact.step,
            contact.time
        )
    }
}

/// A distance; to the millimetre where centimetres would read as contact.
pub(super) fn metres(distance: f64) -> String {
    if distance > 0.0 && distance < 0.1 {
        format!("{distance:.3} m")
    } else {
        format!("{distance:.2} m")
    }
}

/// With two decimals; what rounds to nothing has no sign.
fn number(value: f64) -> String {
    format!("{:.2}", (value * 100.0).round() / 100.0 + 0.0)
}

/// Where the other is, how far, and how fast it comes, in half a sentence.
pub(super) fn situation(encounter: &Encounter<'_>) -> String {
    let relation = encounter.relation();
    if encounter.is_with_occupancy() {
        return format!(
            "{}, distance {}, gaps {} m along and {} m across, a region of no known velocity",
            relation.direction.name().to_lowercase(),
            metres(encounter.distance()),
            number(relation.gap_long),
            number(relation.gap_lat),
        );
    }
    format!(
        "{}, distance {}, gaps {} m along and {} m across, relative velocity {} m/s along and {} m/s across",
        relation.direction.name().to_lowercase(),
        metres(encounter.distance()),
        number(relation.gap_long),
        number(relation.gap_lat),
        number(relation.velocity.x),
        number(relation.velocity.y),
    )
}

/// `1 (extreme)`.
pub(super) fn risk(score: u8) -> String {
    let name = RISK_LEVELS
        .level(score)
        .map_or("", |level| level.name.as_str());
    format!("{score} ({name})")
}

/// The value of a measure in an encounter.
pub(super) fn value(id: &str, encounter: &Encounter<'_>) -> Option<f64> {
    let measure = MEASURES.iter().find(|m| m.id == id)?;
    match measure.of(encounter) {
        Reading::Value(value) => Some(value),
        Reading::None(_) => None,
    }
}
