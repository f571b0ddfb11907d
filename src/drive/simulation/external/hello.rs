//! Writes `hello`: scenario, road, vehicle and planning problem for a planner's process.

use super::protocol::{Goal, Hello, OLDEST_PROTOCOL, PROTOCOL, Problem, Start, Vehicle};
use super::road_message::{
    Incoming, Intersection, Lanelet, Light, Neighbour, Road, Sign, SignElement,
};
use super::scene_message::obstacle;
use crate::simulation::{DriveSpan, Driver};
use nearmiss_base::geometry::{Footprint, Point, Pose};
use nearmiss_scene::scenario::{
    self, LaneletNetwork, ObstacleRole, PlanningProblem, Position, Quantity, Scenario, SignMeaning,
    StateField,
};

/// The greeting for a drive of `driver` through `scenario`.
pub(super) fn hello<'a>(
    driver: &Driver,
    scenario: &'a Scenario,
    span: &DriveSpan,
    clock: &'static str,
) -> Hello<'a> {
    let settings = driver.settings();
    let limits = driver.limits();
    let vehicle = settings.planner.vehicle;
    let standing = scenario
        .obstacles
        .iter()
        .filter(|o| o.role == ObstacleRole::Static && Some(o.id) != settings.without)
        .filter_map(|o| {
            let (motion, footprint) = (o.motion_at(span.step)?, o.footprint_at(span.step)?);
            Some(obstacle(o.id, o.kind, footprint, motion))
        });
    Hello {
        protocol: PROTOCOL,
        oldest_protocol: OLDEST_PROTOCOL,
        program: format!("nearmiss {}", env!("CARGO_PKG_VERSION")),
        scenario: &scenario.header.benchmark_id,
        dt: driver.dt(),
        first_step: span.step,
        last_step: span.last,
        clock,
        replan: settings.replan.max(1),
        horizon: settings.planner.horizon,
        prediction: settings.forecast.name(),
        vehicle: Vehicle {
            name: vehicle.name(),
            number: vehicle.number(),
            length: limits.length,
            width: limits.width,
            wheelbase: limits.wheelbase,
            rear_to_centre: limits.rear_to_centre,
            max_acceleration: limits.acceleration,
            switch_speed: limits.switch_speed,
            max_speed: limits.speed,
            max_steering: limits.steering,
            max_steering_rate: limits.steering_rate,
        },
        road: road(&scenario.network),
        static_obstacles: standing.collect(),
        problem: problem(driver.problem()),
    }
}

fn road(network: &LaneletNetwork) -> Road<'_> {
    Road {
        lanelets: { network.lanelets.iter() }
            .map(|lanelet| self::lanelet(network, lanelet))
            .collect(),
        signs: { network.signs.iter() }
            .map(|sign| Sign {
                id: sign.id,
                position: sign.position.map(|p| pair(&p)),
                elements: { sign.elements.iter() }
                    .map(|element| SignElement {
                        id: &element.id,
                        values: &element.values,
                    })
                    .collect(),
            })
            .collect(),
        lights: { network.lights.iter() }
            .map(|light| Light {
                id: light.id,
                position: network.position_of(light).map(|p| pair(&p)),
            })
            .collect(),
        intersections: { network.intersections.iter() }
            .map(|intersection| Intersection {
                id: intersection.id,
                incomings: { intersection.incomings.iter() }.map(incoming).collect(),
            })
            .collect(),
    }
}

fn incoming(incoming: &scenario::Incoming) -> Incoming<'_> {
    Incoming {
        id: incoming.id,
        lanelets: &incoming.lanelets,
        right: &incoming.right,
        straight: &incoming.straight,
        left: &incoming.left,
        is_left_of: incoming.is_left_of,
    }
}

fn lanelet<'a>(network: &LaneletNetwork, lanelet: &'a scenario::Lanelet) -> Lanelet<'a> {
    let neighbour = |adjacent: Option<scenario::Adjacent>| {
        adjacent.map(|adjacent| Neighbour {
            id: adjacent.id,
            same_direction: adjacent.same_direction,
        })
    };
    Lanelet {
        id: lanelet.id,
        left: points(&lanelet.left.points),
        right: points(&lanelet.right.points),
        left_marking: lanelet.left.marking.name(),
        right_marking: lanelet.right.marking.name(),
        predecessors: &lanelet.predecessors,
        successors: &lanelet.successors,
        left_neighbour: neighbour(lanelet.adjacent_left),
        right_neighbour: neighbour(lanelet.adjacent_right),
        types: lanelet.types.iter().map(|t| t.name()).collect(),
        users_one_way: lanelet.users_one_way.iter().map(|u| u.name()).collect(),
        users_bidirectional: { lanelet.users_bidirectional.iter() }
            .map(|u| u.name())
            .collect(),
        speed_limit: speed_limit(network, lanelet),
        stop_line: lanelet
            .stop_line_ends()
            .map(|(from, to)| [pair(&from), pair(&to)]),
        signs: &lanelet.signs,
        lights: &lanelet.lights,
    }
}

/// The lowest speed limit of the signs that hold on a lanelet, m/s.
fn speed_limit(network: &LaneletNetwork, lanelet: &scenario::Lanelet) -> Option<f64> {
    let signs = { network.signs.iter() }.filter(|sign| lanelet.signs.contains(&sign.id));
    let meanings = signs.flat_map(|sign| sign.elements.iter().filter_map(|e| e.meaning()));
    let limits = meanings.filter_map(|meaning| match meaning {
        SignMeaning::SpeedLimit(limit) => Some(limit),
        _ => None,
    });
    limits.min_by(f64::total_cmp)
}

fn problem(problem: &PlanningProblem) -> Problem {
    let initial = &problem.initial;
    let at = initial.point().unwrap_or(Point::origin());
    let middle = |quantity: Option<Quantity>| quantity.map_or(0.0, |q| q.middle());
    Problem {
        id: problem.id,
        start: Start {
            x: at.x,
            y: at.y,
            heading: middle(initial.orientation),
            velocity: middle(initial.velocity),
            acceleration: middle(initial.acceleration),
            yaw_rate: middle(initial.quantity(StateField::YawRate)),
        },
        goals: goals(problem, i64::MIN),
    }
}

/// The goals whose time is not over before step `from`.
pub(super) fn goals(problem: &PlanningProblem, from: i64) -> Vec<Goal> {
    let bounds = |quantity: Quantity| match quantity {
        Quantity::Exact(value) => [value, value],
        Quantity::Interval(from, to) => [from, to],
    };
    let open = problem.goals.iter().filter(|goal| goal.time.to >= from);
    open.map(|goal| Goal {
        first_step: goal.time.from,
        last_step: goal.time.to,
        lanelets: goal.lanelets(),
        areas: goal.positions.iter().flat_map(areas).collect(),
        heading: goal.orientation.map(bounds),
        velocity: goal.velocity.map(bounds),
    })
    .collect()
}

/// The outlines of a position; of a point a square of a millimetre.
fn areas(position: &Position) -> Vec<Vec<[f64; 2]>> {
    const HALF: f64 = 5e-4;
    match position {
        Position::Region(shape) => Footprint::new(shape.clone()).map_or_else(
            |_| Vec::new(),
            |region| {
                let outlines = region.at(Pose::new(0.0, 0.0, 0.0)).outlines();
                outlines.iter().map(|outline| points(outline)).collect()
            },
        ),
        Position::Point(p) => vec![vec![
            [p.x - HALF, p.y - HALF],
            [p.x + HALF, p.y - HALF],
            [p.x + HALF, p.y + HALF],
            [p.x - HALF, p.y + HALF],
        ]],
        Position::Lanelets(_) => Vec::new(),
    }
}

fn points(points: &[Point]) -> Vec<[f64; 2]> {
    points.iter().map(pair).collect()
}

fn pair(point: &Point) -> [f64; 2] {
    [point.x, point.y]
}
