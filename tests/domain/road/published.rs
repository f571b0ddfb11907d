//! Real maps: routes of all planning problems, recorded egos on theirs, the drivable area; with figures.

use std::sync::Arc;

use nearmiss::formats::{Entry, find};
use nearmiss::geometry::{Footprint, FrenetError, Point, Pose, Shape, Vector, contains};
use nearmiss::scenario::{Lane, RoadUser, Scenario};

use crate::support::recorded::shared;

/// The published scenarios; nothing, and a word about it, where they are not there.
fn entries() -> Vec<Entry> {
    let Some(folder) = shared("from-words-to-collisions/Scenarios") else {
        return Vec::new();
    };
    find(&[folder]).expect("a folder that can be read").entries
}

fn poses(entry: &Entry, scenario: &Arc<Scenario>) -> (Footprint, Vec<Pose>) {
    let ego = entry
        .recorded_ego(scenario)
        .unwrap()
        .expect("a recorded ego");
    let poses = ego.track.iter().map(|(_, motion)| motion.pose).collect();
    (ego.footprint, poses)
}

#[test]
fn every_planning_problem_has_a_route_and_every_recorded_position_is_beside_one() {
    let (mut problems, mut routed, mut positions, mut missed) = (0, 0, 0, Vec::new());
    let (mut deviation, mut error) = (0.0_f64, 0.0_f64);
    for entry in entries() {
        let scenario = entry.read().unwrap();
        let graph = scenario.network.lane_graph(Some(RoadUser::Car));
        for problem in &scenario.planning_problems {
            problems += 1;
            match graph.route(problem) {
                Ok(route) => {
                    routed += 1;
                    deviation = deviation.max(route.path.deviation());
                    assert!(
                        route.length() >= 0.0 && route.length() < 2000.0,
                        "{}",
                        entry.name
                    );
                }
                Err(error) => println!("{}: {error}", entry.name),
            }
        }
        let (_, poses) = poses(&entry, &scenario);
        let route = graph
            .route_along(poses.iter().copied())
            .unwrap_or_else(|error| panic!("{}: {error}", entry.name));
        deviation = deviation.max(route.path.deviation());
        let mut hint = route.start;
        for pose in &poses {
            positions += 1;
            match route.path.project_near(&pose.position, hint, 20.0) {
                Ok(at) => {
                    let here = route.path.at(at.s);
                    let back = here.position + here.normal() * at.d;
                    error = error.max((back - pose.position).norm());
                    hint = at.s;
                }
                Err(FrenetError::Ambiguous { .. }) => {}
                Err(why) => missed.push(format!("{}: {pose:?}: {why}", entry.name)),
            }
        }
    }
    println!(
        "{routed} of {problems} planning problems have a route; {positions} recorded positions round trip within {error:e} m; paths leave the middle of their lanes by at most {deviation:.3} m"
    );
    assert!(missed.is_empty(), "{missed:#?}");
    assert_eq!(routed, problems);
    assert!(error < 1e-3 && deviation < 0.1, "{error} {deviation}");
}

#[test]
fn lanelets_and_drivable_area_agree_on_real_maps() {
    let dot = Footprint::new(Shape::Circle {
        radius: 0.002,
        center: Point::origin(),
    })
    .unwrap();
    let (mut egos, mut on_road, mut lanelets, mut curled) = (0, 0, 0, Vec::new());
    for entry in entries() {
        let scenario = entry.read().unwrap();
        let network = &scenario.network;
        let road = network.drivable_area(None);
        let (footprint, poses) = poses(&entry, &scenario);
        for lanelet in &network.lanelets {
            let lane = Lane::from_lanelet(lanelet).unwrap();
            let middle = (0..=8)
                .map(|i| lane.length() * f64::from(i) / 8.0)
                .map(|s| lane.centre().pose_at(s).position);
            lanelets += 1;
            // A few lanelets have a border that curls, so that their middle is beside them.
            if middle.clone().any(|p| !contains(&lanelet.ring(), &p)) {
                curled.push(format!("{} {}", entry.name, lanelet.id));
                continue;
            }
            for p in middle {
                assert!(network.lanelets_at(&p).contains(&lanelet.id));
                assert!(road.contains(&p), "{}: {} at {p}", entry.name, lanelet.id);
            }
        }
        // Random points: on the area where they are on a lanelet, and off it where none is near.
        let bounds = network.bounds().unwrap();
        let size = bounds.max - bounds.min;
        for i in 1..400 {
            let share = |base: f64| (f64::from(i) * base).fract();
            let p = bounds.min
                + Vector::new(size.x * share(0.754_877_666), size.y * share(0.569_840_291));
            let on = !network.lanelets_at(&p).is_empty();
            let (_, distance) = network.nearest_lanelet(&p).unwrap();
            assert_eq!(on, distance == 0.0);
            if on || distance > 0.051 {
                assert_eq!(road.contains(&p), on, "{}: {p} {distance}", entry.name);
                if !on {
                    assert!(!road.covers(&dot.at(Pose {
                        position: p,
                        heading: 0.0
                    })));
                }
            }
        }
        egos += 1;
        let mut worst: Option<(usize, f64, f64)> = None;
        let mut off = 0;
        for (step, pose) in poses.iter().enumerate() {
            if let Some(out) = road.outside(&footprint.at(*pose)) {
                off += 1;
                if worst.is_none_or(|(_, size, _)| out.size > size) {
                    worst = Some((step, out.size, out.distance));
                }
            }
        }
        match worst {
            None => on_road += 1,
            Some((step, size, distance)) => println!(
                "{}: off the road at {off} of {} steps, most at {step}: {size:.2} m2, {distance:.2} m",
                entry.name,
                poses.len()
            ),
        }
    }
    println!(
        "the middle is not wholly inside {} of {lanelets} lanelets: {curled:?}",
        curled.len()
    );
    assert!(curled.len() * 200 <= lanelets, "{curled:?}");
    println!("{on_road} of {egos} recorded egos stay on the drivable area");
    // The others reach over an end of the map, or are turned on the spot by their recorder.
    assert!(on_road * 10 >= egos * 9);
}
