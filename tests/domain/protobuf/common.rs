//! What both versions encode alike: states, regions, obstacles, planning problems.

use nearmiss::geometry::{Shape, Truck};
use nearmiss::scenario::{
    Obstacle, ObstacleRole, ObstacleType, PlanningProblem, Position, Prediction, Quantity,
    Scenario, Signal, SignalState, State, StateField, Steps,
};

use super::wire::{Bytes, message, point};

/// How an obstacle's body is encoded, which differs between the versions.
pub type Body = fn(&Shape) -> Bytes;

pub fn tag(word: &str) -> i64 {
    let tags = [
        "interstate",
        "urban",
        "highway",
        "comfort",
        "critical",
        "evasive",
        "cut_in",
        "illegal_cutin",
        "intersection",
        "lane_change",
        "lane_following",
        "merging_lanes",
        "multi_lane",
        "oncoming_traffic",
        "no_oncoming_traffic",
        "parallel_lanes",
        "race_track",
        "roundabout",
        "rural",
        "simulated",
        "single_lane",
        "slip_road",
        "speed_limit",
        "traffic_jam",
        "turn_left",
        "turn_right",
        "two_lane",
        "emergency_braking",
    ];
    tags.iter().position(|t| *t == word).unwrap() as i64
}

pub fn date(text: Option<&String>) -> Bytes {
    let mut numbers = text.map_or("2026-01-02", |t| t.as_str()).split('-');
    let mut next = || numbers.next().unwrap().parse().unwrap();
    message()
        .whole(1, next())
        .whole(2, next())
        .whole(3, next())
        .whole(4, 5)
        .whole(5, 6)
}

pub fn steps(steps: Steps) -> Bytes {
    if steps.from == steps.to {
        return message().whole(1, steps.from);
    }
    message().inner(2, message().whole(1, steps.from).whole(2, steps.to))
}

fn quantity(value: Quantity) -> Bytes {
    match value {
        Quantity::Exact(value) => message().double(1, value),
        Quantity::Interval(from, to) => message().inner(2, point(from, to)),
    }
}

/// A shape of 2020a, an occupancy of 2024.
pub fn region(shape: &Shape) -> Bytes {
    match shape {
        Shape::Rectangle {
            length,
            width,
            center,
            orientation,
            ..
        } => {
            let inner = message().double(1, *length).double(2, *width);
            let inner = inner
                .inner(3, point(center.x, center.y))
                .double(4, *orientation);
            message().inner(1, inner)
        }
        Shape::Circle { radius, center } => message().inner(
            2,
            message()
                .double(1, *radius)
                .inner(2, point(center.x, center.y)),
        ),
        Shape::Polygon { vertices } => message().inner(
            3,
            message().each(vertices, |out, v| out.inner(1, point(v.x, v.y))),
        ),
        Shape::Group(members) => {
            message().inner(4, message().each(members, |out, m| out.inner(1, region(m))))
        }
        Shape::Truck(_) | Shape::SemiTrailerTruck { .. } => panic!("no regions are trucks"),
    }
}

fn truck(truck: &Truck) -> Bytes {
    let dims = message()
        .double(1, truck.length)
        .double(2, truck.width)
        .double(3, truck.wheelbase)
        .double(4, truck.rear_to_rear_axle)
        .double(5, truck.cabin_length)
        .double(6, truck.rear_axle_to_hitch);
    message().inner(1, dims).double(2, truck.origin_x_shift)
}

/// A body of 2024.
pub fn body(shape: &Shape) -> Bytes {
    match shape {
        Shape::Rectangle { length, width, .. } => {
            message().inner(1, message().double(1, *length).double(2, *width))
        }
        Shape::Circle { radius, .. } => message().inner(2, message().double(1, *radius)),
        Shape::Polygon { .. } => region(shape),
        Shape::Truck(t) => message().inner(4, truck(t)),
        Shape::SemiTrailerTruck {
            tractor, trailer, ..
        } => {
            let dims = message()
                .double(1, trailer.length)
                .double(2, trailer.width)
                .double(3, trailer.wheelbase)
                .double(4, trailer.front_to_hitch);
            message().inner(5, message().inner(1, truck(tractor)).inner(2, dims))
        }
        Shape::Group(_) => panic!("2024 has no groups as bodies"),
    }
}

pub fn state(state: &State) -> Bytes {
    let out = match &state.position {
        Some(Position::Point(p)) => message().inner(1, point(p.x, p.y)),
        Some(Position::Region(shape)) => message().inner(2, region(shape)),
        Some(Position::Lanelets(_)) | None => message(),
    };
    let named = [
        (3, state.orientation),
        (4, state.velocity),
        (34, state.acceleration),
    ];
    let out = out.each(named, |out, (number, value)| match value {
        Some(value) => out.inner(number, quantity(value)),
        None => out,
    });
    let out = out.each(&state.more, |out, (field, value)| {
        let number = match field {
            StateField::SteeringAngle => 5,
            StateField::YawRate => 7,
            StateField::SlipAngle => 8,
            other => panic!("no bundled scenario has {other}"),
        };
        out.inner(number, quantity(*value))
    });
    out.inner(39, steps(state.time))
}

fn signals(state: &SignalState) -> Bytes {
    let out = message().inner(1, steps(state.time));
    out.each(&state.signals, |out, (signal, on)| {
        let place = Signal::ALL.iter().position(|s| s == signal).unwrap();
        let numbers = [2, 3, 4, 5, 6, 7];
        out.whole(numbers[place], i64::from(*on))
    })
}

/// The type of an obstacle.
pub fn kind(kind: ObstacleType) -> i64 {
    let kinds = [
        "unknown",
        "car",
        "truck",
        "bus",
        "bicycle",
        "pedestrian",
        "priorityVehicle",
        "parkedVehicle",
        "constructionZone",
        "train",
        "roadBoundary",
        "motorcycle",
        "taxi",
        "building",
        "pillar",
        "median_strip",
    ];
    kinds.iter().position(|k| *k == kind.name()).unwrap() as i64
}

/// A static or dynamic obstacle.
pub fn obstacle(obstacle: &Obstacle, body: Body) -> Bytes {
    let shape = body(obstacle.footprint.as_ref().unwrap().shape());
    let out = message()
        .whole(1, obstacle.id)
        .whole(2, kind(obstacle.kind))
        .inner(3, shape.clone())
        .inner(4, state(obstacle.initial.as_ref().unwrap()));
    let out = match &obstacle.prediction {
        Prediction::None => out,
        Prediction::Trajectory(states) => {
            let trajectory = message()
                .whole(1, 1)
                .each(states, |out, s| out.inner(2, state(s)));
            out.inner(5, message().inner(1, trajectory).inner(2, shape))
        }
        prediction @ Prediction::Occupancies(_) => out.inner(6, occupancies(prediction)),
    };
    // The first signal state belongs to the initial state where both are of the same time.
    let start = obstacle.initial.as_ref().map(|s| s.time);
    let first = obstacle
        .signals
        .first()
        .is_some_and(|s| Some(s.time) == start);
    let (now, later) = obstacle.signals.split_at(usize::from(first));
    let (initial, series) = if obstacle.role == ObstacleRole::Static {
        (5, 6)
    } else {
        (7, 8)
    };
    let out = match now.first() {
        Some(state) => out.inner(initial, signals(state)),
        None => out.inner(initial, message()),
    };
    out.each(later, |out, s| out.inner(series, signals(s)))
}

pub fn occupancies(prediction: &Prediction) -> Bytes {
    let Prediction::Occupancies(all) = prediction else {
        panic!("not a set of occupancies");
    };
    let set = message().each(all, |out, o| {
        out.inner(
            1,
            message()
                .inner(1, steps(o.time))
                .inner(2, region(&o.region)),
        )
    });
    message().whole(1, 1).inner(2, set)
}

/// A planning problem; the tags are of 2024.
pub fn problem(problem: &PlanningProblem, tags: Option<Bytes>) -> Bytes {
    let out = message()
        .whole(1, problem.id)
        .inner(2, state(&problem.initial));
    let out = out.each(&problem.goals, |out, goal| {
        let inner = State {
            position: goal.positions.first().cloned(),
            orientation: goal.orientation,
            velocity: goal.velocity,
            ..State::at(goal.time)
        };
        let lanelets = goal.lanelets();
        out.inner(3, message().inner(1, state(&inner)).wholes(2, &lanelets))
    });
    tags.into_iter().fold(out, |out, tags| out.inner(5, tags))
}

/// The location of a scenario, without its environment.
pub fn location(scenario: &Scenario) -> Bytes {
    let location = scenario.location.clone().unwrap_or_default();
    let out = message()
        .whole(1, location.geo_name_id.unwrap_or(-999))
        .double(2, location.latitude.unwrap_or(999.0))
        .double(3, location.longitude.unwrap_or(999.0));
    let Some(geo) = location.transformation else {
        return out;
    };
    let parts = [(2, geo.x), (3, geo.y), (4, geo.rotation), (5, geo.scaling)];
    let inner = geo
        .reference
        .iter()
        .fold(message(), |inner, text| inner.text(1, text));
    let inner = inner.each(parts, |inner, (number, value)| {
        value
            .into_iter()
            .fold(inner, |inner, v| inner.double(number, v))
    });
    out.inner(4, inner)
}
