//! What OpenSCENARIO has no place for: planning problems, intersections, place and authors, from the document that an
//! export keeps among its properties.

use crate::formats::commonroad::read;
use crate::scenario::{LaneletNetwork, PlanningProblem, Position, Scenario};

/// Puts what was kept into a scenario. What names lanelets holds where these are those of the export.
///
/// A document that cannot be read tells nothing: the scenario stays as it is.
pub fn restore(scenario: &mut Scenario, document: &str, lanelets_are_kept: bool) {
    let Ok(kept) = read(document.as_bytes(), "") else {
        return;
    };
    scenario.location = kept.location;
    for (name, value) in kept.header.attributes {
        scenario.header.attributes.insert(name, value);
    }
    let holds = |p: &PlanningProblem| lanelets_are_kept || !names_lanelets(p);
    if !kept.planning_problems.is_empty() && kept.planning_problems.iter().all(holds) {
        scenario.planning_problems = kept.planning_problems;
    }
    if lanelets_are_kept {
        let roads = std::mem::take(&mut scenario.network);
        let intersections = kept.network.intersections;
        scenario.network =
            LaneletNetwork::new(roads.lanelets, roads.signs, roads.lights, intersections);
    }
}

fn names_lanelets(problem: &PlanningProblem) -> bool {
    let mut goals = problem.goals.iter().flat_map(|g| &g.positions);
    goals.any(|p| matches!(p, Position::Lanelets(_)))
}
