//! How somebody moves in relation to the ego, in a sentence without numbers.

use crate::metrics::{Direction, Relation};

/// Slower than this, m/s, or nearer, m, is nothing worth a word.
const NOTICEABLE: f64 = 0.05;

/// The sentence.
pub(super) fn of(relation: &Relation) -> String {
    if relation.direction == Direction::Contact {
        return "It touches the ego.".into();
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
