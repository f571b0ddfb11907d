//! Random scenes: a winding road of two lanes, and vehicles that follow it, cross it, stand on it or drive against it.

use std::collections::BTreeMap;
use std::sync::Arc;

use nearmiss::geometry::{Footprint, Point, Polyline, Shape, Vector};
use nearmiss::scenario::*;
use proptest::collection::vec;
use proptest::prelude::*;

const DT: f64 = 0.1;
const WIDTH: f64 = 3.5;

/// How a vehicle drives.
#[derive(Debug, Clone)]
struct Driver {
    /// Metres along the road at the first step.
    from: f64,
    /// Offset at the first and the last step, metres.
    offsets: (f64, f64),
    speed: f64,
    acceleration: f64,
    /// Turn against the road, radians.
    turn: f64,
    shape: Shape,
    standing: bool,
}

fn shape() -> impl Strategy<Value = Shape> {
    let polygon = |(l, w): (f64, f64)| Shape::Polygon {
        vertices: [(l, 0.0), (l / 2.0, w), (-l, w), (-l, -w), (l / 2.0, -w)]
            .map(|(x, y)| Point::new(x / 2.0, y / 2.0))
            .to_vec(),
    };
    let disc = |radius| Shape::Circle {
        radius,
        center: Point::new(0.1, -0.05),
    };
    let pair = |(l, w): (f64, f64)| {
        let part = |x: f64| Shape::Rectangle {
            length: l,
            width: w,
            center: Point::new(x, 0.0),
            orientation: 0.05,
            origin_x_shift: 0.3,
        };
        Shape::Group(vec![part(0.0), part(-1.1 * l)])
    };
    let size = || (3.0..8.0, 1.5..2.5);
    prop_oneof![
        4 => size().prop_map(|(l, w)| Shape::rectangle(l, w)),
        1 => (0.2..0.6).prop_map(disc),
        1 => size().prop_map(polygon),
        1 => size().prop_map(pair),
    ]
}

fn driver() -> impl Strategy<Value = Driver> {
    let offset = || -5.0..5.0_f64;
    let turn = prop_oneof![4 => -0.05..0.05, 1 => -3.1..3.1_f64];
    (
        0.0..120.0,
        (offset(), offset()),
        0.0..20.0,
        -3.0..2.0,
        turn,
        shape(),
        0..6,
    )
        .prop_map(
            |(from, offsets, speed, acceleration, turn, shape, kind)| Driver {
                from,
                offsets,
                speed,
                acceleration,
                turn,
                shape,
                standing: kind == 0,
            },
        )
}

/// A line of 1 m pieces that turns by at most 0.04 rad/m.
fn line(bends: &[f64]) -> Polyline {
    let (mut p, mut heading) = (Point::origin(), 0.0_f64);
    let mut points = vec![p];
    for i in 0..240 {
        heading += bends[i * bends.len() / 240];
        p += Vector::new(heading.cos(), heading.sin());
        points.push(p);
    }
    Polyline::new(points).unwrap()
}

fn beside(line: &Polyline, s: f64, d: f64) -> Point {
    let (a, b) = (
        line.pose_at(s - 0.5).forward(),
        line.pose_at(s + 0.5).forward(),
    );
    let along = (a + b).normalize();
    line.pose_at(s).position + Vector::new(-along.y, along.x) * d
}

fn network(line: &Polyline) -> LaneletNetwork {
    let lanelet = |row: i64, lane: i64| {
        let border = |d: f64| Bound {
            points: (0..=80)
                .map(|i| beside(line, (row * 80 + i) as f64, d))
                .collect(),
            heights: Vec::new(),
            marking: LineMarking::Dashed,
        };
        let right = (lane - 1) as f64 * WIDTH;
        let id = |row: i64, lane: i64| 10 * row + lane + 1;
        let neighbour = |lane: i64| Adjacent {
            id: id(row, lane),
            same_direction: true,
        };
        Lanelet {
            id: id(row, lane),
            left: border(right + WIDTH),
            right: border(right),
            predecessors: (row > 0).then(|| id(row - 1, lane)).into_iter().collect(),
            successors: (row < 2).then(|| id(row + 1, lane)).into_iter().collect(),
            adjacent_left: (lane == 0).then(|| neighbour(1)),
            adjacent_right: (lane == 1).then(|| neighbour(0)),
            stop_line: None,
            types: Vec::new(),
            users_one_way: Vec::new(),
            users_bidirectional: Vec::new(),
            signs: Vec::new(),
            lights: Vec::new(),
        }
    };
    let lanelets = (0..3)
        .flat_map(|row| (0..2).map(move |lane| (row, lane)))
        .map(|(row, lane)| lanelet(row, lane))
        .collect();
    LaneletNetwork::new(lanelets, Vec::new(), Vec::new(), Vec::new())
}

fn obstacle(id: i64, driver: &Driver, line: &Polyline, steps: i64) -> Obstacle {
    let state = |step: i64| {
        let time = step as f64 * DT;
        let (v, a) = (driver.speed, driver.acceleration);
        let until = if a < 0.0 { time.min(-v / a) } else { time };
        let s = driver.from + v * until + a * until * until / 2.0;
        let share = step as f64 / steps as f64;
        let d = driver.offsets.0 + (driver.offsets.1 - driver.offsets.0) * share;
        State {
            position: Some(Position::Point(beside(line, s, d))),
            orientation: Some(Quantity::Exact(line.pose_at(s).heading + driver.turn)),
            velocity: Some(Quantity::Exact((v + a * until).max(0.0))),
            acceleration: Some(Quantity::Exact(if until < time { 0.0 } else { a })),
            ..State::at(Steps::exact(step))
        }
    };
    let parts = ObstacleParts {
        id,
        role: if driver.standing {
            ObstacleRole::Static
        } else {
            ObstacleRole::Dynamic
        },
        kind: ObstacleType::Car,
        footprint: Some(Footprint::new(driver.shape.clone()).unwrap()),
        initial: Some(state(0)),
        prediction: if driver.standing {
            Prediction::None
        } else {
            Prediction::Trajectory((1..steps).map(state).collect())
        },
        signals: Vec::new(),
    };
    Obstacle::new(parts, DT)
}

/// A scene whose ego is its first obstacle.
pub fn scene() -> impl Strategy<Value = Scene> {
    let bends = vec(-0.04..0.04_f64, 1..6);
    (bends, driver(), vec(driver(), 1..6), 10_i64..50).prop_map(
        |(bends, mut ego, others, steps)| {
            let line = line(&bends);
            (ego.standing, ego.turn) = (false, 0.02);
            ego.offsets = (ego.offsets.0 * 0.6, ego.offsets.1 * 0.6);
            ego.speed += 1.0;
            let drivers = std::iter::once(&ego).chain(&others);
            let obstacles = drivers
                .zip(1..)
                .map(|(d, id)| obstacle(id, d, &line, steps));
            let scenario = Scenario {
                header: Header {
                    other_format: None,
                    benchmark_id: "ZAM_Random-1_1_T-1".into(),
                    version: "2020a".into(),
                    time_step_size: DT,
                    attributes: BTreeMap::new(),
                },
                location: None,
                tags: Vec::new(),
                network: network(&line),
                obstacles: obstacles.collect(),
                planning_problems: Vec::new(),
                diagnostics: Vec::new(),
                recorded_ego: None,
                hash: ContentHash::digest(b""),
            };
            Scene::with_obstacle_as_ego(Arc::new(scenario), 1).unwrap()
        },
    )
}
