//! Routes of planning problems, for `inspect`.

use serde::Serialize;

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

/// The route of a planning problem, or why there is none.
#[derive(Serialize)]
pub struct RouteDocument {
    planning_problem: i64,
    #[serde(flatten)]
    found: FoundRoute,
}

#[derive(Serialize)]
#[serde(untagged)]
enum FoundRoute {
    Route {
        destination: Destination,
        length: f64,
        legs: Vec<LegDocument>,
        deviation: f64,
    },
    None {
        no_route: String,
    },
}

#[derive(Serialize)]
struct LegDocument {
    lanelet: i64,
    direction: Direction,
    lane_change: Option<Side>,
}

impl RouteDocument {
    /// One for each planning problem.
    pub fn all(scenario: &Scenario) -> Vec<Self> {
        let document = |(problem, route): Found<'_>| Self {
            planning_problem: problem.id,
            found: match route {
                Ok(route) => FoundRoute::Route {
                    destination: route.destination,
                    length: route.length(),
                    legs: route.legs.iter().map(leg).collect(),
                    deviation: route.path.deviation(),
                },
                Err(error) => FoundRoute::None {
                    no_route: error.to_string(),
                },
            },
        };
        routes(scenario).into_iter().map(document).collect()
    }
}

fn leg(leg: &Leg) -> LegDocument {
    LegDocument {
        lanelet: leg.driven.lanelet,
        direction: leg.driven.direction,
        lane_change: leg.change,
    }
}
