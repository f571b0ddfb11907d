//! Routes on small networks: changes of lane, forks, cycles, directions, goals, and why there is none.

use std::f64::consts::{FRAC_PI_2, PI};

use nearmiss::geometry::{Point, Pose};
use nearmiss::scenario::{
    Destination, DirectedLanelet, Direction, LaneletNetwork, Position, RoadUser, Route, RouteError,
    Side,
};

use crate::road::built::*;

fn along(lanelet: i64) -> DirectedLanelet {
    DirectedLanelet {
        lanelet,
        direction: Direction::Along,
    }
}

fn lanelets(route: &Result<Route, RouteError>) -> Vec<i64> {
    route.as_ref().unwrap_or_else(|e| panic!("{e}")).lanelets()
}

#[test]
fn straight_on_and_a_lane_change() {
    let network = two_lanes();
    let graph = network.lane_graph(None);
    let straight = graph.route(&problem(
        Pose::new(10.0, 0.5, 0.0),
        vec![to_region(150.0, 0.0)],
    ));
    assert_eq!(lanelets(&straight), [11, 21]);
    let straight = straight.unwrap();
    assert!(
        (straight.length() - 142.0).abs() < 0.6,
        "{}",
        straight.length()
    );
    assert_eq!(straight.destination, Destination::Goal(0));

    let change = graph
        .route(&problem(
            Pose::new(10.0, 0.5, 0.0),
            vec![to_region(150.0, WIDTH)],
        ))
        .unwrap();
    let sides: Vec<_> = change.legs.iter().filter_map(|l| l.change).collect();
    assert_eq!((sides, change.legs.len()), (vec![Side::Left], 3));
    // Smooth across: on the first lane's middle at the start, on the other's at the goal, never beyond.
    assert!(change.path.at(change.start).position.y.abs() < 0.1);
    assert!((change.path.at(change.end).position.y - WIDTH).abs() < 0.1);
    let mut s = change.start;
    while s < change.end {
        let here = change.path.at(s);
        assert!((-0.1..WIDTH + 0.1).contains(&here.position.y) && here.curvature.abs() < 0.02);
        s += 0.5;
    }
    let back = graph.route(&problem(Pose::new(10.0, WIDTH, 0.0), vec![to_lanelet(21)]));
    assert!(
        back.unwrap()
            .legs
            .iter()
            .any(|l| l.change == Some(Side::Right))
    );
    assert_eq!(graph.successors(along(11)), [along(21)]);
    assert_eq!(graph.neighbour(along(11), Side::Left), Some(along(12)));
    assert_eq!(
        graph.neighbour(along(12), Side::Left),
        None,
        "oncoming traffic"
    );
}

#[test]
fn a_goal_behind_the_start_is_reached_around_or_not_at_all() {
    let network = two_lanes();
    let graph = network.lane_graph(None);
    let behind = graph.route(&problem(
        Pose::new(50.0, 0.0, 0.0),
        vec![to_region(20.0, 0.0)],
    ));
    assert_eq!(
        behind.unwrap_err(),
        RouteError::Unreachable {
            from: vec![11],
            to: vec![11]
        }
    );
    let beside = graph.route(&problem(
        Pose::new(50.0, 0.0, 0.0),
        vec![to_region(20.0, WIDTH)],
    ));
    assert!(matches!(beside, Err(RouteError::Unreachable { .. })));
    let here = graph.route(&problem(
        Pose::new(50.0, 0.0, 0.0),
        vec![to_region(50.0, 0.0)],
    ));
    assert_eq!(lanelets(&here), [11]);

    let ring = roundabout();
    let graph = ring.lane_graph(None);
    let start = Pose::new(15.0 * 0.5_f64.cos(), 15.0 * 0.5_f64.sin(), 0.5 + FRAC_PI_2);
    let point = Point::new(15.0 * 0.2_f64.cos(), 15.0 * 0.2_f64.sin());
    let around = graph.route(&problem(start, vec![goal(vec![Position::Point(point)])]));
    assert_eq!(lanelets(&around), [1, 2, 3, 4, 1]);
    let around = around.unwrap();
    assert!(
        (around.length() - 15.0 * (2.0 * PI - 0.3)).abs() < 1.0,
        "{}",
        around.length()
    );
}

#[test]
fn through_a_roundabout_every_position_keeps_its_place() {
    let network = roundabout();
    let graph = network.lane_graph(Some(RoadUser::Car));
    let route = graph
        .route(&problem(Pose::new(-30.0, -15.0, 0.0), vec![to_lanelet(8)]))
        .unwrap();
    assert_eq!(route.lanelets(), [9, 4, 1, 8]);
    assert!(route.path.deviation() < 0.1);
    let mut s = route.start;
    while s < route.end {
        for d in [-2.0, 0.0, 2.0] {
            let here = route.path.at(s);
            let p = here.position + here.normal() * d;
            let back = route.path.project_near(&p, s, 3.0).unwrap();
            assert!(
                (back.s - s).abs() < 1e-6 && (back.d - d).abs() < 1e-6,
                "{s} {d}: {back:?}"
            );
        }
        s += 0.37;
    }
}

#[test]
fn bidirectional_lanelets_are_driven_both_ways() {
    let one = vec![
        bidirectional(lanelet(1, &[(0., 0.), (50., 0.)])),
        bidirectional(lanelet(2, &[(50., 0.), (90., 10.)])),
    ];
    let network = network(one, &[(1, 2)], &[]);
    let graph = network.lane_graph(Some(RoadUser::Car));
    let back = graph
        .route(&problem(
            Pose::new(80.0, 7.5, PI),
            vec![to_region(10.0, 0.0)],
        ))
        .unwrap();
    assert_eq!(back.lanelets(), [2, 1]);
    assert!(
        back.legs
            .iter()
            .all(|l| l.driven.direction == Direction::Against)
    );
    assert!(back.path.at(back.end).heading.abs() > 3.0 && back.length() > 65.0);
    // The file does not name pedestrians there.
    let walk = network.lane_graph(Some(RoadUser::Pedestrian));
    let refused = walk.route(&problem(Pose::new(10.0, 0.0, 0.0), vec![to_lanelet(2)]));
    assert!(matches!(refused, Err(RouteError::StartOffRoad { nearest: Some((1, d)) }) if d == 0.0));
    // The oncoming neighbour may be used where it is open to both directions.
    let lanes = |open: bool| {
        let other = lanelet(2, &[(100., WIDTH), (0., WIDTH)]);
        let other = if open { bidirectional(other) } else { other };
        super::built::network(
            vec![lanelet(1, &[(0., 0.), (100., 0.)]), other],
            &[],
            &[(1, 2, false)],
        )
    };
    let (open, closed) = (lanes(true), lanes(false));
    let overtake = problem(Pose::new(10.0, 0.0, 0.0), vec![to_region(80.0, WIDTH)]);
    let route = open.lane_graph(None).route(&overtake).unwrap();
    assert_eq!(
        route.legs[1].driven,
        DirectedLanelet {
            lanelet: 2,
            direction: Direction::Against
        }
    );
    assert!((route.path.at(route.end).position.y - WIDTH).abs() < 0.2);
    assert!(matches!(
        closed.lane_graph(None).route(&overtake),
        Err(RouteError::Unreachable { .. })
    ));
}

/// 1 leads into a crossing where 2 turns left, 3 goes straight on and 4 turns right.
fn fork() -> LaneletNetwork {
    let left: Vec<_> = arc(50.0, 12.0, 12.0, -FRAC_PI_2, 0.0);
    let right: Vec<_> = arc(50.0, -12.0, 12.0, FRAC_PI_2, 0.0);
    let lanelets = vec![
        lanelet(1, &[(0., 0.), (50., 0.)]),
        lanelet(2, &left),
        lanelet(3, &[(50., 0.), (100., 1.)]),
        lanelet(4, &right),
    ];
    network(lanelets, &[(1, 2), (1, 4), (1, 3)], &[])
}

#[test]
fn at_a_fork_goal_and_heading_decide_and_the_road_ahead_is_straight() {
    let network = fork();
    let graph = network.lane_graph(None);
    let from = Pose::new(53.0, 0.0, 0.0);
    assert!(
        network.lanelets_at(&from.position).len() == 3,
        "the branches overlap"
    );
    for id in [2, 3, 4] {
        assert_eq!(
            lanelets(&graph.route(&problem(from, vec![to_lanelet(id)]))),
            [id]
        );
    }
    let ahead = graph
        .route(&problem(Pose::new(5.0, 0.0, 0.0), vec![goal(vec![])]))
        .unwrap();
    assert_eq!(
        (ahead.lanelets(), ahead.destination),
        (vec![1, 3], Destination::RoadAhead)
    );
    let turned = Pose::new(56.0, -2.2, -0.7);
    assert_eq!(lanelets(&graph.road_ahead(&turned, 50.0)), [4]);
    // The route begins with road behind it and ends with road after it.
    assert!(ahead.path.length() >= ahead.end - 1.0 && ahead.start >= 4.9);
}

#[test]
fn a_recording_is_followed_through_fork_and_lane_change() {
    let network = fork();
    let graph = network.lane_graph(None);
    let left = (0..60).map(|i| {
        let s = f64::from(i);
        if s < 45.0 {
            return Pose::new(5.0 + s, 0.2, 0.0);
        }
        let turn = (s - 45.0) / 12.0;
        Pose::new(50.0 + 12.0 * turn.sin(), 12.0 - 12.0 * turn.cos(), turn)
    });
    let route = graph.route_along(left).unwrap();
    assert_eq!(
        (route.lanelets(), route.destination),
        (vec![1, 2], Destination::Recording)
    );

    let network = two_lanes();
    let graph = network.lane_graph(None);
    let change = (0..180).map(|i| {
        let x = f64::from(i);
        let t = ((x - 40.0) / 40.0).clamp(0.0, 1.0);
        Pose::new(x + 5.0, WIDTH * t * t * (3.0 - 2.0 * t), 0.0)
    });
    let poses: Vec<Pose> = change.collect();
    let route = graph.route_along(poses.iter().copied()).unwrap();
    assert_eq!(route.lanelets(), [11, 12, 22]);
    for pose in &poses {
        let at = route.path.project(&pose.position).unwrap();
        assert!(at.d.abs() < 1.0, "{pose:?}: {at:?}");
    }
    let jump = [
        Pose::new(10.0, 0.0, 0.0),
        Pose::new(90.0, 2.0 * WIDTH, PI),
        Pose::new(80.0, 2.0 * WIDTH, PI),
    ];
    assert!(matches!(
        graph.route_along(jump),
        Err(RouteError::Jumps { to: 31, .. })
    ));
    assert_eq!(
        graph.route_along([Pose::new(0.0, 99.0, 0.0)]).unwrap_err(),
        RouteError::NeverOnRoad
    );
}

#[test]
fn every_reason_has_its_words() {
    let network = two_lanes();
    let graph = network.lane_graph(None);
    let at = |x: f64, y: f64, heading: f64, goals| {
        graph.route(&problem(Pose::new(x, y, heading), goals))
    };
    let off = at(10.0, -5.0, 0.0, vec![to_lanelet(11)]).unwrap_err();
    assert!(
        matches!(off, RouteError::StartOffRoad { nearest: Some((11, d)) } if (d - 3.25).abs() < 1e-9)
    );
    assert!(off.to_string().contains("3.25 m away"), "{off}");
    let against = at(10.0, 0.0, PI, vec![to_lanelet(11)]).unwrap_err();
    assert_eq!(against, RouteError::AgainstDirection { lanelets: vec![11] });
    let unknown = at(10.0, 0.0, 0.0, vec![to_lanelet(77)]).unwrap_err();
    assert!(unknown.to_string().contains("no lanelet 77"), "{unknown}");
    let nowhere = at(10.0, 0.0, 0.0, vec![to_region(0.0, 500.0)]).unwrap_err();
    assert_eq!(nowhere, RouteError::GoalOffRoad { unknown: vec![] });
    let none = LaneletNetwork::default();
    let empty = none
        .lane_graph(None)
        .route(&problem(Pose::new(0.0, 0.0, 0.0), vec![to_lanelet(1)]));
    assert_eq!(empty.unwrap_err(), RouteError::NoRoad);
    let mut unsaid = problem(Pose::new(0.0, 0.0, 0.0), vec![to_lanelet(11)]);
    unsaid.initial.position = None;
    assert_eq!(graph.route(&unsaid).unwrap_err(), RouteError::NoStart);
}

#[test]
fn a_route_is_the_same_anywhere_on_earth() {
    let here = roundabout();
    let frame = Pose::new(1e5, -1e5, 1.0);
    let mut moved = here.lanelets.clone();
    for bound in moved.iter_mut().flat_map(|l| [&mut l.left, &mut l.right]) {
        bound.points.iter_mut().for_each(|p| *p = frame.to_world(p));
    }
    let there = LaneletNetwork::new(moved, vec![], vec![], vec![]);
    let start = Pose::new(-30.0, -15.0, 0.0);
    let far = Pose {
        position: frame.to_world(&start.position),
        heading: 1.0,
    };
    let routes = [(&here, start), (&there, far)].map(|(n, s)| {
        n.lane_graph(None)
            .route(&problem(s, vec![to_lanelet(8)]))
            .unwrap()
    });
    assert_eq!(routes[0].legs, routes[1].legs);
    assert!((routes[0].length() - routes[1].length()).abs() < 1e-6);
    let beside = Point::new(3.0, 13.0);
    let [a, b] = [
        routes[0].path.project(&beside).unwrap(),
        routes[1].path.project(&frame.to_world(&beside)).unwrap(),
    ];
    assert!((a.s - b.s).abs() < 1e-6 && (a.d - b.d).abs() < 1e-6);
}
