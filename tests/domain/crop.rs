//! Parts of the bundled scenarios: motions as they were, references that hold, nothing new to doubt.
#![allow(clippy::unwrap_used, clippy::expect_used)]

use std::collections::BTreeSet;
use std::sync::Arc;

use nearmiss::formats::bundled;
use nearmiss::scenario::plausibility::check;
use nearmiss::scenario::{
    Around, Centre, Crop, CropError, Cropped, Differences, Ego, Obstacle, ObstacleParts,
    Prediction, Scenario, Steps,
};

/// Every bundled scenario with its ego.
fn all() -> impl Iterator<Item = (Arc<Scenario>, Ego)> {
    bundled().into_iter().map(|entry| {
        let scenario = entry.read().unwrap();
        let ego = entry.recorded_ego(&scenario).unwrap().unwrap();
        (scenario, ego)
    })
}

fn named(name: &str) -> (Arc<Scenario>, Ego) {
    all()
        .find(|(s, _)| s.header.benchmark_id.contains(name))
        .unwrap()
}

fn around(text: &str) -> Option<Around> {
    Some(text.parse().unwrap())
}

/// Fails where a kept element refers to one that is gone.
fn refers_to_what_is_there(cropped: &Cropped) {
    let network = &cropped.scenario.network;
    let lanelets: BTreeSet<i64> = network.lanelets.iter().map(|l| l.id).collect();
    let signs: BTreeSet<i64> = network.signs.iter().map(|s| s.id).collect();
    let lights: BTreeSet<i64> = network.lights.iter().map(|l| l.id).collect();
    for lanelet in &network.lanelets {
        let beside = [lanelet.adjacent_left, lanelet.adjacent_right];
        let mut others = lanelet.predecessors.iter().chain(&lanelet.successors);
        assert!(others.all(|id| lanelets.contains(id)));
        assert!(
            beside
                .iter()
                .flatten()
                .all(|other| lanelets.contains(&other.id))
        );
        let line = lanelet.stop_line.iter();
        let lit = line.clone().flat_map(|line| &line.lights);
        let signed = line.flat_map(|line| &line.signs);
        assert!(
            lanelet
                .signs
                .iter()
                .chain(signed)
                .all(|id| signs.contains(id))
        );
        assert!(
            lanelet
                .lights
                .iter()
                .chain(lit)
                .all(|id| lights.contains(id))
        );
    }
    for intersection in &network.intersections {
        assert!(!intersection.incomings.is_empty());
        let roads: BTreeSet<i64> = intersection.incomings.iter().map(|r| r.id).collect();
        for road in &intersection.incomings {
            let ways = [&road.lanelets, &road.right, &road.straight, &road.left];
            assert!(!road.lanelets.is_empty());
            assert!(ways.into_iter().flatten().all(|id| lanelets.contains(id)));
            assert!(road.is_left_of.is_none_or(|id| roads.contains(&id)));
        }
        assert!(
            intersection
                .crossings
                .iter()
                .all(|id| lanelets.contains(id))
        );
    }
    let goals = cropped
        .scenario
        .planning_problems
        .iter()
        .flat_map(|p| &p.goals);
    assert!(
        goals
            .flat_map(|goal| goal.lanelets())
            .all(|id| lanelets.contains(&id))
    );
}

#[test]
fn motions_stay_what_they_were() {
    for (scenario, ego) in all() {
        let crop = Crop {
            steps: Some(20..=45),
            ..Crop::default()
        };
        let cropped = crop.apply(&scenario, Some(&ego)).unwrap();
        let (kept, driven) = (&cropped.scenario, cropped.ego.clone().unwrap());
        assert_eq!((kept.steps(), driven.track.steps()), (20..46, 20..46));
        assert_ne!(kept.hash, scenario.hash);
        for step in 20..46 {
            let (now, then) = (driven.track.at(step), ego.track.at(step));
            assert_eq!(now, then);
            for obstacle in &kept.obstacles {
                let before = scenario.obstacle(obstacle.id).unwrap();
                let (now, then) = (obstacle.motion_at(step), before.motion_at(step));
                assert_eq!(now, then, "obstacle {} at {step}", obstacle.id);
            }
        }
        let problem = &kept.planning_problems[0];
        let start = ego.track.at(20).unwrap();
        assert_eq!(problem.initial.time, Steps::exact(20));
        assert_eq!(problem.initial.point(), Some(start.pose.position));
        assert!(
            cropped.said[0].starts_with("kept 26 of "),
            "{:?}",
            cropped.said
        );
        assert!(cropped.said[1].contains("starts with the ego at step 20"));
    }
}

#[test]
fn what_states_do_not_say_is_worked_out_before() {
    let (scenario, ego) = named("CutIn");
    let mut bare = Scenario::clone(&scenario);
    for obstacle in &mut bare.obstacles {
        let mut parts = parts(obstacle);
        let states = parts.initial.iter_mut();
        let later = match &mut parts.prediction {
            Prediction::Trajectory(states) => states.as_mut_slice(),
            _ => &mut [],
        };
        for state in states.chain(later) {
            (state.velocity, state.acceleration, state.orientation) = (None, None, None);
        }
        *obstacle = Obstacle::new(parts, scenario.dt());
    }
    let crop = Crop {
        steps: Some(10..=30),
        ..Crop::default()
    };
    let cropped = crop.apply(&bare, Some(&ego)).unwrap();
    for obstacle in &cropped.scenario.obstacles {
        let before = bare.obstacle(obstacle.id).unwrap();
        for step in 10..31 {
            assert_eq!(obstacle.motion_at(step), before.motion_at(step), "{step}");
        }
    }
}

fn parts(obstacle: &Obstacle) -> ObstacleParts {
    ObstacleParts {
        id: obstacle.id,
        role: obstacle.role,
        kind: obstacle.kind,
        footprint: obstacle.footprint.clone(),
        initial: obstacle.initial.clone(),
        prediction: obstacle.prediction.clone(),
        signals: obstacle.signals.clone(),
    }
}

#[test]
fn an_area_keeps_references_whole_and_gives_no_new_doubts() {
    let mut left_out = 0;
    for (scenario, ego) in all() {
        let doubts: Vec<String> = check(&scenario).into_iter().map(|f| f.message).collect();
        for metres in [2, 10, 30, 60] {
            let crop = Crop {
                steps: Some(5..=40),
                around: around(&format!("ego:{metres}m")),
                ..Crop::default()
            };
            let cropped = crop.apply(&scenario, Some(&ego)).unwrap();
            refers_to_what_is_there(&cropped);
            let kept = &cropped.scenario;
            left_out += scenario.network.lanelets.len() - kept.network.lanelets.len();
            for found in check(kept) {
                let (id, message) = (&scenario.header.benchmark_id, found.message);
                assert!(doubts.contains(&message), "{id}, {metres} m: {message}");
            }
        }
    }
    assert!(left_out > 50, "{left_out}");
}

#[test]
fn obstacles_go_that_never_come_near() {
    let (scenario, ego) = named("CutIn");
    let apart = |obstacle: &Obstacle| {
        let steps = ego.track.iter();
        let near = steps.filter_map(|(step, motion)| {
            let at = obstacle.motion_at(step)?.pose.position;
            Some((at - motion.pose.position).norm())
        });
        near.fold(f64::MAX, f64::min)
    };
    let crop = Crop {
        around: around("ego:15m"),
        ..Crop::default()
    };
    let cropped = crop.apply(&scenario, Some(&ego)).unwrap().scenario;
    assert!(cropped.obstacles.len() < scenario.obstacles.len());
    for obstacle in &scenario.obstacles {
        // Who is near at the same time is near the way.
        let stays = cropped.obstacle(obstacle.id).is_some();
        assert!(stays || apart(obstacle) > 15.0, "{}", obstacle.id);
    }
    let id = scenario.obstacles[1].id;
    let crop = Crop {
        keep: Some(BTreeSet::from([id])),
        ..Crop::default()
    };
    let cropped = crop.apply(&scenario, Some(&ego)).unwrap().scenario;
    let ids: Vec<i64> = cropped.obstacles.iter().map(|o| o.id).collect();
    assert_eq!(ids, [id]);
}

#[test]
fn steps_begin_at_zero_where_that_is_asked() {
    let (scenario, ego) = named("RedLight");
    let crop = Crop {
        steps: Some(12..=40),
        from_zero: true,
        ..Crop::default()
    };
    let cropped = crop.apply(&scenario, Some(&ego)).unwrap();
    let kept = &cropped.scenario;
    assert_eq!(kept.steps(), 0..29);
    assert_eq!(cropped.ego.unwrap().track.steps(), 0..29);
    assert!(!kept.network.lights.is_empty());
    for (now, then) in kept.network.lights.iter().zip(&scenario.network.lights) {
        let alike = |step| now.color_at(step) == then.color_at(step + 12);
        assert!((0..29).all(alike) && now.offset >= 0);
    }
    let (before, after) = (&scenario.obstacles[0], &kept.obstacles[0]);
    assert_eq!(before.motion_at(30), after.motion_at(18));
    let goal = |of: &Scenario| of.planning_problems[0].goals[0].time.to;
    assert_eq!(goal(kept), goal(&scenario) - 12);
    assert!(
        cropped.said[0].ends_with("; step 12 became step 0"),
        "{:?}",
        cropped.said
    );
}

#[test]
fn what_is_not_there_is_refused() {
    let (scenario, ego) = named("CutIn");
    let refused = |crop: Crop| crop.apply(&scenario, Some(&ego)).unwrap_err();
    let unknown = Crop {
        drop: BTreeSet::from([9999]),
        ..Crop::default()
    };
    assert!(refused(unknown).to_string().contains("no obstacle 9999"));
    let far = Crop {
        around: around("90000,90000:5m"),
        ..Crop::default()
    };
    assert!(matches!(refused(far), CropError::NoRoad { .. }));
    let later = Crop {
        steps: Some(5000..=5001),
        ..Crop::default()
    };
    assert!(matches!(refused(later), CropError::EgoAway { .. }));
    let one = Crop {
        steps: Some(5..=5),
        ..Crop::default()
    };
    assert_eq!(refused(one), CropError::OneStep(5));
    let alone = Crop {
        around: around("ego:5m"),
        ..Crop::default()
    };
    assert_eq!(alone.apply(&scenario, None).unwrap_err(), CropError::NoEgo);
    let nobody = Crop {
        drop: scenario.obstacles.iter().map(|o| o.id).collect(),
        ..Crop::default()
    };
    assert_eq!(
        nobody.apply(&scenario, None).unwrap_err(),
        CropError::Nothing
    );
}

#[test]
fn a_problem_without_an_ego_does_not_begin_late() {
    let (scenario, _) = named("CutIn");
    let crop = Crop {
        steps: Some(20..=45),
        ..Crop::default()
    };
    let cropped = crop.apply(&scenario, None).unwrap();
    assert!(cropped.scenario.planning_problems.is_empty());
    assert!(
        cropped.said[1].contains("no ego tells"),
        "{:?}",
        cropped.said
    );
}

#[test]
fn areas_are_read_as_they_are_written() {
    for text in ["ego:60m", "12.5,-3:7.5m"] {
        let read: Around = text.parse().unwrap();
        assert_eq!(read.to_string(), text);
    }
    assert_eq!("ego:60".parse::<Around>().unwrap().centre, Centre::Ego);
    for wrong in [
        "", "ego", "ego:", "ego:0m", "ego:-1", "7:60m", "1,x:3m", "ego:NaN",
    ] {
        assert!(wrong.parse::<Around>().is_err(), "{wrong}");
    }
}

#[test]
fn a_part_differs_in_what_was_left_out_and_in_nothing_else() {
    let (scenario, ego) = named("CutIn");
    let same = Differences::between((&scenario, Some(&ego)), (&scenario, Some(&ego)));
    assert!(same.is_empty());
    let gone = scenario.obstacles[0].id;
    let crop = Crop {
        drop: BTreeSet::from([gone]),
        ..Crop::default()
    };
    let cropped = crop.apply(&scenario, Some(&ego)).unwrap();
    let found = Differences::between((&scenario, Some(&ego)), (&cropped.scenario, Some(&ego)));
    let [obstacles] = found.elements.as_slice() else {
        panic!("{found:?}");
    };
    assert_eq!(
        (obstacles.kind, &obstacles.only_in_a[..]),
        ("obstacle", &[gone][..])
    );
    assert!(obstacles.changed.is_empty() && obstacles.only_in_b.is_empty());
}
