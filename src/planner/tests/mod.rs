//! Tests of the planner's parts.
#![allow(clippy::unwrap_used)]

mod aims;
mod parts;
mod regions;
mod stops;
mod traffic;

use super::Guide;
use crate::scenario::bundled;

/// The guide and the steps' length of a bundled scenario.
fn guide(name: &str) -> (Guide, f64) {
    let all = bundled();
    let entry = all.iter().find(|e| e.name.contains(name)).unwrap();
    let scenario = entry.read().unwrap();
    let graph = scenario.network.lane_graph(None);
    let guide = Guide::of(&scenario, &graph, &scenario.planning_problems[0]).unwrap();
    (guide, scenario.dt())
}
