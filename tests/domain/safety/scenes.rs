//! Rear-ends, cut-ins, crossings, and what only looks like them.

use std::f64::consts::{FRAC_PI_2, PI};

use nearmiss::geometry::Point;
use nearmiss::judge::{Judgement, judge};
use nearmiss::scenario::prediction::Model;
use nearmiss::scenario::{LaneletNetwork, Scene, Window};
use nearmiss::verdict::Task;

use crate::safety::built::{WIDTH, arc, lanelet, network};
use crate::safety::stage::*;

/// The present of all these scenes: the tenth step, 0.9 s after their beginning.
pub const NOW: i64 = 9;

pub fn safety(scene: &Scene) -> Judgement {
    judge(scene, Task::Safety, &Window::ending_at(scene, NOW, 10))
}

/// Two lanes to the east, at y = 0 and on its left, and an oncoming one on the left of both.
fn street() -> LaneletNetwork {
    let lanelets = vec![
        lanelet(11, &[(-100., 0.), (0., 0.)]),
        lanelet(21, &[(0., 0.), (200., 0.)]),
        lanelet(12, &[(-100., WIDTH), (200., WIDTH)]),
        lanelet(31, &[(200., 2. * WIDTH), (-100., 2. * WIDTH)]),
    ];
    network(
        lanelets,
        &[(11, 21)],
        &[(11, 12, true), (21, 12, true), (12, 31, false)],
    )
}

fn no_road() -> LaneletNetwork {
    LaneletNetwork::new(vec![], vec![], vec![], vec![])
}

/// A lane to the east that forks at x = 0: straight on, and to the right; a lane from the south crosses at x = 30.
fn crossing() -> LaneletNetwork {
    let mut right = arc(0.0, -15.0, 15.0, FRAC_PI_2, 0.0);
    right.push((15.0, -60.0));
    let lanelets = vec![
        lanelet(1, &[(-100., 0.), (0., 0.)]),
        lanelet(2, &[(0., 0.), (100., 0.)]),
        lanelet(3, &right),
        lanelet(4, &[(30., -100.), (30., 100.)]),
    ];
    network(lanelets, &[(1, 2), (1, 3)], &[])
}

/// A bend to the left of 25 m radius that begins at x = 0.
fn bend() -> LaneletNetwork {
    let lanelets = vec![
        lanelet(1, &[(-100., 0.), (0., 0.)]),
        lanelet(2, &arc(0.0, 25.0, 25.0, -FRAC_PI_2, FRAC_PI_2)),
    ];
    network(lanelets, &[(1, 2)], &[])
}

fn stage(network: LaneletNetwork, ego: Motion, actors: Vec<Actor>) -> Stage {
    Stage {
        network,
        ego,
        actors,
    }
}

/// Distances are those at the present: everything is told in seconds from then.
const T: f64 = 0.9;

/// Every scene, with whether it is critical and who is to be named.
pub fn all() -> Vec<(&'static str, Stage, Option<i64>)> {
    let at = |speed: Motion| speed;
    let east15 = at(|t| (15.0 * (t - T), 0.0, 0.0));
    let east10 = at(|t| (10.0 * (t - T), 0.0, 0.0));
    let standing = at(|_| (0.0, 0.0, 0.0));
    vec![
        (
            "a standing car 1.4 s ahead",
            stage(street(), east15, vec![car(7, |_| (25.0, 0.0, 0.0))]),
            Some(7),
        ),
        (
            "a parked car in the lane",
            stage(street(), east15, vec![parked(7, |_| (25.0, 0.4, 0.0))]),
            Some(7),
        ),
        (
            "following at the same speed",
            stage(
                street(),
                east15,
                vec![car(7, |t| (18.0 + 15.0 * (t - T), 0.0, 0.0))],
            ),
            None,
        ),
        (
            "the car ahead brakes hard",
            stage(
                street(),
                east15,
                vec![car(7, |t| {
                    let x = 11.0 + 15.0 * (t - T) - 3.0 * t * t + 3.0 * T * T;
                    (x, 0.0, 0.0)
                })],
            ),
            Some(7),
        ),
        (
            "a faster car from behind",
            stage(
                street(),
                at(|t| (2.0 * (t - T), 0.0, 0.0)),
                vec![car(7, |t| (-12.0 + 9.0 * (t - T), 0.0, 0.0))],
            ),
            Some(7),
        ),
        (
            "a cut-in",
            stage(
                street(),
                east15,
                vec![car(7, |t| {
                    let (vx, vy): (f64, f64) = (8.0, -1.6);
                    let s = t - T;
                    (11.0 + vx * s, 2.6 + vy * s, vy.atan2(vx))
                })],
            ),
            Some(7),
        ),
        (
            "a slow car in the next lane",
            stage(
                street(),
                east15,
                vec![car(7, |t| (11.0 + 8.0 * (t - T), WIDTH, 0.0))],
            ),
            None,
        ),
        (
            "crossing traffic that arrives at once",
            stage(
                crossing(),
                at(|t| (10.0 + 12.0 * (t - T), 0.0, 0.0)),
                vec![car(7, |t| (30.0, -20.0 + 12.0 * (t - T), FRAC_PI_2))],
            ),
            Some(7),
        ),
        (
            "crossing traffic that is far away",
            stage(
                crossing(),
                at(|t| (10.0 + 12.0 * (t - T), 0.0, 0.0)),
                vec![car(7, |t| (30.0, -70.0 + 12.0 * (t - T), FRAC_PI_2))],
            ),
            None,
        ),
        (
            "oncoming traffic in its lane",
            stage(
                street(),
                at(|t| (14.0 * (t - T), WIDTH, 0.0)),
                vec![car(7, |t| (32.0 - 14.0 * (t - T), 2.0 * WIDTH, PI))],
            ),
            None,
        ),
        (
            "oncoming traffic without a map",
            stage(
                no_road(),
                at(|t| (14.0 * (t - T), 0.0, 0.0)),
                vec![car(7, |t| (32.0 - 14.0 * (t - T), WIDTH, PI))],
            ),
            None,
        ),
        (
            "oncoming traffic in the ego's lane",
            stage(
                street(),
                east15,
                vec![car(7, |t| (40.0 - 10.0 * (t - T), 0.3, PI))],
            ),
            Some(7),
        ),
        (
            "cars parked beside the lane",
            stage(
                street(),
                east15,
                vec![
                    parked(7, |_| (10.0, -2.7, 0.0)),
                    parked(8, |_| (16.0, -2.7, 0.0)),
                    parked(9, |_| (22.0, -2.7, 0.0)),
                ],
            ),
            None,
        ),
        (
            "a car parked straight ahead where the lane bends away",
            stage(
                bend(),
                at(|t| (-5.0 + 11.0 * (t - T), 0.0, 0.0)),
                vec![parked(7, |_| (15.0, 0.0, 0.0))],
            ),
            None,
        ),
        (
            "a pedestrian walks into the lane",
            stage(
                street(),
                east10,
                vec![pedestrian(7, |t| (14.0, -2.5 + 1.5 * (t - T), FRAC_PI_2))],
            ),
            Some(7),
        ),
        (
            "a pedestrian walks beside the lane",
            stage(
                street(),
                east10,
                vec![pedestrian(7, |t| (14.0 + 1.5 * (t - T), -3.0, 0.0))],
            ),
            None,
        ),
        (
            "standing, and a car does not stop",
            stage(
                street(),
                standing,
                vec![car(7, |t| (-14.0 + 9.0 * (t - T), 0.0, 0.0))],
            ),
            Some(7),
        ),
        (
            "standing, and passed by",
            stage(
                street(),
                standing,
                vec![car(7, |t| (-14.0 + 12.0 * (t - T), WIDTH, 0.0))],
            ),
            None,
        ),
        ("alone", stage(street(), east15, vec![]), None),
    ]
}

#[test]
fn what_is_critical_and_what_only_looks_like_it() {
    let mut wrong = Vec::new();
    for (name, stage, expected) in all() {
        let judgement = safety(&stage.at(HERE));
        let said = &judgement.verdict;
        let critical = said.dangerous.then(|| said.obstacles[0].id);
        let most = judgement.prospects.first().map(|p| p.probability);
        println!("{name}: {most:?}");
        if critical != expected {
            wrong.push(format!("{name}\n{}", judgement.reasoning));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n\n"));
}

#[test]
fn the_reasoning_cites_horizon_threshold_steps_and_numbers() {
    let scenes = all();
    let (_, stage, _) = &scenes[0];
    let judgement = safety(&stage.at(HERE));
    for words in [
        "step 0 (0.0 s) to step 9 (0.9 s)",
        "at least 0.30 within 2.0 s",
        "car 7: contact within 2.0 s with probability 1.00, in 1.39 s",
        "ego along 11 21, it along 21",
        "relative velocity -15.00 m/s along",
    ] {
        assert!(
            judgement.reasoning.contains(words),
            "{words}: {}",
            judgement.reasoning
        );
    }
    assert_eq!(judgement.decisive_step, Some(NOW));
    let prospect = &judgement.prospects[0];
    assert!(prospect.id == 7 && prospect.probability > 0.99);
    // 20.5 m at 15 m/s.
    assert!(
        prospect
            .time
            .is_some_and(|t| (t - 20.5 / 15.0).abs() < 0.05)
    );
    let (_, alone, _) = scenes.last().unwrap();
    let alone = safety(&alone.at(HERE)).verdict;
    assert!(
        alone.obstacles.is_empty() && alone.justification.contains("there is no other road user")
    );
}

#[test]
fn nothing_depends_on_where_the_scene_lies() {
    let stands = [
        (false, 1.0, (0.0, 0.0)),
        (false, -2.4, (310.0, -90.0)),
        (true, 0.0, (0.0, 0.0)),
        (true, 2.9, (-45_000.0, 12_000.0)),
    ];
    for (name, stage, _) in all() {
        let here = safety(&stage.at(HERE));
        for (mirrored, turn, shift) in stands {
            let stand = Stand {
                mirrored,
                turn,
                shift,
            };
            let there = safety(&stage.at(stand));
            assert_eq!(here.verdict.dangerous, there.verdict.dangerous, "{name}");
            assert_eq!(here.prospects.len(), there.prospects.len(), "{name}");
            for (a, b) in here.prospects.iter().zip(&there.prospects) {
                let near = |a: f64, b: f64| (a - b).abs() < 1e-5;
                assert!(near(a.probability, b.probability), "{name}: {a:?} {b:?}");
                let times = [a.time, b.time].map(|t| t.unwrap_or(-1.0));
                assert!(near(times[0], times[1]), "{name}: {a:?} {b:?}");
            }
        }
    }
}

#[test]
fn the_same_scene_has_the_same_judgement() {
    for (name, stage, _) in all() {
        assert_eq!(safety(&stage.at(HERE)), safety(&stage.at(HERE)), "{name}");
    }
}

#[test]
fn a_fork_is_followed_both_ways() {
    use nearmiss::scenario::prediction::{ObservedHistory, PredictedPath, Predictor};
    let ego: Motion = |t| (-10.0 + 10.0 * (t - T), 0.0, 0.0);
    let scene = stage(crossing(), ego, vec![]).at(HERE);
    let past = ObservedHistory::from_window(&scene, &Window::ending_at(&scene, NOW, 10));
    let mut predictor = Predictor::new(&past, Model::AlongLanes);
    let prediction = predictor.predict(past.ego().unwrap(), 2.0);
    let weight = |way: &[i64]| -> f64 {
        let of = prediction
            .courses
            .iter()
            .filter(|c| c.way == PredictedPath::Lanes(way.to_vec()));
        of.map(|c| c.weight).sum()
    };
    assert!((weight(&[1, 2]) - 0.375).abs() < 1e-9 && (weight(&[1, 3]) - 0.375).abs() < 1e-9);
    let all: f64 = prediction.courses.iter().map(|c| c.weight).sum();
    assert!((all - 1.0).abs() < 1e-9);
    // Two seconds at 10 m/s end 10 m into the turn.
    let turned = prediction.trajectories(0.1, 20);
    let right = turned
        .iter()
        .filter(|t| prediction.courses[t.course].way == PredictedPath::Lanes(vec![1, 3]));
    let ends: Vec<Point> = right.map(|t| t.poses[20].position).collect();
    assert!(
        ends.iter().all(|p| p.y < -1.0) && ends.len() == 5,
        "{ends:?}"
    );
}
