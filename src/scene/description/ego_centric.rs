//! The ego-centric description: positions and motions of all participants relative to the ego.

use super::lanes::Lanes;
use super::motion_words;
use super::options::{Form, Moment, Options, everyone};
use super::overview;
use super::parts::{NO_EGO, ego_moves, everyone_there, heading, name_and_place, no_obstacles};
use super::seen::Seen;
use super::table::{self, Cell, Column, column};
use super::writer::{Writer, written_degrees};
use crate::metrics::{Encounter, Relation};
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
        Cell::words(lanes.of_ego(ego)),
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
        overview::heading(w, scene, window);
        let moments = overview::nearest_moments(scene, window, &everyone);
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
            w.words(NO_EGO);
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
            let seen = Seen::new(&encounter, options);
            name_and_place(w, &participant, step, &seen, lanes.of(ego, motion));
            w.words("distance ")
                .number("distance", seen.distance)
                .words(" m; ");
            relative(w, &seen.relation);
            w.words("; ");
            turned(w, seen.heading);
            w.words("; relative acceleration longitudinal ")
                .number("a_rel_long", seen.relation.acceleration.x)
                .words(" m/s², lateral ")
                .number("a_rel_lat", seen.relation.acceleration.y)
                .words(" m/s². ");
            let words = motion_words::describe_motion(w, &seen, options.contact);
            w.words(&words).words("\n");
        }
    }
}

/// A heading relative to the ego's, to the side that it is written with.
pub(super) fn turned(w: &mut Writer, degrees: f64) {
    w.words("heading ").degrees("heading_rel", degrees.abs());
    w.words(match written_degrees(degrees) {
        // Neither side.
        written if written == 0.0 || written.abs() == 180.0 => "°",
        written if written > 0.0 => "° to the left",
        _ => "° to the right",
    });
}

/// Describes gaps and relative velocities.
pub(super) fn relative(w: &mut Writer, relation: &Relation) {
    w.words("gap longitudinal ")
        .number("gap_long", relation.gap_long)
        .words(" m, lateral ")
        .number("gap_lat", relation.gap_lat)
        .words(" m; relative velocity longitudinal ")
        .number("v_rel_long", relation.velocity.x)
        .words(" m/s, lateral ")
        .number("v_rel_lat", relation.velocity.y)
        .words(" m/s");
}

fn compact(w: &mut Writer, scene: &Scene, described: Vec<Moment<'_>>, options: &Options) {
    let lanes = Lanes::new(scene);
    table::titles(w, &[OWN, RELATION]);
    for Moment { step, near, .. } in described {
        table::begin(w, scene, step, None);
        let ego = scene.ego.track.at(step);
        let cells = ego.map(|ego| own(&lanes, ego));
        table::cells(w, OWN, cells.as_ref().map_or(&[], |c| c));
        table::cells(w, RELATION, &[]);
        w.words("\n");
        for (participant, motion) in near {
            let Some((ego, encounter)) = ego.zip(Encounter::at(scene, &participant, step)) else {
                continue;
            };
            let seen = Seen::new(&encounter, options);
            table::begin(w, scene, step, Some(&participant));
            table::cells(w, OWN, &[Cell::words(lanes.of(ego, motion))]);
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
            table::cells(w, RELATION, &cells);
            w.words("\n");
        }
    }
}
