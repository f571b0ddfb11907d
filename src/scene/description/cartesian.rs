//! The Cartesian description: positions of all participants on the map, step by step.

use super::ego_lane::Lanes;
use super::options::{Form, Moment, Options, everyone};
use super::parts::{
    Cell, Column, NO_EGO, column, everyone_there, heading, lane, name, on_the_map, subject,
};
use super::writer::{Subject, Writer};
use super::{parts, road};
use crate::scenario::{Motion, Scene, Window};

/// Motion in the coordinates of the map.
pub(super) const MOTION: &[Column] = &[
    column("x [m]", "x"),
    column("y [m]", "y"),
    column("heading [rad]", "heading"),
    column("v [m/s]", "velocity"),
    column("a [m/s²]", "acceleration"),
];

/// What the lane is to the ego's.
const LANE: &[Column] = &[column("lane", "lane")];

/// The cells under [`MOTION`].
pub(super) fn motion(motion: &Motion) -> [Cell; 5] {
    [
        Cell::Real(motion.pose.position.x),
        Cell::Real(motion.pose.position.y),
        Cell::Angle(motion.pose.heading),
        Cell::Real(motion.velocity),
        Cell::Real(motion.acceleration),
    ]
}

pub(super) fn describe(w: &mut Writer, scene: &Scene, window: &Window, options: &Options) {
    w.relative_to(window.last());
    let described = options.described(scene, window);
    let steps: Vec<i64> = described.iter().map(|moment| moment.step).collect();
    let everyone = everyone(scene, window, options, &described);
    everyone_there(w, scene, window, &everyone);
    match options.form {
        Form::Prose => prose(w, scene, described),
        Form::Compact => compact(w, scene, described),
    }
    if options.road {
        road::describe_nearby(w, scene, &steps, options);
    }
}

fn prose(w: &mut Writer, scene: &Scene, described: Vec<Moment<'_>>) {
    let lanes = Lanes::new(scene);
    for Moment { step, near, .. } in described {
        heading(w, scene, step);
        let Some(ego) = scene.ego.track.at(step) else {
            w.text(NO_EGO);
            continue;
        };
        w.about(Subject::Ego, Some(step)).text("  ego: ");
        on_the_map(w, ego);
        lane(w, lanes.of_ego(ego));
        w.text("\n");
        for (participant, motion) in near {
            w.about(subject(&participant), Some(step)).text("  ");
            name(w, &participant);
            w.text(": ");
            on_the_map(w, motion);
            lane(w, lanes.relation(ego, motion));
            w.text("\n");
        }
    }
}

fn compact(w: &mut Writer, scene: &Scene, described: Vec<Moment<'_>>) {
    let lanes = Lanes::new(scene);
    parts::titles(w, &[MOTION, LANE]);
    for Moment { step, near, .. } in described {
        parts::begin(w, scene, step, None);
        let ego = scene.ego.track.at(step);
        let cells = ego.map(motion);
        parts::cells(w, MOTION, cells.as_ref().map_or(&[], |c| c));
        parts::cells(
            w,
            LANE,
            &[Cell::text(ego.and_then(|ego| lanes.of_ego(ego)))],
        );
        w.text("\n");
        for (participant, there) in near {
            parts::begin(w, scene, step, Some(&participant));
            parts::cells(w, MOTION, &motion(there));
            let words = ego.and_then(|ego| lanes.relation(ego, there));
            parts::cells(w, LANE, &[Cell::text(words)]);
            w.text("\n");
        }
    }
}
