//! Routes of planning problems, for `inspect`.

use serde_json::{Value, json};

use nearmiss_scene::scenario::{
    Destination, Direction, Leg, PlanningProblem, RoadUser, Route, RouteError, Scenario, Side,
};

type Found<'a> = (&'a PlanningProblem, Result<Route, RouteError>);

/// The route of each planning problem for a car.
fn routes(scenario: &Scenario) -> Vec<Found<'_>> {
    if scenario.planning_problems.is_empty() {
        return Vec::new();
    }
    let graph = scenario.network.lane_graph(Some(RoadUser::Car));
    let problems = scenario.planning_problems.iter();
    problems.map(|p| (p, graph.route(p))).collect()
}

/// A line for each planning problem.
pub fn summary(scenario: &Scenario) -> String {
    let line = |(problem, route): Found<'_>| {
        let words = match route {
            Ok(route) => words(&route),
            Err(error) => format!("none: {error}"),
        };
        format!("  route       planning problem {}: {words}\n", problem.id)
    };
    routes(scenario).into_iter().map(line).collect()
}

fn words(route: &Route) -> String {
    let leg = |leg: &Leg| {
        let change = match leg.change {
            Some(Side::Left) => "change left to ",
            Some(Side::Right) => "change right to ",
            None => "",
        };
        let direction = match leg.driven.direction {
            Direction::Along => "",
            Direction::Against => " against its direction",
        };
        format!("{change}{}{direction}", leg.driven.lanelet)
    };
    let legs: Vec<String> = route.legs.iter().map(leg).collect();
    let destination = match route.destination {
        Destination::RoadAhead => ", the road ahead, as no goal has a position",
        Destination::Goal(_) | Destination::Recording => "",
    };
    format!(
        "lanelets {}, {:.1} m{destination}",
        legs.join(", "),
        route.length()
    )
}

/// An object for each planning problem.
pub fn document(scenario: &Scenario) -> Value {
    let found = routes(scenario).into_iter();
    found
        .map(|(problem, route)| match route {
            Ok(route) => json!({
                "planning_problem": problem.id,
                "destination": match route.destination {
                    Destination::Goal(place) => json!({ "goal": place }),
                    Destination::RoadAhead => json!("road_ahead"),
                    Destination::Recording => json!("recording"),
                },
                "length": route.length(),
                "legs": route.legs.iter().map(leg).collect::<Vec<_>>(),
                "deviation": route.path.deviation(),
            }),
            Err(error) => json!({
                "planning_problem": problem.id,
                "no_route": error.to_string(),
            }),
        })
        .collect()
}

fn leg(leg: &Leg) -> Value {
    json!({
        "lanelet": leg.driven.lanelet,
        "direction": match leg.driven.direction {
            Direction::Along => "along",
            Direction::Against => "against",
        },
        "lane_change": leg.change.map(|side| match side {
            Side::Left => "left",
            Side::Right => "right",
        }),
    })
}
