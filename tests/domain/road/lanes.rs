//! Lanelets under points and boxes, lanes, merged lanes, the drivable area, and broken networks.

use nearmiss::geometry::{Footprint, Point, Pose, Shape};
use nearmiss::scenario::{Lane, LaneletNetwork, RoadUser};

use crate::road::built::*;

fn car() -> Footprint {
    Footprint::new(Shape::rectangle(4.5, 1.8)).unwrap()
}

fn line(points: &[(f64, f64)]) -> Vec<Point> {
    points.iter().map(|&(x, y)| Point::new(x, y)).collect()
}

#[test]
fn no_point_falls_between_lanelets() {
    let network = two_lanes();
    for i in 0..=100 {
        let x = f64::from(i);
        let shared = network.lanelets_at(&Point::new(x, WIDTH / 2.0));
        assert!(shared.starts_with(&[11, 12]), "{x}: {shared:?}");
    }
    assert_eq!(network.lanelets_at(&Point::new(100.0, 0.0)), [11, 21]);
    assert_eq!(
        network.lanelets_at(&Point::new(100.0, WIDTH / 2.0)),
        [11, 12, 21, 22]
    );
    assert!(network.lanelets_at(&Point::new(50.0, -WIDTH)).is_empty());
    let car = car();
    let under = |x, y, heading| network.lanelets_under(&car.at(Pose::new(x, y, heading)));
    assert_eq!(under(50.0, 0.0, 0.0), [11]);
    assert_eq!(under(99.0, 0.0, 0.0), [11, 21]);
    assert_eq!(under(50.0, 1.5, 0.0), [11, 12]);
    assert_eq!(
        under(50.0, WIDTH / 2.0 - 0.9, 0.0),
        [11],
        "a touching side is not on the neighbour"
    );
    assert!(under(50.0, -40.0, 0.0).is_empty());
    assert_eq!(
        network.nearest_lanelet(&Point::new(50.0, -WIDTH)),
        Some((11, WIDTH / 2.0))
    );
}

#[test]
fn centre_lines_and_widths_of_all_kinds_of_borders() {
    let plain = Lane::from_lanelet(&lanelet(1, &[(0., 0.), (30., 40.)])).unwrap();
    assert!((plain.length() - 50.0).abs() < 1e-6 && (plain.width_at(20.0) - WIDTH).abs() < 1e-6);
    // Different numbers of points: by shares of the arc length.
    let uneven = between(
        2,
        line(&[(0., 4.), (1., 4.), (2., 4.), (40., 4.)]),
        line(&[(0., 0.), (40., 0.)]),
    );
    let uneven = Lane::from_lanelet(&uneven).unwrap();
    assert!(
        uneven
            .centre()
            .points()
            .iter()
            .all(|p| (p.y - 2.0).abs() < 1e-9)
    );
    assert!((uneven.length() - 40.0).abs() < 1e-9 && (uneven.width_at(7.0) - 4.0).abs() < 1e-9);
    // Drawn the other way: which one, the sides decide.
    let ahead = line(&[(0., 4.), (10., 4.), (40., 4.)]);
    let back = line(&[(40., 0.), (10., 0.), (0., 0.)]);
    let opposite = between(3, ahead.clone(), back.clone());
    let lane = Lane::from_lanelet(&opposite).unwrap();
    assert!(
        (lane.centre().pose_at(20.0).heading).abs() < 1e-9 && (lane.length() - 40.0).abs() < 1e-9
    );
    assert!(nearmiss::geometry::contains(
        &opposite.ring(),
        &Point::new(30.0, 2.0)
    ));
    let swapped = Lane::from_lanelet(&between(4, back, ahead)).unwrap();
    assert!((swapped.centre().pose_at(20.0).heading.abs() - std::f64::consts::PI).abs() < 1e-9);
    // A ring of which the ends meet.
    let ring =
        Lane::from_lanelet(&lanelet(5, &arc(0., 0., 15., 0.0, std::f64::consts::TAU))).unwrap();
    assert!((ring.length() - 94.2).abs() < 0.5 && (ring.width_at(30.0) - WIDTH).abs() < 0.1);
    // A border without length, and nothing but one spot.
    let wedge = between(6, line(&[(0., 2.), (0., 2.)]), line(&[(0., 0.), (3., 0.)]));
    assert!((Lane::from_lanelet(&wedge).unwrap().length() - 1.5).abs() < 1e-9);
    let spot = between(7, line(&[(1., 1.), (1., 1.)]), line(&[(1., 1.), (1., 1.)]));
    assert!(Lane::from_lanelet(&spot).is_none());
}

fn network_of(lanelets: Vec<nearmiss::scenario::Lanelet>, on: &[(i64, i64)]) -> LaneletNetwork {
    crate::road::built::network(lanelets, on, &[])
}

#[test]
fn the_drivable_area_is_whole_at_joints_and_between_neighbours() {
    let network = two_lanes();
    let (road, car) = (network.drivable_area(None), car());
    for i in 5..195 {
        let x = f64::from(i);
        let y = f64::from(i % 70) / 70.0 * WIDTH;
        assert!(
            road.covers(&car.at(Pose::new(x, y, 0.1 * f64::from(i % 3)))),
            "{x} {y}"
        );
    }
    assert!(!road.covers(&car.at(Pose::new(50.0, -1.0, 0.0))));
    let out = road.outside(&car.at(Pose::new(50.0, -1.0, 0.0))).unwrap();
    assert!(
        (out.distance - 0.15).abs() < 2e-3 && (out.size - 0.15 * 4.5).abs() < 1e-2,
        "{out:?}"
    );
    assert_eq!(road.border().count(), 1);
    // A joint with a gap of centimetres is driven over, one of half a metre is not.
    for (gap, whole) in [(0.03, true), (-0.4, true), (0.5, false)] {
        let lanes = vec![
            lanelet(1, &[(0., 0.), (50., 0.)]),
            lanelet(2, &[(50. + gap, 0.), (90., 0.)]),
        ];
        let road = network_of(lanes, &[(1, 2)]).drivable_area(None);
        assert_eq!(
            road.covers(&car.at(Pose::new(50.0, 0.3, 0.05))),
            whole,
            "{gap}"
        );
    }
    // By road user.
    let mut walk = lanelet(2, &[(0., WIDTH), (50., WIDTH)]);
    walk.users_one_way = vec![RoadUser::Pedestrian];
    let both = network_of(vec![lanelet(1, &[(0., 0.), (50., 0.)]), walk], &[]);
    let across = Pose::new(20.0, 1.5, 0.0);
    assert!(both.drivable_area(None).covers(&car.at(across)));
    assert!(
        !both
            .drivable_area(Some(RoadUser::Car))
            .covers(&car.at(across))
    );
}

#[test]
fn a_hairpin_keeps_its_inside_apart() {
    let mut bend = vec![(0., 0.), (40., 0.)];
    bend.extend(arc(
        40.,
        5.,
        5.,
        -std::f64::consts::FRAC_PI_2,
        std::f64::consts::FRAC_PI_2,
    ));
    bend.extend([(40., 10.), (0., 10.)]);
    let network = network_of(vec![lanelet(1, &bend)], &[]);
    let road = network.drivable_area(None);
    assert!(
        network.lanelets_at(&Point::new(20.0, 5.0)).is_empty()
            && !road.contains(&Point::new(20.0, 5.0))
    );
    assert!(road.covers(&car().at(Pose::new(20.0, 10.0, 0.0))));
    assert!(!road.covers(&car().at(Pose::new(20.0, 5.0, 0.0))));
}

#[test]
fn broken_networks_are_survived() {
    let spot = || line(&[(5., 5.), (5., 5.)]);
    let mut broken = vec![
        between(1, spot(), spot()),
        between(
            2,
            line(&[(0., 0.), (10., 10.)]),
            line(&[(0., 10.), (10., 0.)]),
        ),
        between(
            3,
            line(&[(1e300, 0.), (0., 1e300)]),
            line(&[(-1e300, 0.), (0., 0.)]),
        ),
        between(4, vec![], vec![]),
        lanelet(5, &[(0., 0.), (9., 0.)]),
        lanelet(5, &[(20., 0.), (29., 0.)]),
    ];
    for lanelet in &mut broken {
        lanelet.successors = vec![lanelet.id, 1, 2, 3, 99];
        lanelet.predecessors = vec![4, 5, 98];
        lanelet.adjacent_left = Some(nearmiss::scenario::Adjacent {
            id: lanelet.id,
            same_direction: false,
        });
        lanelet.adjacent_right = Some(nearmiss::scenario::Adjacent {
            id: 97,
            same_direction: true,
        });
    }
    let network = LaneletNetwork::new(broken, vec![], vec![], vec![]);
    let road = network.drivable_area(None);
    let graph = network.lane_graph(None);
    for (x, y) in [
        (5., 5.),
        (2., 1.),
        (25., 0.),
        (1e299, 0.),
        (f64::NAN, 0.),
        (f64::INFINITY, 1.),
    ] {
        let here = Pose::new(x, y, 0.3);
        let _ = network.lanelets_at(&here.position);
        let _ = network.nearest_lanelet(&here.position);
        let _ = network.lanelets_under(&car().at(here));
        let _ = (
            road.covers(&car().at(here)),
            road.contains(&here.position),
            road.outside(&car().at(here)),
        );
        let _ = graph.road_ahead(&here, 1e9);
        let _ = graph.route_along([here, Pose::new(y, x, 0.0)]);
        for id in [1, 2, 3, 4, 5, 99] {
            let _ = graph.route(&problem(here, vec![to_lanelet(id), to_region(x, y)]));
        }
    }
    assert!(network.lanelets_at(&Point::new(25.0, 0.0)).contains(&5));
    assert_eq!(network, network.clone());
}
