//! Roads that fork without end and crowds: the judge answers, soon.

use std::time::{Duration, Instant};

use crate::safety::built::{lanelet, network};
use crate::safety::scenes::safety;
use crate::safety::stage::{HERE, Motion, Stage, car};

#[test]
fn a_road_of_forks_within_forks_and_a_crowd_on_it() {
    // 60 lanelets of 2 cm on one spot, each followed by all the others.
    let ids = 1..=60;
    let short = |id: i64| {
        let x = id as f64 * 1e-4;
        lanelet(id, &[(x, 0.0), (x + 0.02, 0.0)])
    };
    let on: Vec<(i64, i64)> = ids
        .clone()
        .flat_map(|a| ids.clone().map(move |b| (a, b)))
        .collect();
    let ego: Motion = |t| (0.01 + 10.0 * (t - 0.9), 0.0, 0.0);
    let other: Motion = |t| (0.012 + 8.0 * (t - 0.9), 2.2, 0.0);
    let stage = Stage {
        network: network(ids.map(short).collect(), &on, &[]),
        ego,
        actors: (1..=60).map(|id| car(id, other)).collect(),
    };
    let scene = stage.at(HERE);
    let begun = Instant::now();
    let judgement = safety(&scene);
    // A debug build on a busy machine; without bounds it would be years.
    assert!(
        begun.elapsed() < Duration::from_secs(30),
        "{:?}",
        begun.elapsed()
    );
    println!("{:?}", begun.elapsed());
    assert!(!judgement.verdict.obstacles.is_empty());
}

#[test]
fn jumps_and_numbers_beyond_all_roads_are_survived() {
    let ego: Motion = |t| (if t > 0.55 { 1e300 } else { 0.0 }, 0.0, 0.0);
    let other: Motion = |t| (5.0 + 1e18 * t, -1e18 * t, 1e9);
    let stage = Stage {
        network: network(vec![lanelet(1, &[(-50.0, 0.0), (50.0, 0.0)])], &[], &[]),
        ego,
        actors: vec![car(7, other)],
    };
    let judgement = safety(&stage.at(HERE));
    let prospects = judgement.prospects.iter();
    assert!(prospects.clone().count() == 1);
    assert!({ prospects }.all(|p| (0.0..=1.0).contains(&p.probability)));
}
