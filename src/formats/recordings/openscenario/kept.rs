//! What OpenSCENARIO has no place for: planning problems, signs, lights, intersections, place and authors, from the
//! document that an export keeps among its properties.

use std::collections::HashMap;

use crate::commonroad::read;
use crate::opendrive::signals::{signal_keys, speed_limit};
use crate::recordings::opendrive::KeptSigns;
use nearmiss_scene::scenario::{LaneletNetwork, PlanningProblem, Position, Scenario, TrafficLight};

/// Puts what was kept into a scenario. `signs` are there where its lanelets are those of the export; what names lanelets
/// holds only then.
///
/// A document that cannot be read tells nothing: the scenario stays as it is.
pub fn restore(scenario: &mut Scenario, document: &str, signs: Option<KeptSigns>) {
    let Ok(kept) = read(document.as_bytes(), "") else {
        return;
    };
    scenario.location = kept.location;
    for (name, value) in kept.header.attributes {
        scenario.header.attributes.insert(name, value);
    }
    let holds = |p: &PlanningProblem| signs.is_some() || !names_lanelets(p);
    if !kept.planning_problems.is_empty() && kept.planning_problems.iter().all(holds) {
        scenario.planning_problems = kept.planning_problems;
    }
    let Some(signs) = signs else {
        return;
    };
    let roads = std::mem::take(&mut scenario.network);
    scenario.network = match with_signs(&roads, &kept.network, signs) {
        Some(network) => network,
        None => LaneletNetwork::new(
            roads.lanelets,
            roads.signs,
            roads.lights,
            kept.network.intersections,
        ),
    };
}

/// The roads with signs and lights as they were before the export; `None` where the files tell others now.
fn with_signs(
    roads: &LaneletNetwork,
    kept: &LaneletNetwork,
    mut signs: KeptSigns,
) -> Option<LaneletNetwork> {
    let mut lanelets = roads.lanelets.clone();
    let mut limits = HashMap::new();
    for lanelet in &mut lanelets {
        let of = signs.lanelets.remove(&lanelet.id)?;
        [lanelet.signs, lanelet.lights] = of.own;
        if let Some(line) = &mut lanelet.stop_line {
            [line.signs, line.lights] = of.stop_line;
        }
        limits.insert(lanelet.id, of.limit);
    }
    let network = LaneletNetwork::new(
        lanelets,
        kept.signs.clone(),
        kept.lights.clone(),
        kept.intersections.clone(),
    );
    let same_limit = |id: i64, own: Option<f64>| match (limits.get(&id).copied().flatten(), own) {
        (Some(a), Some(b)) => (a - b).abs() < SAME_SPEED,
        (a, b) => a.is_none() && b.is_none(),
    };
    let mut all = network.lanelets.iter();
    let is_unchanged = signal_keys(&network) == signs.signals
        && all.all(|l| same_limit(l.id, speed_limit(&network, l)))
        && shows_the_same(&roads.lights, &network.lights);
    is_unchanged.then_some(network)
}

/// Speeds that differ by less are the same, m/s: files are rounded.
const SAME_SPEED: f64 = 1e-3;

/// Whether the lights that were read show at each step what those with the same ids show.
fn shows_the_same(read: &[TrafficLight], kept: &[TrafficLight]) -> bool {
    read.iter().all(|light| {
        let before = kept.iter().find(|k| k.id == light.id);
        before.is_some_and(|before| {
            let whole: i64 = before
                .cycle
                .iter()
                .map(|p| p.duration.clamp(0, LONGEST))
                .sum();
            (0..=whole.min(LONGEST)).all(|step| light.color_at(step) == before.color_at(step))
        })
    })
}

/// No longer cycle is compared to its end, steps.
const LONGEST: i64 = 10_000;

fn names_lanelets(problem: &PlanningProblem) -> bool {
    let mut goals = problem.goals.iter().flat_map(|g| &g.positions);
    goals.any(|p| matches!(p, Position::Lanelets(_)))
}
