//! A scene with everything that a scenario can hold, and what becomes of each part.

use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;

use nearmiss::formats::bundled;
use nearmiss::geometry::{Footprint, Point, Shape};
use nearmiss::scenario::*;

use super::alike;

fn at(step: i64, x: f64, y: f64) -> State {
    State {
        position: Some(Position::Point(Point::new(x, y))),
        ..State::at(Steps::exact(step))
    }
}

fn corner() -> Shape {
    let corners = [(1.0, 0.0), (9.0, 1.0), (8.0, 3.0), (3.0, 4.0), (1.0, 2.0)];
    Shape::Polygon {
        vertices: corners.map(|(x, y)| Point::new(x, y)).to_vec(),
    }
}

fn box_there() -> Shape {
    Shape::Rectangle {
        length: 4.0,
        width: 2.0,
        center: Point::new(30.0, 5.0),
        orientation: 0.3,
        origin_x_shift: 0.5,
    }
}

fn obstacle(
    id: i64,
    footprint: Option<Shape>,
    initial: Option<State>,
    prediction: Prediction,
) -> ObstacleParts {
    ObstacleParts {
        id,
        role: ObstacleRole::Dynamic,
        kind: ObstacleType::Car,
        footprint: footprint.map(|shape| Footprint::new(shape).unwrap()),
        initial,
        prediction,
        signals: Vec::new(),
    }
}

/// A point mass that turns, told along the axes of the world, with a velocity that is not known exactly.
fn point_mass() -> ObstacleParts {
    let state = |step: i64| State {
        velocity: Some(Quantity::Exact(3.0)),
        acceleration: Some(Quantity::Exact(0.5)),
        more: vec![
            (StateField::VelocityY, Quantity::Exact(4.0)),
            (StateField::AccelerationY, Quantity::Exact(-1.0)),
        ],
        ..at(step, 3.0 * step as f64 / 10.0, 4.0 * step as f64 / 10.0)
    };
    let later = (1..8).map(state).collect();
    obstacle(
        9001,
        Some(Shape::rectangle(4.0, 2.0)),
        Some(state(0)),
        Prediction::Trajectory(later),
    )
}

fn uncertain() -> ObstacleParts {
    let state = |step: i64| State {
        position: Some(Position::Region(Shape::Group(vec![corner(), box_there()]))),
        orientation: Some(Quantity::Interval(0.1, 0.5)),
        velocity: Some(Quantity::Interval(1.0, 3.0)),
        more: vec![
            (StateField::YawRate, Quantity::Interval(-0.1, 0.3)),
            (
                StateField::LeftFrontWheelAngularSpeed,
                Quantity::Exact(11.0),
            ),
            (
                StateField::RightFrontWheelAngularSpeed,
                Quantity::Exact(12.0),
            ),
        ],
        ..State::at(Steps {
            from: step,
            to: step,
        })
    };
    let mut parts = obstacle(
        9002,
        Some(Shape::rectangle(4.0, 2.0)),
        Some(state(0)),
        Prediction::Trajectory((1..8).map(state).collect()),
    );
    parts.signals = vec![SignalState {
        time: Steps::exact(0),
        signals: vec![
            (Signal::IndicatorLeft, true),
            (Signal::IndicatorRight, false),
        ],
    }];
    parts
}

fn occupied() -> ObstacleParts {
    let occupancy = |step| Occupancy {
        time: Steps::exact(step),
        region: Shape::Circle {
            radius: 2.0,
            center: Point::new(step as f64, -3.0),
        },
    };
    let regions = Prediction::Occupancies((1..5).map(occupancy).collect());
    let initial = State {
        orientation: Some(Quantity::Exact(0.2)),
        ..at(0, 12.0, -3.0)
    };
    obstacle(9003, Some(corner()), Some(initial), regions)
}

fn everything() -> Scene {
    let entry = bundled()
        .into_iter()
        .find(|e| e.name.contains("RightTurn"))
        .unwrap();
    let mut scenario = (*entry.read().unwrap()).clone();
    let dt = scenario.dt();
    let standing = obstacle(
        9004,
        Some(Shape::rectangle(1.0, 2.0)),
        Some(at(0, 50.0, 9.0)),
        Prediction::None,
    );
    let mut house = obstacle(9005, Some(box_there()), None, Prediction::None);
    house.role = ObstacleRole::Environment;
    let mut still = standing;
    still.role = ObstacleRole::Static;
    for parts in [point_mass(), uncertain(), occupied(), still, house] {
        scenario.obstacles.push(Obstacle::new(parts, dt));
    }
    let network = &mut scenario.network;
    let (first, second) = (network.lanelets[0].id, network.lanelets[1].id);
    let lanelet = &mut network.lanelets[0];
    lanelet.adjacent_left = Some(Adjacent {
        id: second,
        same_direction: false,
    });
    lanelet.adjacent_right = None;
    lanelet.left.marking = LineMarking::SolidDashed;
    lanelet.stop_line = Some(StopLine {
        points: Some((Point::new(1.0, 2.0), Point::new(1.0, -2.0))),
        marking: LineMarking::Solid,
        signs: vec![8001],
        lights: vec![8002],
    });
    network.signs.push(Sign {
        id: 8001,
        elements: vec![SignElement {
            id: "R6-1L".into(),
            values: vec![],
        }],
        position: Some(Point::new(1.0, 5.0)),
        is_virtual: false,
    });
    network.lights.push(TrafficLight {
        id: 8002,
        cycle: vec![LightPhase {
            duration: 5,
            color: SignalColor::Red,
        }],
        offset: 0,
        position: Some(Point::new(2.0, 5.0)),
        direction: Some(TrafficDirection::LeftStraight),
        active: true,
    });
    let incoming = |id, left_of: i64| Incoming {
        id,
        lanelets: vec![first],
        left: vec![second],
        right: vec![],
        is_left_of: Some(left_of),
        ..Incoming::default()
    };
    network.intersections = vec![Intersection {
        id: 8003,
        incomings: vec![
            incoming(8004, 8005),
            incoming(8005, 8006),
            incoming(8006, 8004),
        ],
        crossings: vec![],
    }];
    scenario.planning_problems[0].goals.push(Goal {
        time: Steps { from: 3, to: 9 },
        positions: vec![
            Position::Region(box_there()),
            Position::Lanelets(vec![first]),
        ],
        orientation: Some(Quantity::Interval(3.0, 3.2)),
        velocity: Some(Quantity::Interval(1.0, 2.0)),
    });
    let ego = entry.recorded_ego(&scenario).unwrap().unwrap();
    Scene::new(Arc::new(scenario), ego)
}

#[test]
fn everything_goes_with_the_scene_and_comes_back() {
    let scene = everything();
    for change in super::changes() {
        let found = super::differences(&scene, &change);
        // A thing without a heading has one after it was turned; the rest is the same.
        let headings =
            |d: &String| d.starts_with("obstacles") && matches!(change, Transform::Rotate(_));
        let others: Vec<_> = found.iter().filter(|d| !headings(d)).collect();
        assert!(others.is_empty(), "{change}: {others:#?}");
    }
    let mut without = (*scene.scenario).clone();
    without.obstacles.retain(|o| o.id != 9004);
    let without = Scene::new(Arc::new(without), scene.ego);
    for change in super::changes() {
        let found = alike::on_the_way_back(&without, &change);
        assert!(found.is_empty(), "{change}: {found:#?}");
    }
}

#[test]
fn in_a_mirror_left_is_right() {
    let scene = everything();
    let before = &scene.scenario;
    let changed = Transform::Mirror.apply(&scene).scene;
    let after = &changed.scenario;
    let (a, b) = (&before.network.lanelets[0], &after.network.lanelets[0]);
    assert_eq!(
        (a.adjacent_left, a.adjacent_right),
        (b.adjacent_right, b.adjacent_left)
    );
    assert_eq!(b.right.marking, LineMarking::DashedSolid);
    for (p, q) in a.left.points.iter().zip(&b.right.points) {
        assert_eq!((p.x, p.y), (q.x, -q.y));
    }
    let line = b.stop_line.as_ref().unwrap();
    assert_eq!(
        line.points,
        Some((Point::new(1.0, 2.0), Point::new(1.0, -2.0)))
    );
    let network = &after.network;
    assert_eq!(network.signs.last().unwrap().elements[0].id, "R6-1R");
    let light = network.lights.last().unwrap();
    assert_eq!(light.direction, Some(TrafficDirection::StraightRight));
    assert_eq!(light.position, Some(Point::new(2.0, -5.0)));
    let crossing = &network.intersections[0];
    // 8004 was left of 8005: now that one is left of it.
    assert_eq!(crossing.incomings[1].is_left_of, Some(8004));
    assert_eq!(crossing.incomings[0].right.len(), 1);
    let doubtful = after.obstacle(9002).unwrap();
    let first = doubtful.initial.as_ref().unwrap();
    assert_eq!(first.orientation, Some(Quantity::Interval(-0.5, -0.1)));
    assert_eq!(
        first.quantity(StateField::YawRate),
        Some(Quantity::Interval(-0.3, 0.1))
    );
    let wheel = first.quantity(StateField::RightFrontWheelAngularSpeed);
    assert_eq!(wheel, Some(Quantity::Exact(11.0)));
    assert_eq!(
        doubtful.signals[0].signals,
        [
            (Signal::IndicatorRight, true),
            (Signal::IndicatorLeft, false)
        ]
    );
    let mass = after.obstacle(9001).unwrap().track().at(0).unwrap();
    assert!((mass.velocity_vector().y + 4.0).abs() < 1e-9);
}

#[test]
fn a_quarter_turn_turns_velocities_regions_and_goals() {
    let scene = everything();
    let change = Transform::Rotate(FRAC_PI_2);
    let changed = change.apply(&scene).scene;
    let mass = |scene: &Scene| {
        *scene
            .scenario
            .obstacle(9001)
            .unwrap()
            .track()
            .at(3)
            .unwrap()
    };
    let (a, b) = (mass(&scene), mass(&changed));
    let (v, w) = (a.velocity_vector(), b.velocity_vector());
    assert!(
        (v.x - w.y).abs() < 1e-9 && (v.y + w.x).abs() < 1e-9,
        "{v} {w}"
    );
    // Along (3, 4) / 5 the acceleration (0.5, -1) is -0.5.
    assert!((a.acceleration + 0.5).abs() < 1e-9 && (b.acceleration + 0.5).abs() < 1e-9);
    let goal = |scene: &Scene| {
        scene.scenario.planning_problems[0]
            .goals
            .last()
            .unwrap()
            .clone()
    };
    let Some(Quantity::Interval(from, to)) = goal(&changed).orientation else {
        panic!("no interval");
    };
    assert!(from < to && to - from < 0.21, "{from} to {to}");
    assert!(((from + to) / 2.0 - (3.1 + FRAC_PI_2 - std::f64::consts::TAU)).abs() < 1e-9);
    assert_eq!(goal(&changed).lanelets(), goal(&scene).lanelets());
    let still = changed
        .scenario
        .obstacle(9004)
        .unwrap()
        .track()
        .at(0)
        .unwrap();
    assert!((still.pose.heading - FRAC_PI_2).abs() < 1e-9);
    let house = |scene: &Scene| scene.scenario.obstacle(9005).unwrap().footprint.clone();
    assert_ne!(house(&scene), house(&changed));
    let Prediction::Occupancies(regions) = &changed.scenario.obstacle(9003).unwrap().prediction
    else {
        panic!("no regions");
    };
    assert_eq!(regions.len(), 4);
}

#[test]
fn an_obstacle_as_the_ego_stays_the_ego() {
    let entry = &bundled()[0];
    let scenario = entry.read().unwrap();
    let movers = scenario
        .obstacles
        .iter()
        .filter(|o| o.role == ObstacleRole::Dynamic);
    let id = movers.map(|o| o.id).next().unwrap();
    let scene = Scene::with_obstacle_as_ego(scenario, id).unwrap();
    for change in super::changes() {
        let changed = change.apply(&scene);
        let ego = &changed.scene.ego;
        assert_eq!(changed.original(ego.id), id, "{change}");
        assert_eq!(ego.source, EgoSource::Obstacle(ego.id));
        let obstacle = changed.scene.scenario.obstacle(ego.id).unwrap();
        assert_eq!(&ego.track, obstacle.track());
        let found = super::measures(&scene, &change);
        assert!(found.is_empty(), "{change}: {found:#?}");
    }
}

#[test]
fn numbers_are_given_by_the_seed_and_to_nobody_twice() {
    let scene = everything();
    let ids = |seed| Transform::Renumber(seed).ids(&scene.scenario);
    assert_eq!(ids(5), ids(5));
    assert_ne!(ids(5), ids(6));
    let mut old: Vec<i64> = ids(5).into_values().collect();
    old.sort_unstable();
    let new: Vec<i64> = ids(5).into_keys().collect();
    assert_eq!(old, new);
    assert!(ids(5).iter().all(|(new, old)| new != old));
    let mut alone = (*scene.scenario).clone();
    alone.obstacles.truncate(1);
    let ids = Transform::Renumber(3).ids(&alone);
    let (new, old) = ids.first_key_value().unwrap();
    assert!(*old == alone.obstacles[0].id && *new > 8006, "{ids:?}");
}
