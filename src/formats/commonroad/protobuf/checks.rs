//! Checks that need the whole scenario: dangling references and contradictions, with their fields.

use super::report::{FieldPath, Report};
use crate::commonroad::builder::{SourceLocation, Target, Targets};
use nearmiss_scene::scenario::plausibility::{self, ElementRef};
use nearmiss_scene::scenario::{Lanelet, ObstacleRole, Scenario};

/// The messages that hold road, traffic and planning problems; empty names where one message holds all.
pub(super) struct Roots {
    pub road: &'static str,
    pub traffic: &'static str,
    pub planning: &'static str,
}

/// The single message of 2020a.
pub(super) const ONE: Roots = Roots {
    road: "",
    traffic: "",
    planning: "",
};

/// The three messages of 2024.
pub(super) const THREE: Roots = Roots {
    road: "map",
    traffic: "dynamic",
    planning: "scenario",
};

/// Notes references to nothing and what cannot be true of a scenario; the scenario with all that was noted of it.
pub(super) fn finish(report: Report, roots: &Roots, mut scenario: Scenario) -> Scenario {
    check_references(&report, roots, &scenario);
    for finding in plausibility::check(&scenario) {
        let field = field(roots, finding.about, &scenario);
        let diagnostics = &report.diagnostics;
        diagnostics.push(finding.severity, || (0, field), finding.message);
    }
    scenario.diagnostics = report.into_diagnostics();
    scenario
}

fn field(roots: &Roots, about: ElementRef, scenario: &Scenario) -> String {
    let below = |root: &str, path: String| match (root, path.as_str()) {
        ("", _) => path,
        (_, "") => root.to_string(),
        _ => format!("{root}/{path}"),
    };
    let road = |path: String| below(roots.road, path);
    let planning = |path: String| below(roots.planning, path);
    match about {
        ElementRef::Scenario if roots.road.is_empty() => "information/time_step_size".into(),
        ElementRef::Scenario => String::new(),
        ElementRef::Location => road("location".into()),
        ElementRef::Lanelet(i) => road(format!("lanelets[{i}]")),
        ElementRef::Sign(i) => road(format!("traffic_signs[{i}]")),
        ElementRef::Light(i) => road(format!("traffic_lights[{i}]")),
        ElementRef::Intersection(i) => road(format!("intersections[{i}]")),
        ElementRef::Obstacle(i) => obstacle(roots, i, scenario),
        ElementRef::State { obstacle: i, state } => {
            let whole = obstacle(roots, i, scenario);
            match state.checked_sub(1) {
                None => format!("{whole}/initial_state"),
                Some(state) => format!("{whole}/trajectory_prediction/trajectory/states[{state}]"),
            }
        }
        ElementRef::Start(i) => planning(format!("planning_problems[{i}]/initial_state")),
        ElementRef::Goal { problem, goal } => {
            planning(format!("planning_problems[{problem}]/goal_states[{goal}]"))
        }
    }
}

/// The field of an obstacle: the lists of the message have one role each.
fn obstacle(roots: &Roots, place: usize, scenario: &Scenario) -> String {
    let Some(obstacle) = scenario.obstacles.get(place) else {
        return String::new();
    };
    let before = &scenario.obstacles[..place];
    let index = before.iter().filter(|o| o.role == obstacle.role).count();
    let (root, list) = match obstacle.role {
        ObstacleRole::Static => (roots.traffic, "static_obstacles"),
        ObstacleRole::Dynamic => (roots.traffic, "dynamic_obstacles"),
        ObstacleRole::Phantom => (roots.traffic, "phantom_obstacles"),
        ObstacleRole::Environment => (roots.road, "environment_obstacles"),
    };
    let separator = if root.is_empty() { "" } else { "/" };
    format!("{root}{separator}{list}[{index}]")
}

/// Warns of every reference to an element that is not there.
fn check_references(report: &Report, roots: &Roots, scenario: &Scenario) {
    let network = &scenario.network;
    let known = Targets::new(network);
    let road = FieldPath::root(report, roots.road);
    for (i, lanelet) in network.lanelets.iter().enumerate() {
        check_lanelet(&road.nth("lanelets", i), lanelet, &known);
    }
    for (i, intersection) in network.intersections.iter().enumerate() {
        let at = road.nth("intersections", i);
        for (j, road) in intersection.incomings.iter().enumerate() {
            let at = at.nth("incomings", j);
            for ids in [&road.lanelets, &road.right, &road.straight, &road.left] {
                warn_of_missing(&at, Target::Lanelet, ids, &known);
            }
            let left = road.is_left_of.as_slice();
            warn_of_missing(&at, Target::Incoming, left, &known);
        }
        warn_of_missing(&at, Target::Lanelet, &intersection.crossings, &known);
    }
    let planning = FieldPath::root(report, roots.planning);
    for (i, problem) in scenario.planning_problems.iter().enumerate() {
        let at = planning.nth("planning_problems", i);
        for (j, goal) in problem.goals.iter().enumerate() {
            let at = at.nth("goal_states", j);
            warn_of_missing(&at, Target::Lanelet, &goal.lanelets(), &known);
        }
    }
}

fn check_lanelet(at: &FieldPath<'_>, lanelet: &Lanelet, known: &Targets) {
    let beside = [&lanelet.adjacent_left, &lanelet.adjacent_right];
    let beside: Vec<i64> = beside.into_iter().flatten().map(|a| a.id).collect();
    for ids in [&lanelet.predecessors, &lanelet.successors, &beside] {
        warn_of_missing(at, Target::Lanelet, ids, known);
    }
    warn_of_missing(at, Target::Sign, &lanelet.signs, known);
    warn_of_missing(at, Target::Light, &lanelet.lights, known);
    if let Some(line) = &lanelet.stop_line {
        let at = at.field("stop_line");
        warn_of_missing(&at, Target::Sign, &line.signs, known);
        warn_of_missing(&at, Target::Light, &line.lights, known);
    }
}

fn warn_of_missing(at: &FieldPath<'_>, target: Target, ids: &[i64], known: &Targets) {
    let name = match target {
        Target::Lanelet => "lanelet",
        Target::Sign => "sign",
        Target::Light => "light",
        Target::Incoming => "incoming road",
    };
    for id in ids.iter().filter(|id| !known.has(target, **id)) {
        at.warn(format!("refers to missing {name} {id}"));
    }
}
