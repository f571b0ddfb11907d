//! Writes what a planner's process is told: `hello` with scenario, road and vehicle, and `plan` at a time step.

use nearmiss_base::geometry::{Footprint, Point, Pose, Vector};
use nearmiss_scene::scenario::prediction::{Observed, ObservedHistory};
use nearmiss_scene::scenario::{
    self, LaneletNetwork, Motion, ObstacleRole, ObstacleType, PlanningProblem, Position, Quantity,
    Scenario, SignMeaning, StateField,
};
use schemars::JsonSchema;
use serde::Serialize;

use super::protocol::{
    EgoState, Goal, Hello, LightState, OLDEST_PROTOCOL, Obstacle, PROTOCOL, PastState, PlanMessage,
    Prediction, Problem, Ready, ReferencePoint, Start, Vehicle,
};
use crate::planner::{Forecaster, Limits, Traffic, VehicleState};
use crate::simulation::{DriveSpan, Driver};

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

/// The road network.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Road<'a> {
    /// Pieces of lanes.
    pub lanelets: Vec<Lanelet<'a>>,
    /// Traffic signs.
    pub signs: Vec<Sign<'a>>,
    /// Traffic lights; their colours come with each cycle.
    pub lights: Vec<Light>,
    /// Intersections.
    pub intersections: Vec<Intersection<'a>>,
}

/// A piece of a lane, driven from the first points of its bounds to the last ones.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Lanelet<'a> {
    /// Unique.
    pub id: i64,
    /// Bound on the left, points in metres.
    pub left: Vec<[f64; 2]>,
    /// Bound on the right.
    pub right: Vec<[f64; 2]>,
    /// Marking of the left bound, in the words of CommonRoad.
    pub left_marking: &'static str,
    /// Marking of the right bound.
    pub right_marking: &'static str,
    /// Lanelets that end where it begins.
    pub predecessors: &'a [i64],
    /// Lanelets that begin where it ends.
    pub successors: &'a [i64],
    /// The neighbour on the left.
    pub left_neighbour: Option<Neighbour>,
    /// The neighbour on the right.
    pub right_neighbour: Option<Neighbour>,
    /// Types of road, in the words of CommonRoad.
    pub types: Vec<&'static str>,
    /// Road users in its direction, in the words of CommonRoad.
    pub users_one_way: Vec<&'static str>,
    /// Road users in both directions.
    pub users_bidirectional: Vec<&'static str>,
    /// The lowest speed limit of its signs, m/s.
    pub speed_limit: Option<f64>,
    /// Ends of its stop line.
    pub stop_line: Option<[[f64; 2]; 2]>,
    /// Signs that hold on it.
    pub signs: &'a [i64],
    /// Lights that hold on it.
    pub lights: &'a [i64],
}

/// A lanelet beside another one.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Neighbour {
    /// Its id.
    pub id: i64,
    /// Whether it is driven in the same direction.
    pub same_direction: bool,
}

/// A traffic sign.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Sign<'a> {
    /// Unique.
    pub id: i64,
    /// Where it stands.
    pub position: Option<[f64; 2]>,
    /// What it says; a post may carry several.
    pub elements: Vec<SignElement<'a>>,
}

/// One sign on a post.
#[derive(Debug, Serialize, JsonSchema)]
pub struct SignElement<'a> {
    /// The country's number, such as `274`.
    pub id: &'a str,
    /// Values on it, such as a speed in m/s.
    pub values: &'a [String],
}

/// A traffic light.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Light {
    /// Unique.
    pub id: i64,
    /// Where it stands.
    pub position: Option<[f64; 2]>,
}

/// An intersection.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Intersection<'a> {
    /// Unique.
    pub id: i64,
    /// Roads that lead in.
    pub incomings: Vec<Incoming<'a>>,
}

/// A road that leads into an intersection.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Incoming<'a> {
    /// Unique.
    pub id: i64,
    /// Its last lanelets.
    pub lanelets: &'a [i64],
    /// Lanelets that turn right.
    pub right: &'a [i64],
    /// Lanelets that go straight on.
    pub straight: &'a [i64],
    /// Lanelets that turn left.
    pub left: &'a [i64],
    /// The incoming to the left of which it is.
    pub is_left_of: Option<i64>,
}

/// What a planner is told of one step, after what it asked for.
pub(super) struct SceneMessageBuilder<'a> {
    driver: &'a Driver,
    scenario: &'a Scenario,
    first: i64,
    ready: &'a Ready,
}

impl<'a> SceneMessageBuilder<'a> {
    /// Of a drive that began at step `first`.
    pub fn new(driver: &'a Driver, scenario: &'a Scenario, first: i64, ready: &'a Ready) -> Self {
        Self {
            driver,
            scenario,
            first,
            ready,
        }
    }

    /// The scene at `step`, where the ego is in `state`. Nothing later than `step` is in it, but for predictions of the
    /// recorded future where the drive's settings ask for those.
    pub fn message(&self, state: &VehicleState, step: i64) -> PlanMessage {
        let (driver, scenario) = (self.driver, self.scenario);
        let settings = driver.settings();
        let history = i64::try_from(self.ready.history).unwrap_or(i64::MAX);
        let since = step.saturating_sub(history);
        let past = ObservedHistory::of_traffic(scenario, since..=step, settings.without);
        let traffic = self.ready.predictions.then(|| {
            let forecaster = Forecaster::new(scenario, settings.forecast, settings.without);
            forecaster.traffic(step, settings.planner.steps(driver.dt()))
        });
        let moving = past.others().iter().filter(|other| !other.who.parked);
        let lights = scenario.network.lights.iter();
        PlanMessage {
            step,
            time: (step - self.first) as f64 * driver.dt(),
            ego: ego(state, driver.limits(), self.ready.reference_point),
            obstacles: moving
                .map(|other| self.moving(other, step, traffic.as_ref()))
                .collect(),
            lights: lights
                .map(|light| LightState {
                    id: light.id,
                    color: light.color_at(step).name(),
                })
                .collect(),
            goals: goals(driver.problem(), step),
        }
    }

    /// Whether the acceleration of an obstacle at `step` is not recorded and its first, and so is worked out from the
    /// state after it, which the planner does not know yet.
    fn is_from_the_next(&self, id: i64, step: i64) -> bool {
        self.scenario.obstacle(id).is_some_and(|obstacle| {
            let said = obstacle
                .initial
                .as_ref()
                .and_then(|first| first.acceleration);
            obstacle.track().steps().start == step && said.is_none()
        })
    }

    fn moving(&self, other: &Observed<'_>, step: i64, traffic: Option<&Traffic>) -> Obstacle {
        let kind = other.who.kind.unwrap_or(ObstacleType::Unknown);
        let earlier = other.motions.iter().filter(|(at, _)| *at < step);
        let mut now = *other.motion;
        if self.is_from_the_next(other.who.id, step) {
            now.acceleration = 0.0;
        }
        Obstacle {
            history: earlier.map(|(at, motion)| past(*at, motion)).collect(),
            predictions: traffic
                .map_or_else(Vec::new, |traffic| predictions(traffic, other.who.id)),
            ..obstacle(other.who.id, kind, other.footprint, &now)
        }
    }
}

/// An obstacle without history and predictions.
pub(super) fn obstacle(
    id: i64,
    kind: ObstacleType,
    footprint: &Footprint,
    motion: &Motion,
) -> Obstacle {
    let corners = || footprint.corners().iter().map(|p| p.coords);
    let least = corners().fold(Vector::repeat(f64::INFINITY), |a, b| a.inf(&b));
    let most = corners().fold(Vector::repeat(f64::NEG_INFINITY), |a, b| a.sup(&b));
    let (size, middle) = (most - least, (most + least) / 2.0);
    Obstacle {
        id,
        r#type: kind.name(),
        length: size.x,
        width: size.y,
        box_middle: [middle.x, middle.y],
        x: motion.pose.position.x,
        y: motion.pose.position.y,
        heading: motion.pose.heading,
        velocity: motion.velocity,
        acceleration: motion.acceleration,
        history: Vec::new(),
        predictions: Vec::new(),
    }
}

fn past(step: i64, motion: &Motion) -> PastState {
    PastState {
        step,
        x: motion.pose.position.x,
        y: motion.pose.position.y,
        heading: motion.pose.heading,
        velocity: motion.velocity,
        acceleration: motion.acceleration,
    }
}

/// To millionths: predictions are most of a message, and digits that say nothing take time on both sides.
fn rounded(value: f64) -> f64 {
    (value * 1e6).round() / 1e6
}

/// The predicted motions of an obstacle that is there now, the likeliest first, each until it is no longer there.
fn predictions(traffic: &Traffic, id: i64) -> Vec<Prediction> {
    let bodies = traffic.bodies.iter().enumerate();
    let own = bodies.filter(|(_, body)| body.id == id);
    let mut found: Vec<Prediction> = own
        .map(|(place, body)| {
            let steps = (0..=traffic.horizon()).map_while(|step| {
                let there = traffic.at(step).iter().find(|o| o.body == place)?;
                let heading = there.sin.atan2(there.cos);
                Some([there.x, there.y, heading, there.velocity].map(rounded))
            });
            Prediction {
                probability: body.likelihood,
                states: steps.collect(),
            }
        })
        .collect();
    found.retain(|prediction| !prediction.states.is_empty());
    found.sort_by(|a, b| b.probability.total_cmp(&a.probability));
    found
}

fn ego(state: &VehicleState, limits: &Limits, point: ReferencePoint) -> EgoState {
    let pose = match point {
        ReferencePoint::RearAxle => state.rear,
        ReferencePoint::Centre => state.centre(limits).pose,
    };
    EgoState {
        reference_point: point,
        x: pose.position.x,
        y: pose.position.y,
        heading: pose.heading,
        velocity: state.velocity,
        acceleration: state.acceleration,
        steering: limits.steering_of(state.curvature),
        yaw_rate: state.velocity * state.curvature,
    }
}
