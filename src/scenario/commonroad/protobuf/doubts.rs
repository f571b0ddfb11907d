//! What cannot be true of a scenario, with the field that it is in.

use super::report::Report;
use crate::scenario::plausibility::{self, About};
use crate::scenario::{ObstacleRole, Scenario};

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

/// Notes what cannot be true of a scenario.
pub(super) fn note(report: &mut Report, roots: &Roots, scenario: &Scenario) {
    for finding in plausibility::check(scenario) {
        let field = field(roots, finding.about, scenario);
        report.note_field(finding.severity, field, finding.message);
    }
}

fn field(roots: &Roots, about: About, scenario: &Scenario) -> String {
    let below = |root: &str, path: String| match (root, path.as_str()) {
        ("", _) => path,
        (_, "") => root.to_string(),
        _ => format!("{root}/{path}"),
    };
    let road = |path: String| below(roots.road, path);
    let planning = |path: String| below(roots.planning, path);
    match about {
        About::Scenario if roots.road.is_empty() => "information/time_step_size".into(),
        About::Scenario => String::new(),
        About::Location => road("location".into()),
        About::Lanelet(i) => road(format!("lanelets[{i}]")),
        About::Sign(i) => road(format!("traffic_signs[{i}]")),
        About::Light(i) => road(format!("traffic_lights[{i}]")),
        About::Intersection(i) => road(format!("intersections[{i}]")),
        About::Obstacle(i) => obstacle(roots, i, scenario),
        About::State { obstacle: i, state } => {
            let whole = obstacle(roots, i, scenario);
            match state.checked_sub(1) {
                None => format!("{whole}/initial_state"),
                Some(state) => format!("{whole}/trajectory_prediction/trajectory/states[{state}]"),
            }
        }
        About::Start(i) => planning(format!("planning_problems[{i}]/initial_state")),
        About::Goal { problem, goal } => {
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
