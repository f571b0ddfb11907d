//! The ego-centric description: positions and motions of all participants relative to the ego, in numbers or a sentence.

use super::ego_lane::Lanes;
use super::nearby::{self, VisibleObstacle};
use super::options::{Form, Moment, Options, everyone};
use super::parts::{
    self, Cell, Column, NO_EGO, column, ego_moves, everyone_there, heading, name_and_place,
    no_obstacles,
};
use super::writer::{Writer, written_degrees};
use crate::metrics::{Direction, Encounter, Relation};
use crate::scenario::{Motion, Scene, Window};

/// The lane, and own motion of the ego only.
pub(super) const OWN: &[Column] = &[
    column("lane", "lane"),
    column("v [m/s]", "velocity"),
    column("a [m/s²]", "acceleration"),
];

/// The relation of each obstacle to the ego.
const RELATION: &[Column] = &[
    column("direction", "direction"),
    column("distance [m]", "distance"),
    column("gap long [m]", "gap_long"),
    column("gap lat [m]", "gap_lat"),
    column("heading [°]", "heading_rel"),
    column("v rel long [m/s]", "v_rel_long"),
    column("v rel lat [m/s]", "v_rel_lat"),
    column("a rel long [m/s²]", "a_rel_long"),
    column("a rel lat [m/s²]", "a_rel_lat"),
];

/// The cells of the ego under [`OWN`].
pub(super) fn own(lanes: &Lanes<'_>, ego: &Motion) -> [Cell; 3] {
    [
        Cell::text(lanes.of_ego(ego)),
        Cell::Real(ego.velocity),
        Cell::Real(ego.acceleration),
    ]
}

pub(super) fn describe(w: &mut Writer, scene: &Scene, window: &Window, options: &Options) {
    w.relative_to(window.last());
    let described = options.described(scene, window);
    let everyone = everyone(scene, window, options, &described);
    everyone_there(w, scene, window, &everyone);
    let write = match options.form {
        Form::Prose => prose,
        Form::Compact => compact,
    };
    write(w, scene, described, options);
    if options.nearest && !everyone.is_empty() {
        nearby::heading(w, scene, window);
        let moments = nearby::nearest_moments(scene, window, &everyone);
        write(w, scene, moments, options);
    }
}

fn prose(w: &mut Writer, scene: &Scene, described: Vec<Moment<'_>>, options: &Options) {
    let lanes = Lanes::new(scene);
    for Moment {
        step,
        near,
        left_out,
    } in described
    {
        heading(w, scene, step);
        let Some(ego) = scene.ego.track.at(step) else {
            w.text(NO_EGO);
            continue;
        };
        ego_moves(w, &lanes, ego, step);
        if near.is_empty() && !left_out {
            no_obstacles(w, options.radius);
        }
        for (participant, motion) in near {
            let Some(encounter) = Encounter::at(scene, &participant, step) else {
                continue;
            };
            let seen = VisibleObstacle::new(&encounter, options);
            name_and_place(w, &participant, step, &seen, lanes.relation(ego, motion));
            w.text("distance ")
                .number("distance", seen.distance)
                .text(" m; ");
            relative(w, &seen.relation);
            w.text("; ");
            turned(w, seen.heading);
            w.text("; relative acceleration longitudinal ")
                .number("a_rel_long", seen.relation.acceleration.x)
                .text(" m/s², lateral ")
                .number("a_rel_lat", seen.relation.acceleration.y)
                .text(" m/s². ");
            let words = describe_motion(w, &seen, options.contact);
            w.text(&words).text("\n");
        }
    }
}

/// A heading relative to the ego's, to the side that it is written with.
pub(super) fn turned(w: &mut Writer, degrees: f64) {
    w.text("heading ").degrees("heading_rel", degrees.abs());
    w.text(match written_degrees(degrees) {
        // Neither side.
        written if written == 0.0 || written.abs() == 180.0 => "°",
        written if written > 0.0 => "° to the left",
        _ => "° to the right",
    });
}

/// Describes gaps and relative velocities.
pub(super) fn relative(w: &mut Writer, relation: &Relation) {
    w.text("gap longitudinal ")
        .number("gap_long", relation.gap_long)
        .text(" m, lateral ")
        .number("gap_lat", relation.gap_lat)
        .text(" m; relative velocity longitudinal ")
        .number("v_rel_long", relation.velocity.x)
        .text(" m/s, lateral ")
        .number("v_rel_lat", relation.velocity.y)
        .text(" m/s");
}

fn compact(w: &mut Writer, scene: &Scene, described: Vec<Moment<'_>>, options: &Options) {
    let lanes = Lanes::new(scene);
    parts::titles(w, &[OWN, RELATION]);
    for Moment { step, near, .. } in described {
        parts::begin(w, scene, step, None);
        let ego = scene.ego.track.at(step);
        let cells = ego.map(|ego| own(&lanes, ego));
        parts::cells(w, OWN, cells.as_ref().map_or(&[], |c| c));
        parts::cells(w, RELATION, &[]);
        w.text("\n");
        for (participant, motion) in near {
            let Some((ego, encounter)) = ego.zip(Encounter::at(scene, &participant, step)) else {
                continue;
            };
            let seen = VisibleObstacle::new(&encounter, options);
            parts::begin(w, scene, step, Some(&participant));
            parts::cells(w, OWN, &[Cell::text(lanes.relation(ego, motion))]);
            let relation = &seen.relation;
            let cells = [
                Cell::Words(seen.direction.name()),
                Cell::Real(seen.distance),
                Cell::Real(relation.gap_long),
                Cell::Real(relation.gap_lat),
                Cell::Degrees(seen.heading),
                Cell::Real(relation.velocity.x),
                Cell::Real(relation.velocity.y),
                Cell::Real(relation.acceleration.x),
                Cell::Real(relation.acceleration.y),
            ];
            parts::cells(w, RELATION, &cells);
            w.text("\n");
        }
    }
}

/// The sentence; it follows from the numbers as they are written, so that the two never contradict each other.
///
/// Contact is named only with `contact`; otherwise the sentence about touching bodies says only how the other moves.
pub(super) fn describe_motion(w: &Writer, seen: &VisibleObstacle, contact: bool) -> String {
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
    let lat = sideways("it is in line with the ego", gap_lat, v_lat);
    format!("{long}; {lat}.")
}

/// Where it is across the ego's way and how it moves there; `in_line` says that it is beside neither side.
fn sideways(in_line: &str, place: i8, velocity: i8) -> String {
    match (place, velocity) {
        (0, 0) => format!("{in_line} and stays so"),
        (0, 1) => format!("{in_line} and moves to the left"),
        (0, _) => format!("{in_line} and moves to the right"),
        (1, -1) => "on the left it comes nearer sideways".into(),
        (1, 1) => "on the left it moves away sideways".into(),
        (1, _) => "on the left it keeps its sideways distance".into(),
        (_, 1) => "on the right it comes nearer sideways".into(),
        (_, -1) => "on the right it moves away sideways".into(),
        _ => "on the right it keeps its sideways distance".into(),
    }
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
    let lat = sideways("its centre is in line with the ego's", sign(d), sign(v_d));
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
