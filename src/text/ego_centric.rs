//! The ego-centric description: where everyone is and how they move, seen from the ego.

use std::fmt::Write;

use super::options::{NO_EGO, Options, heading, lanelets, name};
use crate::metrics::{Direction, Encounter, Relation};
use crate::scenario::{Scene, Window};

/// Slower than this, m/s, is no motion worth a sentence.
const NOTICEABLE: f64 = 0.05;

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
            "  The ego drives at {} m/s with acceleration {} m/s², {}.",
            options.number(ego.velocity),
            options.number(ego.acceleration),
            lanelets(scene, ego),
        );
        let near = options.near(scene, step);
        if near.is_empty() {
            let radius = options.number(options.radius);
            let _ = writeln!(text, "  Nobody is within {radius} m.");
        }
        for (participant, motion) in near {
            if let Some(encounter) = Encounter::at(scene, &participant, step) {
                let who = name(&participant);
                let relation = encounter.relation();
                let place = lanelets(scene, motion);
                let _ = writeln!(text, "  {}", sentence(&who, &relation, &place, options));
            }
        }
    }
    text
}

fn sentence(who: &str, relation: &Relation, place: &str, options: &Options) -> String {
    let number = |value| options.number(value);
    format!(
        "{who} ({}, {place}): gap longitudinal {} m, lateral {} m; relative velocity longitudinal {} m/s, \
         lateral {} m/s; relative acceleration longitudinal {} m/s², lateral {} m/s². {}",
        relation.direction.name(),
        number(relation.gap_long),
        number(relation.gap_lat),
        number(relation.velocity.x),
        number(relation.velocity.y),
        number(relation.acceleration.x),
        number(relation.acceleration.y),
        motion(relation),
    )
}

fn motion(relation: &Relation) -> String {
    if relation.direction == Direction::Contact {
        return "It touches the ego.".into();
    }
    let long = match (side(relation.gap_long), side(relation.velocity.x)) {
        (0, 0) => "It is level with the ego and stays so",
        (0, 1) => "It is level with the ego and moves forward past it",
        (0, _) => "It is level with the ego and drops back past it",
        (1, -1) => "Ahead of the ego, the gap is closing",
        (1, 1) => "Ahead of the ego, the gap is opening",
        (1, _) => "Ahead of the ego, the gap stays",
        (_, 1) => "Behind the ego, the gap is closing",
        (_, -1) => "Behind the ego, the gap is opening",
        _ => "Behind the ego, the gap stays",
    };
    let lat = match (side(relation.gap_lat), side(relation.velocity.y)) {
        (0, 0) => "it is in line with the ego and stays so",
        (0, 1) => "it is in line with the ego and drifts to the left",
        (0, _) => "it is in line with the ego and drifts to the right",
        (1, -1) => "from the left it comes nearer sideways",
        (1, 1) => "on the left it moves away sideways",
        (1, _) => "on the left it keeps its sideways distance",
        (_, 1) => "from the right it comes nearer sideways",
        (_, -1) => "on the right it moves away sideways",
        _ => "on the right it keeps its sideways distance",
    };
    format!("{long}; {lat}.")
}

/// −1, 0 or 1; what is hardly noticeable is 0.
fn side(value: f64) -> i8 {
    if value > NOTICEABLE {
        1
    } else if value < -NOTICEABLE {
        -1
    } else {
        0
    }
}
