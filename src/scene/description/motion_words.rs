//! Describes an obstacle's motion relative to the ego in a sentence without numbers.

use super::seen::Seen;
use super::writer::Writer;
use crate::metrics::Direction;

/// The sentence; it follows from the numbers as they are written, so that the two never contradict each other.
///
/// Contact is named only with `contact`; otherwise the sentence about touching bodies says only how the other moves.
pub(super) fn describe_motion(w: &Writer, seen: &Seen, contact: bool) -> String {
    let (v_long, v_lat) = seen.written_velocity(w);
    let (v_long, v_lat) = (sign(v_long), sign(v_lat));
    let gap_long = sign(w.written("gap_long", seen.relation.gap_long));
    let gap_lat = sign(w.written("gap_lat", seen.relation.gap_lat));
    if (gap_long, gap_lat) == (0, 0) {
        let moves = moves(v_long, v_lat);
        return if seen.distance != 0.0 {
            format!(
                "It overlaps the ego's extent in both directions without touching; seen from the ego it moves {moves}."
            )
        } else if contact && seen.direction == Direction::Contact {
            "It touches the ego.".into()
        } else {
            format!("Seen from the ego it moves {moves}.")
        };
    }
    let long = match (gap_long, v_long) {
        (0, 0) => "It is level with the ego and stays so",
        (0, 1) => "It is level with the ego and moves forward",
        (0, _) => "It is level with the ego and moves backward",
        (1, -1) => "Ahead of the ego, the gap is closing",
        (1, 1) => "Ahead of the ego, the gap is opening",
        (1, _) => "Ahead of the ego, the gap stays",
        (_, 1) => "Behind the ego, the gap is closing",
        (_, -1) => "Behind the ego, the gap is opening",
        _ => "Behind the ego, the gap stays",
    };
    let lat = match (gap_lat, v_lat) {
        (0, 0) => "it is in line with the ego and stays so",
        (0, 1) => "it is in line with the ego and moves to the left",
        (0, _) => "it is in line with the ego and moves to the right",
        (1, -1) => "on the left it comes nearer sideways",
        (1, 1) => "on the left it moves away sideways",
        (1, _) => "on the left it keeps its sideways distance",
        (_, 1) => "on the right it comes nearer sideways",
        (_, -1) => "on the right it moves away sideways",
        _ => "on the right it keeps its sideways distance",
    };
    format!("{long}; {lat}.")
}

/// The same along and across the ego's lane, from what is written of it: how far the other is ahead and to the left, and
/// its relative velocity there.
pub(super) fn describe_along_lane([s, d]: [f64; 2], [v_s, v_d]: [f64; 2]) -> String {
    let long = match (sign(s), sign(v_s)) {
        (0, 0) => "Along the lane it is level with the ego and stays so",
        (0, 1) => "Along the lane it is level with the ego and moves forward",
        (0, _) => "Along the lane it is level with the ego and moves backward",
        (1, -1) => "Ahead along the lane, it comes nearer",
        (1, 1) => "Ahead along the lane, it draws away",
        (1, _) => "Ahead along the lane, it stays as far away",
        (_, 1) => "Behind along the lane, it comes nearer",
        (_, -1) => "Behind along the lane, it draws away",
        _ => "Behind along the lane, it stays as far away",
    };
    let lat = match (sign(d), sign(v_d)) {
        (0, 0) => "its centre is in line with the ego's and stays so",
        (0, 1) => "its centre is in line with the ego's and moves to the left",
        (0, _) => "its centre is in line with the ego's and moves to the right",
        (1, -1) => "on the left it comes nearer sideways",
        (1, 1) => "on the left it moves away sideways",
        (1, _) => "on the left it keeps its sideways distance",
        (_, 1) => "on the right it comes nearer sideways",
        (_, -1) => "on the right it moves away sideways",
        _ => "on the right it keeps its sideways distance",
    };
    format!("{long}; {lat}.")
}

/// How it moves, without a word of where it is.
fn moves(v_long: i8, v_lat: i8) -> String {
    let long = match v_long {
        0 => "neither forward nor backward",
        1 => "forward",
        _ => "backward",
    };
    let lat = match v_lat {
        0 => "not sideways",
        1 => "to the left",
        _ => "to the right",
    };
    format!("{long} and {lat}")
}

/// −1, 0 or 1.
fn sign(value: f64) -> i8 {
    match value {
        v if v > 0.0 => 1,
        v if v < 0.0 => -1,
        _ => 0,
    }
}
