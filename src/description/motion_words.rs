//! Describes an obstacle's motion relative to the ego in a sentence without numbers.

use crate::metrics::{Direction, Relation};

/// Slower than this, m/s, or nearer, m, is nothing worth a word.
const NOTICEABLE: f64 = 0.05;

/// The sentence.
///
/// Contact is named only with `contact`; otherwise touching bodies get the same sentence as all bodies without a gap,
/// so that the sentence does not tell them apart.
pub(super) fn describe_motion(relation: &Relation, contact: bool) -> String {
    if contact && relation.direction == Direction::Contact {
        return "It touches the ego.".into();
    }
    if !contact && relation.gap_long == 0.0 && relation.gap_lat == 0.0 {
        return only_moves(relation);
    }
    let long = match (side(relation.gap_long), side(relation.velocity.x)) {
        (0, 0) => "It is level with the ego and stays so",
        (0, 1) => "It is level with the ego and moves forward past it",
        (0, _) => "It is level with the ego and drops back past it",
        (1, -1) => "Ahead of the ego, the gap is closing",
        (1, 1) => "Ahead of the ego, the gap is opening",
        (1, _) => "Ahead of the ego, the gap stays",
        (_, 1) => "Behind the ego, the gap is closing",
        (_, -1) => "Behind the ego, the gap is opening",
        _ => "Behind the ego, the gap stays",
    };
    let lat = match (side(relation.gap_lat), side(relation.velocity.y)) {
        (0, 0) => "it is in line with the ego and stays so",
        (0, 1) => "it is in line with the ego and drifts to the left",
        (0, _) => "it is in line with the ego and drifts to the right",
        (1, -1) => "from the left it comes nearer sideways",
        (1, 1) => "on the left it moves away sideways",
        (1, _) => "on the left it keeps its sideways distance",
        (_, 1) => "from the right it comes nearer sideways",
        (_, -1) => "on the right it moves away sideways",
        _ => "on the right it keeps its sideways distance",
    };
    format!("{long}; {lat}.")
}

/// How it moves, without a word of where it is.
fn only_moves(relation: &Relation) -> String {
    let long = match side(relation.velocity.x) {
        0 => "neither forward nor backward",
        1 => "forward",
        _ => "backward",
    };
    let lat = match side(relation.velocity.y) {
        0 => "not sideways",
        1 => "to the left",
        _ => "to the right",
    };
    format!("Seen from the ego it moves {long} and {lat}.")
}

/// −1, 0 or 1; what is hardly noticeable is 0.
fn side(value: f64) -> i8 {
    if value > NOTICEABLE {
        1
    } else if value < -NOTICEABLE {
        -1
    } else {
        0
    }
}
