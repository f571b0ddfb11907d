//! References between elements: those to nothing are named.

use std::collections::HashSet;

use super::report::{At, Report};
use crate::scenario::{Lanelet, LaneletNetwork, PlanningProblem};

/// What can be referred to.
struct Known {
    lanelets: HashSet<i64>,
    signs: HashSet<i64>,
    lights: HashSet<i64>,
    incomings: HashSet<i64>,
}

/// Warns of every reference to an element that is not there; `road` and `planning` are the messages they are in.
pub(super) fn check(
    report: &mut Report,
    network: &LaneletNetwork,
    road: &At<'_>,
    problems: &[PlanningProblem],
    planning: &At<'_>,
) {
    let incomings = network.intersections.iter().flat_map(|i| &i.incomings);
    let known = Known {
        lanelets: network.lanelets.iter().map(|l| l.id).collect(),
        signs: network.signs.iter().map(|s| s.id).collect(),
        lights: network.lights.iter().map(|l| l.id).collect(),
        incomings: incomings.map(|i| i.id).collect(),
    };
    for (i, lanelet) in network.lanelets.iter().enumerate() {
        self::lanelet(report, &road.nth("lanelets", i), lanelet, &known);
    }
    for (i, intersection) in network.intersections.iter().enumerate() {
        let at = road.nth("intersections", i);
        for (j, road) in intersection.incomings.iter().enumerate() {
            let at = at.nth("incomings", j);
            for ids in [&road.lanelets, &road.right, &road.straight, &road.left] {
                missing(report, &at, "lanelet", ids, &known.lanelets);
            }
            let left = road.is_left_of.as_slice();
            missing(report, &at, "incoming road", left, &known.incomings);
        }
        missing(
            report,
            &at,
            "lanelet",
            &intersection.crossings,
            &known.lanelets,
        );
    }
    for (i, problem) in problems.iter().enumerate() {
        let at = planning.nth("planning_problems", i);
        for (j, goal) in problem.goals.iter().enumerate() {
            let at = at.nth("goal_states", j);
            missing(report, &at, "lanelet", &goal.lanelets(), &known.lanelets);
        }
    }
}

fn lanelet(report: &mut Report, at: &At<'_>, lanelet: &Lanelet, known: &Known) {
    let beside = [&lanelet.adjacent_left, &lanelet.adjacent_right];
    let beside: Vec<i64> = beside.into_iter().flatten().map(|a| a.id).collect();
    for ids in [&lanelet.predecessors, &lanelet.successors, &beside] {
        missing(report, at, "lanelet", ids, &known.lanelets);
    }
    missing(report, at, "sign", &lanelet.signs, &known.signs);
    missing(report, at, "light", &lanelet.lights, &known.lights);
    if let Some(line) = &lanelet.stop_line {
        let at = at.field("stop_line");
        missing(report, &at, "sign", &line.signs, &known.signs);
        missing(report, &at, "light", &line.lights, &known.lights);
    }
}

fn missing(report: &mut Report, at: &At<'_>, what: &str, ids: &[i64], known: &HashSet<i64>) {
    for id in ids.iter().filter(|id| !known.contains(id)) {
        report.warn(at, format!("it refers to {what} {id}, which is not there"));
    }
}
