//! Phrases and tables shared by several descriptions.

use std::borrow::Cow;

use super::ego_lane::Lanes;
use super::nearby::{VisibleObstacle, centre_distance};
use super::options::Options;
use super::writer::{Subject, Writer};
use crate::metrics::Context;
use crate::scenario::{Motion, Participant, Scene, Window};

/// The line for a step without a recorded ego.
pub(super) const NO_EGO: &str = "  The ego is not recorded at this time.\n";

/// Whose the numbers about a participant are.
pub(super) fn subject(participant: &Participant<'_>) -> Subject {
    Subject::Obstacle(participant.obstacle.id)
}

/// What an obstacle is called: its type and id.
pub(super) fn name(w: &mut Writer, participant: &Participant<'_>) {
    w.text(participant.obstacle.kind.name())
        .text(" ")
        .integer("id", participant.obstacle.id);
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
            .text(" m long and ")
            .number("width", width)
            .text(" m wide");
    };
    w.about(Subject::Ego, None).text("Sizes: the ego is ");
    size(w, scene.ego.footprint.shape().size());
    for other in others {
        w.about(subject(other), None).text("; ");
        name(w, other);
        w.text(" ");
        size(w, other.footprint.shape().size());
    }
    w.text(".\n");
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
            .map(|(ego, there)| centre_distance(ego, there));
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
        .text("Not described: ")
        .integer("others", i64::try_from(nearest.len()).unwrap_or(i64::MAX))
        .text(come)
        .text(" no nearer than ")
        .number("centre_distance", least)
        .text(" m, centre to centre.\n");
}

/// The head of one step; where times are relative, its number is not said.
pub(super) fn heading(w: &mut Writer, scene: &Scene, step: i64) {
    w.about(Subject::Scene, Some(step)).text("\n");
    if !w.is_relative() {
        w.text("Step ").integer("step", step).text(", ");
    }
    w.text("t = ").time(step, scene.scenario.dt()).text(" s:\n");
}

/// The ego's own motion, in a sentence.
pub(super) fn ego_moves(w: &mut Writer, lanes: &Lanes<'_>, ego: &Motion, step: i64) {
    w.about(Subject::Ego, Some(step))
        .text("  The ego: velocity ")
        .number("velocity", ego.velocity)
        .text(" m/s, acceleration ")
        .number("acceleration", ego.acceleration)
        .text(" m/s²");
    lane(w, lanes.of_ego(ego));
    w.text(".\n");
}

/// The words for a lane behind a comma, if there are any.
pub(super) fn lane(w: &mut Writer, words: Option<&str>) {
    if let Some(words) = words {
        w.text(", ").text(words);
    }
}

/// An obstacle with its direction and lane, in front of a colon.
pub(super) fn name_and_place(
    w: &mut Writer,
    participant: &Participant<'_>,
    step: i64,
    seen: &VisibleObstacle,
    lane_words: Option<&str>,
) {
    w.about(subject(participant), Some(step)).text("  ");
    name(w, participant);
    w.text(" (").text(seen.direction.name());
    lane(w, lane_words);
    w.text("): ");
}

/// The sentence for a step at which no obstacle is near.
pub(super) fn no_obstacles(w: &mut Writer, radius: f64) {
    w.about(Subject::Scene, None)
        .text("  No obstacle is within ")
        .number("radius", radius)
        .text(" m.\n");
}

/// Motion in the coordinates of the map, for the end of a line.
pub(super) fn on_the_map(w: &mut Writer, motion: &Motion) {
    w.text("at (")
        .number("x", motion.pose.position.x)
        .text(", ")
        .number("y", motion.pose.position.y)
        .text(") m, heading ")
        .angle("heading", motion.pose.heading)
        .text(" rad, velocity ")
        .number("velocity", motion.velocity)
        .text(" m/s, acceleration ")
        .number("acceleration", motion.acceleration)
        .text(" m/s²");
}

/// The lanelets under a participant, for the end of a sentence.
pub(super) fn on_lanelets(w: &mut Writer, scene: &Scene, motion: &Motion) {
    let ids = scene.scenario.network.lanelets_at(&motion.pose.position);
    if ids.is_empty() {
        w.text("off the lanelets");
        return;
    }
    w.text("on lanelet ");
    lanelet_ids(w, &ids, " and ");
}

/// Ids of lanelets.
pub(super) fn lanelet_ids<'w>(w: &'w mut Writer, ids: &[i64], between: &str) -> &'w mut Writer {
    for (place, &id) in ids.iter().enumerate() {
        if place > 0 {
            w.text(between);
        }
        w.integer("lanelet", id);
    }
    w
}

/// A column: its title with the unit, and what its numbers are.
pub(super) struct Column {
    pub title: Cow<'static, str>,
    pub quantity: &'static str,
}

/// A column.
pub(super) const fn column(title: &'static str, quantity: &'static str) -> Column {
    Column {
        title: Cow::Borrowed(title),
        quantity,
    }
}

/// Contents of a table cell.
pub(super) enum Cell {
    Nothing,
    Real(f64),
    Angle(f64),
    /// Degrees.
    Degrees(f64),
    Whole(i64),
    /// The time of a step, with the seconds of a step.
    Time(i64, f64),
    Words(&'static str),
    /// The lanelets under a participant.
    Lanelets(Vec<i64>),
}

impl Cell {
    /// A number, or nothing.
    pub fn number(value: Option<f64>) -> Self {
        value.map_or(Self::Nothing, Self::Real)
    }

    /// Words, or nothing.
    pub fn text(words: Option<&'static str>) -> Self {
        words.map_or(Self::Nothing, Self::Words)
    }

    /// The lanelets under a participant.
    pub fn lanelets(scene: &Scene, motion: &Motion) -> Self {
        Self::Lanelets(scene.scenario.network.lanelets_at(&motion.pose.position))
    }
}

/// The line of titles of rows that begin with [`begin`].
pub(super) fn titles(w: &mut Writer, columns: &[&[Column]]) {
    let first = if w.is_relative() {
        "t [s],who"
    } else {
        "step,t [s],who"
    };
    titles_after(w, first, columns);
}

/// The line of titles with these `first`.
pub(super) fn titles_after(w: &mut Writer, first: &str, columns: &[&[Column]]) {
    w.text(first);
    for column in columns.iter().copied().flatten() {
        w.text(",").text(&column.title);
    }
    w.text("\n");
}

/// Begins a row: when and who.
pub(super) fn begin(w: &mut Writer, scene: &Scene, step: i64, who: Option<&Participant<'_>>) {
    w.about(Subject::Scene, Some(step));
    if !w.is_relative() {
        w.integer("step", step).text(",");
    }
    w.time(step, scene.scenario.dt())
        .text(",")
        .about(who.map_or(Subject::Ego, subject), Some(step));
    match who {
        Some(who) => name(w, who),
        None => {
            w.text("ego");
        }
    }
}

/// Cells of a row under `columns`; those that are missing at the end have no value.
pub(super) fn cells(w: &mut Writer, columns: &[Column], cells: &[Cell]) {
    for (place, column) in columns.iter().enumerate() {
        w.text(",");
        match cells.get(place).unwrap_or(&Cell::Nothing) {
            Cell::Nothing => w.text("-"),
            Cell::Real(value) => w.number(column.quantity, *value),
            Cell::Angle(value) => w.angle(column.quantity, *value),
            Cell::Degrees(value) => w.degrees(column.quantity, *value),
            Cell::Time(step, dt) => w.time(*step, *dt),
            Cell::Whole(value) => w.integer(column.quantity, *value),
            Cell::Words(words) => w.text(words),
            Cell::Lanelets(ids) if ids.is_empty() => w.text("-"),
            Cell::Lanelets(ids) => lanelet_ids(w, ids, "+"),
        };
    }
}

/// A line for every obstacle whose region comes near in the window, at the described steps.
pub(super) fn describe(w: &mut Writer, context: &Context<'_>, window: &Window, options: &Options) {
    let everyone = context.participants().iter().enumerate();
    for (place, other) in everyone.filter(|(_, p)| p.obstacle.is_set_based()) {
        if options.obstacle.is_some_and(|id| id != other.obstacle.id) {
            continue;
        }
        let near = |step: i64| {
            let encounter = context.encounter(place, step)?;
            let is_region = encounter.is_with_occupancy();
            is_region.then(|| (encounter.distance(), step))
        };
        let nearest = options
            .steps(window)
            .into_iter()
            .filter_map(near)
            .min_by(|a, b| a.0.total_cmp(&b.0));
        let Some((distance, step)) = nearest.filter(|(d, _)| *d <= options.radius) else {
            continue;
        };
        w.about(subject(other), Some(step)).text("\nThe ");
        name(w, other);
        w.text(
            " is given as a region that it may cover (predicted occupancy), without heading or velocity: the region is nearest at t = ",
        )
        .time(step, context.scene().scenario.dt())
        .text(" s, distance ")
        .number("distance", distance)
        .text(" m.\n");
    }
}
