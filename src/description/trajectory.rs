//! The trajectory description: motions of one obstacle and the ego, and the road they used.

use std::collections::BTreeSet;

use super::cartesian::{MOTION, motion};
use super::ego_centric::relative;
use super::options::{Form, Options};
use super::parts::{NO_EGO, heading, name, on_the_map, sizes, subject};
use super::road;
use super::seen::direction;
use super::table::{self, Cell, Column, WHEN_AND_WHO, column};
use super::writer::{Subject, Writer};
use crate::metrics::Encounter;
use crate::scenario::{Participant, Scene, Window};

/// Relation of the obstacle to the ego.
const RELATION: &[Column] = &[
    column("direction", "direction"),
    column("distance [m]", "distance"),
    column("gap long [m]", "gap_long"),
    column("gap lat [m]", "gap_lat"),
    column("v rel long [m/s]", "v_rel_long"),
    column("v rel lat [m/s]", "v_rel_lat"),
];

pub(super) fn describe(
    w: &mut Writer,
    scene: &Scene,
    who: &Participant<'_>,
    window: &Window,
    options: &Options,
) {
    sizes(w, scene, std::slice::from_ref(who));
    let steps = options.steps(window);
    match options.form {
        Form::Prose => prose(w, scene, who, &steps, options),
        Form::Compact => compact(w, scene, who, &steps, options),
    }
    let mut places = Vec::new();
    for &step in &steps {
        let both = [scene.ego.track.at(step), who.at(step)];
        places.extend(both.into_iter().flatten().map(|m| m.pose.position));
    }
    let under: BTreeSet<i64> = places
        .iter()
        .flat_map(|p| scene.scenario.network.lanelets_at(p))
        .collect();
    road::describe(w, scene, &under, &places, options.radius);
}

fn prose(w: &mut Writer, scene: &Scene, who: &Participant<'_>, steps: &[i64], options: &Options) {
    for &step in steps {
        heading(w, scene, step);
        match scene.ego.track.at(step) {
            Some(ego) => {
                w.about(Subject::Ego, Some(step))
                    .words("  ego ")
                    .whole("id", scene.ego.id)
                    .words(": ");
                on_the_map(w, scene, ego);
                w.words("\n");
            }
            None => {
                w.words(NO_EGO);
            }
        }
        w.about(subject(who), Some(step)).words("  ");
        name(w, who);
        match who.at(step) {
            Some(motion) => {
                w.words(": ");
                on_the_map(w, scene, motion);
            }
            None => {
                w.words(" is not there at this step");
            }
        }
        w.words("\n");
        if let Some(encounter) = Encounter::at(scene, who, step) {
            let relation = encounter.relation();
            w.words("  seen from the ego: ")
                .words(direction(&encounter, &relation, options).name())
                .words(", distance ")
                .number("distance", encounter.distance())
                .words(" m; ");
            relative(w, &relation);
            w.words("\n");
        }
    }
}

fn compact(w: &mut Writer, scene: &Scene, who: &Participant<'_>, steps: &[i64], options: &Options) {
    table::titles(w, WHEN_AND_WHO, &[MOTION, RELATION]);
    for &step in steps {
        table::begin(w, scene, step, None);
        let ego = scene.ego.track.at(step).map(|ego| motion(scene, ego));
        table::cells(w, MOTION, ego.as_ref().map_or(&[], |c| c));
        table::cells(w, RELATION, &[]);
        w.words("\n");
        table::begin(w, scene, step, Some(who));
        let other = who.at(step).map(|other| motion(scene, other));
        table::cells(w, MOTION, other.as_ref().map_or(&[], |c| c));
        let cells = Encounter::at(scene, who, step).map(|encounter| {
            let relation = encounter.relation();
            [
                Cell::Words(direction(&encounter, &relation, options).name()),
                Cell::Real(encounter.distance()),
                Cell::Real(relation.gap_long),
                Cell::Real(relation.gap_lat),
                Cell::Real(relation.velocity.x),
                Cell::Real(relation.velocity.y),
            ]
        });
        table::cells(w, RELATION, cells.as_ref().map_or(&[], |c| c));
        w.words("\n");
    }
}
