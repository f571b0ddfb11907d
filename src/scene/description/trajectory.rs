//! The trajectory description: motions of one obstacle and the ego, and the road they used.
//!
//! Its steps and times are those of the recording, and it names lanelets: the motion that is asked for is given in them.

use std::collections::BTreeSet;

use super::cartesian::{MOTION, motion};
use super::ego_centric::relative;
use super::nearby::VisibleObstacle;
use super::options::{Form, Options};
use super::parts::{
    self, Cell, Column, NO_EGO, column, everyone_there, heading, name, on_lanelets, on_the_map,
    subject,
};
use super::road;
use super::writer::{Subject, Writer};
use crate::metrics::Encounter;
use crate::scenario::{Motion, Participant, Scene, Window};

/// The lanelets under a participant.
const LANELET: &[Column] = &[column("lanelet", "lanelet")];

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
    everyone_there(w, scene, window, std::slice::from_ref(who));
    let steps = options.steps(window);
    match options.form {
        Form::Prose => prose(w, scene, who, &steps, options),
        Form::Compact => compact(w, scene, who, &steps, options),
    }
    let mut places = Vec::new();
    for &step in &steps {
        let both = [scene.ego.track.at(step), known(who, step)];
        places.extend(both.into_iter().flatten().map(|m| m.pose.position));
    }
    let under: BTreeSet<i64> = places
        .iter()
        .flat_map(|p| scene.scenario.network.lanelets_at(p))
        .collect();
    road::describe(w, scene, &under, &places, options.radius);
}

/// Its motion at a step; a region of an occupancy set has none.
fn known<'a>(who: &Participant<'a>, step: i64) -> Option<&'a Motion> {
    who.at(step).filter(|_| !who.obstacle.is_occupancy_at(step))
}

fn encounter<'a>(scene: &'a Scene, who: &Participant<'a>, step: i64) -> Option<Encounter<'a>> {
    Encounter::at(scene, who, step).filter(|encounter| !encounter.is_with_occupancy())
}

fn prose(w: &mut Writer, scene: &Scene, who: &Participant<'_>, steps: &[i64], options: &Options) {
    for &step in steps {
        heading(w, scene, step);
        match scene.ego.track.at(step) {
            Some(ego) => {
                w.about(Subject::Ego, Some(step)).text("  ego: ");
                on_a_lanelet(w, scene, ego);
                w.text("\n");
            }
            None => {
                w.text(NO_EGO);
            }
        }
        w.about(subject(who), Some(step)).text("  ");
        name(w, who);
        match known(who, step) {
            Some(motion) => {
                w.text(": ");
                on_a_lanelet(w, scene, motion);
            }
            None => {
                w.text(" is not there at this step");
            }
        }
        w.text("\n");
        if let Some(encounter) = encounter(scene, who, step) {
            let seen = VisibleObstacle::new(&encounter, options);
            w.text("  seen from the ego: ")
                .text(seen.direction.name())
                .text(", distance ")
                .number("distance", seen.distance)
                .text(" m; ");
            relative(w, &seen.relation);
            w.text("\n");
        }
    }
}

/// A motion on the map and the lanelets under it.
fn on_a_lanelet(w: &mut Writer, scene: &Scene, motion: &Motion) {
    on_the_map(w, motion);
    w.text(", ");
    on_lanelets(w, scene, motion);
}

fn compact(w: &mut Writer, scene: &Scene, who: &Participant<'_>, steps: &[i64], options: &Options) {
    parts::titles(w, &[MOTION, LANELET, RELATION]);
    for &step in steps {
        parts::begin(w, scene, step, None);
        on_the_map_cells(w, scene, scene.ego.track.at(step));
        parts::cells(w, RELATION, &[]);
        w.text("\n");
        parts::begin(w, scene, step, Some(who));
        on_the_map_cells(w, scene, known(who, step));
        let cells = encounter(scene, who, step).map(|encounter| {
            let seen = VisibleObstacle::new(&encounter, options);
            let relation = &seen.relation;
            [
                Cell::Words(seen.direction.name()),
                Cell::Real(seen.distance),
                Cell::Real(relation.gap_long),
                Cell::Real(relation.gap_lat),
                Cell::Real(relation.velocity.x),
                Cell::Real(relation.velocity.y),
            ]
        });
        parts::cells(w, RELATION, cells.as_ref().map_or(&[], |c| c));
        w.text("\n");
    }
}

fn on_the_map_cells(w: &mut Writer, scene: &Scene, there: Option<&Motion>) {
    let cells = there.map(motion);
    parts::cells(w, MOTION, cells.as_ref().map_or(&[], |c| c));
    let lanelet = there.map(|there| Cell::lanelets(scene, there));
    parts::cells(w, LANELET, lanelet.as_slice());
}
