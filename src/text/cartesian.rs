//! The Cartesian description: where everyone is on the map, step by step.

use std::fmt::Write;

use super::options::{NO_EGO, Options, heading, lanelets, name};
use crate::scenario::{Motion, Scene, Window};

pub(super) fn describe(scene: &Scene, window: &Window, options: &Options) -> String {
    let mut text = options.sizes(scene, window);
    for step in window.steps() {
        text.push('\n');
        text.push_str(&heading(scene, step));
        let Some(ego) = scene.ego.track.at(step) else {
            text.push_str(NO_EGO);
            continue;
        };
        let _ = writeln!(
            text,
            "  ego {}: {}",
            scene.ego.id,
            state(scene, ego, options)
        );
        for (participant, motion) in options.near(scene, step) {
            let _ = writeln!(
                text,
                "  {}: {}",
                name(&participant),
                state(scene, motion, options)
            );
        }
    }
    text
}

fn state(scene: &Scene, motion: &Motion, options: &Options) -> String {
    let number = |value| options.number(value);
    format!(
        "at ({}, {}) m, heading {} rad, velocity {} m/s, acceleration {} m/s², {}",
        number(motion.pose.position.x),
        number(motion.pose.position.y),
        options.angle(motion.pose.heading),
        number(motion.velocity),
        number(motion.acceleration),
        lanelets(scene, motion),
    )
}
