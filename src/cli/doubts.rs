//! Warnings about a scenario and its ego, printed beside results.

use crate::formats::Entry;
use crate::scenario::{Obstacle, ObstacleRole, Scenario, Scene, Severity};

/// Warnings about a scenario and its ego.
pub fn doubts(entry: &Entry, scene: &Scene) -> Vec<String> {
    let ego = &scene.ego;
    let doubts = ego.diagnostics.iter();
    let doubts = doubts.filter(|doubt| doubt.severity == Severity::Warning);
    let doubts = doubts.map(|doubt| {
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
    let ids: Vec<String> = scenario
        .obstacles
        .iter()
        .filter(lost)
        .map(|o| o.id.to_string())
        .collect();
    let count = scenario.obstacles.len();
    (!ids.is_empty()).then(|| {
        format!(
            "nearmiss: {}: {} of {count} obstacles ignored in measures and verdicts, as they have no usable shape: {}; \
             see `nearmiss inspect`",
            entry.display(),
            ids.len(),
            ids[..ids.len().min(12)].join(", ")
        )
    })
}
