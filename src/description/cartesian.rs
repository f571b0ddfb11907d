//! The Cartesian description: positions of all participants on the map, step by step.

use super::options::{Form, Options};
use super::parts::{NO_EGO, heading, name, on_the_map, sizes, subject};
use super::table::{self, Cell, Column, WHEN_AND_WHO, column};
use super::writer::{Subject, Writer};
use crate::scenario::{Motion, Scene, Window};

/// Motion in the coordinates of the map.
pub(super) const MOTION: &[Column] = &[
    column("x [m]", "x"),
    column("y [m]", "y"),
    column("heading [rad]", "heading"),
    column("v [m/s]", "velocity"),
    column("a [m/s²]", "acceleration"),
    column("lanelet", "lanelet"),
];

/// The cells under [`MOTION`].
pub(super) fn motion(scene: &Scene, motion: &Motion) -> [Cell; 6] {
    [
        Cell::Real(motion.pose.position.x),
        Cell::Real(motion.pose.position.y),
        Cell::Angle(motion.pose.heading),
        Cell::Real(motion.velocity),
        Cell::Real(motion.acceleration),
        Cell::lanelets(scene, motion),
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
        w.about(Subject::Ego, Some(step))
            .words("  ego ")
            .whole("id", scene.ego.id)
            .words(": ");
        on_the_map(w, scene, ego);
        w.words("\n");
        for (participant, motion) in options.near(scene, step) {
            w.about(subject(&participant), Some(step)).words("  ");
            name(w, &participant);
            w.words(": ");
            on_the_map(w, scene, motion);
            w.words("\n");
        }
    }
}

fn compact(w: &mut Writer, scene: &Scene, window: &Window, options: &Options) {
    table::titles(w, WHEN_AND_WHO, &[MOTION]);
    for step in options.steps(window) {
        table::begin(w, scene, step, None);
        let ego = scene.ego.track.at(step);
        let cells = ego.map(|ego| motion(scene, ego));
        table::cells(w, MOTION, cells.as_ref().map_or(&[], |c| c));
        w.words("\n");
        for (participant, there) in options.near(scene, step) {
            table::begin(w, scene, step, Some(&participant));
            table::cells(w, MOTION, &motion(scene, there));
            w.words("\n");
        }
    }
}
