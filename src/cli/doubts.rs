//! Warnings about a scenario and its ego, printed beside results.

use nearmiss_formats::Entry;
use nearmiss_scene::scenario::{Obstacle, ObstacleRole, Participant, Scenario, Scene, Severity};

/// Warnings about a scenario and its ego.
pub fn doubts(entry: &Entry, scene: &Scene) -> Vec<String> {
    let ego = &scene.ego;
    let doubts = ego
        .diagnostics
        .iter()
        .filter(|doubt| doubt.severity == Severity::Warning)
        .map(|doubt| {
            let line = match doubt.line {
                0 => String::new(),
                line => format!("line {line}: "),
            };
            format!("nearmiss: ego {}: {line}{}", ego.source, doubt.message)
        });
    let scenario = &scene.scenario;
    doubts
        .chain(without_lanes(entry, scenario))
        .chain(left_out(entry, scenario))
        .chain(with_gaps(entry, scenario))
        .chain(double(entry, scene))
        .collect()
}

/// Says that what needs lanes is missing.
fn without_lanes(entry: &Entry, scenario: &Scenario) -> Option<String> {
    scenario.network.lanelets.is_empty().then(|| {
        format!(
            "nearmiss: {}: no lanes, so measures and rules that need them are missing; see `nearmiss inspect`",
            entry.display()
        )
    })
}

/// Describes obstacles without a shape: results ignore them, and may be wrong for that.
fn left_out(entry: &Entry, scenario: &Scenario) -> Option<String> {
    let solid = |role| matches!(role, ObstacleRole::Static | ObstacleRole::Dynamic);
    let lost = |o: &&Obstacle| solid(o.role) && o.any_footprint().is_none();
    let ids = ids(scenario, lost);
    let count = scenario.obstacles.len();
    (!ids.is_empty()).then(|| {
        format!(
            "nearmiss: {}: {} of {count} obstacles ignored in measures and verdicts, as they have no usable shape: {}; \
             see `nearmiss inspect`",
            entry.display(),
            ids.len(),
            ids[..ids.len().min(MOST)].join(", ")
        )
    })
}

/// Names obstacles that are not recorded at each step between their first and their last: they count as absent there.
fn with_gaps(entry: &Entry, scenario: &Scenario) -> Option<String> {
    let gap = |o: &&Obstacle| {
        let steps = o.track().steps();
        !o.is_set_based() && (o.track().iter().count() as i64) < steps.end - steps.start
    };
    let ids = ids(scenario, gap);
    (!ids.is_empty()).then(|| {
        format!(
            "nearmiss: {}: obstacles with gaps in their tracks, absent in these: {}{}; see `nearmiss inspect`",
            entry.display(),
            ids[..ids.len().min(MOST)].join(", "),
            match ids.len().saturating_sub(MOST) {
                0 => String::new(),
                more => format!(" and {more} more"),
            }
        )
    })
}

/// Names an obstacle that is where the ego is at each step: the recording of the ego as one of the others.
fn double(entry: &Entry, scene: &Scene) -> Option<String> {
    let is_double = |other: &Participant<'_>| {
        let pairs = scene.ego.track.iter();
        let mut apart = pairs.filter_map(|(step, ego)| {
            Some((other.at(step)?.pose.position - ego.pose.position).norm())
        });
        let first = apart.next().is_some_and(|metres| metres < SAME_PLACE);
        first && apart.all(|metres| metres < SAME_PLACE)
    };
    let double = scene.participants().find(is_double)?;
    let id = double.obstacle.id;
    Some(format!(
        "nearmiss: {}: obstacle {id} is where the ego is at each step, so that they touch all the time; if it is the ego, \
         `--ego {id}` says so",
        entry.display()
    ))
}

/// Nearer to each other at each step two tracks are of one vehicle, metres.
const SAME_PLACE: f64 = 0.05;

/// Obstacles named in a warning.
const MOST: usize = 12;

fn ids(scenario: &Scenario, of: impl Fn(&&Obstacle) -> bool) -> Vec<String> {
    let obstacles = scenario.obstacles.iter().filter(of);
    obstacles.map(|o| o.id.to_string()).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use std::sync::Arc;

    use super::*;
    use nearmiss_formats::bundled;
    use nearmiss_scene::scenario::{ObstacleParts, Prediction, State};

    #[test]
    fn gaps_in_tracks_and_the_ego_among_the_others_are_named() {
        let entry = &bundled()[0];
        let mut scenario = (*entry.read().unwrap()).clone();
        let is_long = |o: &&Obstacle| o.role == ObstacleRole::Dynamic && o.states().count() > 30;
        let ego = scenario.obstacles.iter().find(is_long).unwrap().clone();
        let again = |id: i64, states: Vec<State>| {
            let parts = ObstacleParts {
                id,
                role: ego.role,
                kind: ego.kind,
                footprint: ego.footprint.clone(),
                initial: ego.initial.clone(),
                prediction: Prediction::Trajectory(states),
                signals: Vec::new(),
            };
            Obstacle::new(parts, 0.1)
        };
        let states: Vec<State> = ego.states().skip(1).cloned().collect();
        let of = |scenario: &Scenario| {
            let scene = Scene::with_obstacle_as_ego(Arc::new(scenario.clone()), ego.id).unwrap();
            doubts(entry, &scene).join("\n")
        };
        assert_eq!(of(&scenario), "");
        scenario.obstacles.push(again(9001, states.clone()));
        scenario
            .obstacles
            .push(again(9002, [&states[..5], &states[9..]].concat()));
        let told = of(&scenario);
        assert!(
            told.contains("obstacle 9001 is where the ego is at each step"),
            "{told}"
        );
        assert!(
            told.contains("gaps in their tracks, absent in these: 9002;"),
            "{told}"
        );
    }
}
