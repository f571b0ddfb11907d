//! Phrases and tables shared by several descriptions.

use super::lanes::Lanes;
use super::reach::apart;
use super::seen::Seen;
use super::writer::{Subject, Writer};
use crate::scenario::{Motion, Participant, Scene, Window};

/// The line for a step without a recorded ego.
pub(super) const NO_EGO: &str = "  The ego is not recorded at this time.\n";

/// Whose the numbers about a participant are.
pub(super) fn subject(participant: &Participant<'_>) -> Subject {
    Subject::Obstacle(participant.obstacle.id)
}

/// What an obstacle is called: its type and id.
pub(super) fn name(w: &mut Writer, participant: &Participant<'_>) {
    w.words(participant.obstacle.kind.name())
        .words(" ")
        .whole("id", participant.obstacle.id);
}

/// The lines that a description begins with: the sizes of the ego and of the `others` that are described, and how many
/// are there that are not.
pub(super) fn everyone_there(
    w: &mut Writer,
    scene: &Scene,
    window: &Window,
    others: &[Participant<'_>],
) {
    sizes(w, scene, others);
    left_out(w, scene, window, others);
}

/// A line with the sizes of the ego and of `others`.
fn sizes(w: &mut Writer, scene: &Scene, others: &[Participant<'_>]) {
    let size = |w: &mut Writer, (length, width): (f64, f64)| {
        w.number("length", length)
            .words(" m long and ")
            .number("width", width)
            .words(" m wide");
    };
    w.about(Subject::Ego, None).words("Sizes: the ego is ");
    size(w, scene.ego.footprint.shape().size());
    for other in others {
        w.about(subject(other), None).words("; ");
        name(w, other);
        w.words(" ");
        size(w, other.footprint.shape().size());
    }
    w.words(".\n");
}

/// A line that says how many obstacles of a window are not `told` of, and how near they come in it; none where there
/// are none.
pub(super) fn left_out(w: &mut Writer, scene: &Scene, window: &Window, told: &[Participant<'_>]) {
    let is_told = |other: &Participant<'_>| told.iter().any(|t| t.obstacle.id == other.obstacle.id);
    let nearest = |other: Participant<'_>| {
        let both = |step| scene.ego.track.at(step).zip(other.at(step));
        let distances = window
            .steps()
            .filter_map(both)
            .map(|(ego, there)| apart(ego, there));
        distances.min_by(f64::total_cmp)
    };
    let others = scene.participants().filter(|other| !is_told(other));
    let nearest: Vec<f64> = others.filter_map(nearest).collect();
    let Some(least) = nearest.iter().copied().min_by(f64::total_cmp) else {
        return;
    };
    let come = match nearest.len() {
        1 => " other, which comes",
        _ => " others, which come",
    };
    w.about(Subject::Scene, None)
        .words("Not described: ")
        .whole("others", i64::try_from(nearest.len()).unwrap_or(i64::MAX))
        .words(come)
        .words(" no nearer than ")
        .number("centre_distance", least)
        .words(" m, centre to centre.\n");
}

/// The head of one step; where times are relative, its number is not said.
pub(super) fn heading(w: &mut Writer, scene: &Scene, step: i64) {
    w.about(Subject::Scene, Some(step)).words("\n");
    if !w.is_relative() {
        w.words("Step ").whole("step", step).words(", ");
    }
    w.words("t = ")
        .time(step, scene.scenario.dt())
        .words(" s:\n");
}

/// The ego's own motion, in a sentence.
pub(super) fn ego_moves(w: &mut Writer, lanes: &Lanes<'_>, ego: &Motion, step: i64) {
    w.about(Subject::Ego, Some(step))
        .words("  The ego: velocity ")
        .number("velocity", ego.velocity)
        .words(" m/s, acceleration ")
        .number("acceleration", ego.acceleration)
        .words(" m/s²");
    lane(w, lanes.of_ego(ego));
    w.words(".\n");
}

/// The words for a lane behind a comma, if there are any.
pub(super) fn lane(w: &mut Writer, words: Option<&str>) {
    if let Some(words) = words {
        w.words(", ").words(words);
    }
}

/// An obstacle with its direction and lane, in front of a colon.
pub(super) fn name_and_place(
    w: &mut Writer,
    participant: &Participant<'_>,
    step: i64,
    seen: &Seen,
    lane_words: Option<&str>,
) {
    w.about(subject(participant), Some(step)).words("  ");
    name(w, participant);
    w.words(" (").words(seen.direction.name());
    lane(w, lane_words);
    w.words("): ");
}

/// The sentence for a step at which no obstacle is near.
pub(super) fn no_obstacles(w: &mut Writer, radius: f64) {
    w.about(Subject::Scene, None)
        .words("  No obstacle is within ")
        .number("radius", radius)
        .words(" m.\n");
}

/// Motion in the coordinates of the map, for the end of a line.
pub(super) fn on_the_map(w: &mut Writer, motion: &Motion) {
    w.words("at (")
        .number("x", motion.pose.position.x)
        .words(", ")
        .number("y", motion.pose.position.y)
        .words(") m, heading ")
        .angle("heading", motion.pose.heading)
        .words(" rad, velocity ")
        .number("velocity", motion.velocity)
        .words(" m/s, acceleration ")
        .number("acceleration", motion.acceleration)
        .words(" m/s²");
}

/// The lanelets under a participant, for the end of a sentence.
pub(super) fn on_lanelets(w: &mut Writer, scene: &Scene, motion: &Motion) {
    let ids = scene.scenario.network.lanelets_at(&motion.pose.position);
    if ids.is_empty() {
        w.words("off the lanelets");
        return;
    }
    w.words("on lanelet ");
    lanelet_ids(w, &ids, " and ");
}

/// Ids of lanelets.
pub(super) fn lanelet_ids<'w>(w: &'w mut Writer, ids: &[i64], between: &str) -> &'w mut Writer {
    for (place, &id) in ids.iter().enumerate() {
        if place > 0 {
            w.words(between);
        }
        w.whole("lanelet", id);
    }
    w
}
