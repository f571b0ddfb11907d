//! The ego-centric description: positions and motions of all participants relative to the ego.

use super::motion_words;
use super::options::{Form, Options};
use super::parts::{NO_EGO, ego_drives, heading, name, no_obstacles, on_lanelets, sizes, subject};
use super::seen::direction;
use super::table::{self, Cell, Column, WHEN_AND_WHO, column};
use super::writer::Writer;
use crate::metrics::{Encounter, Relation};
use crate::scenario::{Motion, Scene, Window};

/// Own motion, of the ego only.
pub(super) const OWN: &[Column] = &[
    column("lanelet", "lanelet"),
    column("v [m/s]", "velocity"),
    column("a [m/s²]", "acceleration"),
];

/// The relation of each obstacle to the ego.
const RELATION: &[Column] = &[
    column("direction", "direction"),
    column("gap long [m]", "gap_long"),
    column("gap lat [m]", "gap_lat"),
    column("v rel long [m/s]", "v_rel_long"),
    column("v rel lat [m/s]", "v_rel_lat"),
    column("a rel long [m/s²]", "a_rel_long"),
    column("a rel lat [m/s²]", "a_rel_lat"),
];

/// The cells of the ego under [`OWN`].
pub(super) fn own(scene: &Scene, ego: &Motion) -> [Cell; 3] {
    [
        Cell::lanelets(scene, ego),
        Cell::Real(ego.velocity),
        Cell::Real(ego.acceleration),
    ]
}

pub(super) fn describe(w: &mut Writer, scene: &Scene, window: &Window, options: &Options) {
    sizes(w, scene, &options.everyone(scene, window));
    match options.form {
        Form::Prose => prose(w, scene, window, options),
        Form::Compact => compact(w, scene, window, options),
    }
}

fn prose(w: &mut Writer, scene: &Scene, window: &Window, options: &Options) {
    for step in options.steps(window) {
        heading(w, scene, step);
        let Some(ego) = scene.ego.track.at(step) else {
            w.words(NO_EGO);
            continue;
        };
        ego_drives(w, scene, ego, step);
        let near = options.near(scene, step);
        if near.is_empty() {
            no_obstacles(w, options.radius);
        }
        for (participant, motion) in near {
            let Some(encounter) = Encounter::at(scene, &participant, step) else {
                continue;
            };
            let relation = encounter.relation();
            w.about(subject(&participant), Some(step)).words("  ");
            name(w, &participant);
            w.words(" (")
                .words(direction(&encounter, &relation, options).name())
                .words(", ");
            on_lanelets(w, scene, motion);
            w.words("): ");
            relative(w, &relation);
            w.words("; relative acceleration longitudinal ")
                .number("a_rel_long", relation.acceleration.x)
                .words(" m/s², lateral ")
                .number("a_rel_lat", relation.acceleration.y)
                .words(" m/s². ")
                .words(&motion_words::describe_motion(&relation, options.contact))
                .words("\n");
        }
    }
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

fn compact(w: &mut Writer, scene: &Scene, window: &Window, options: &Options) {
    table::titles(w, WHEN_AND_WHO, &[OWN, RELATION]);
    for step in options.steps(window) {
        table::begin(w, scene, step, None);
        let ego = scene.ego.track.at(step).map(|ego| own(scene, ego));
        table::cells(w, OWN, ego.as_ref().map_or(&[], |c| c));
        table::cells(w, RELATION, &[]);
        w.words("\n");
        for (participant, motion) in options.near(scene, step) {
            let Some(encounter) = Encounter::at(scene, &participant, step) else {
                continue;
            };
            let relation = encounter.relation();
            table::begin(w, scene, step, Some(&participant));
            table::cells(w, OWN, &[Cell::lanelets(scene, motion)]);
            let cells = [
                Cell::Words(direction(&encounter, &relation, options).name()),
                Cell::Real(relation.gap_long),
                Cell::Real(relation.gap_lat),
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
