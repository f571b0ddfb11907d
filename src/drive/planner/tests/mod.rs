//! Tests of the planner's parts.
#![allow(clippy::unwrap_used)]

mod emergency_stops;
mod goals;
mod regions;
mod sampling;
mod traffic;

use super::ReferenceTrack;
use nearmiss_formats::bundled;

/// The guide and the steps' length of a bundled scenario.
fn guide(name: &str) -> (ReferenceTrack, f64) {
    let all = bundled();
    let entry = all.iter().find(|e| e.name.contains(name)).unwrap();
    let scenario = entry.read().unwrap();
    let graph = scenario.network.lane_graph(None);
    let guide =
        ReferenceTrack::for_problem(&scenario, &graph, &scenario.planning_problems[0]).unwrap();
    (guide, scenario.dt())
}
