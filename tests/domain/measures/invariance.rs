//! No measure depends on where, which way and when a scene is; in a mirror only signed lateral ones turn.

use std::f64::consts::{FRAC_PI_2, PI};

use nearmiss::formats::bundled;
use nearmiss::metrics::{Context, MEASURES, Mirrored, Reading, SCENE_MEASURES, Series};
use nearmiss::scenario::Scene;
use proptest::prelude::*;

use super::random;
use super::scenes::{none, opened, recorded, same, some, thorough};
use super::transform::Move;

const FAR: f64 = 100_000.0;

const MOVES: [Move; 7] = [
    Move {
        angle: 0.7,
        ..Move::NONE
    },
    Move {
        angle: FRAC_PI_2,
        ..Move::NONE
    },
    Move {
        angle: PI,
        steps: 1000,
        ..Move::NONE
    },
    Move {
        shift: (FAR, -FAR),
        ..Move::NONE
    },
    Move {
        mirror: true,
        ..Move::NONE
    },
    Move {
        steps: -37,
        ..Move::NONE
    },
    Move {
        mirror: true,
        angle: -2.3,
        shift: (-FAR, FAR / 3.0),
        steps: 12,
    },
];

/// What differs between a scene and itself moved.
fn differences(scene: &Scene, by: &Move) -> Vec<String> {
    let moved = by.scene(scene);
    let all = || MEASURES.iter().collect();
    let (before, after) = (
        Series::compute(scene, all()),
        Series::compute(&moved, all()),
    );
    let mut found = Vec::new();
    for m in MEASURES {
        let sign = if by.mirror && m.mirrored == Mirrored::Negated {
            -1.0
        } else {
            1.0
        };
        for &id in before.obstacles() {
            let rows = before.row(m.id, id).iter().zip(after.row(m.id, id));
            let differs = |(a, b): &(&Reading, &Reading)| !same(**a, **b, sign);
            if let Some(place) = rows.clone().position(|pair| differs(&pair)) {
                let count = rows.filter(differs).count();
                let (a, b) = (before.row(m.id, id)[place], after.row(m.id, id)[place]);
                found.push(format!(
                    "{} of {id} at {place}: {a:?} became {b:?} ({count} steps)",
                    m.id
                ));
            }
        }
    }
    let (here, there) = (Context::new(scene), Context::new(&moved));
    for m in SCENE_MEASURES {
        for step in scene.steps() {
            let (a, b) = (
                (m.compute)(&here, step),
                (m.compute)(&there, step + by.steps),
            );
            if !same(a, b, 1.0) {
                found.push(format!(
                    "{} of the scene at {step}: {a:?} became {b:?}",
                    m.id
                ));
                break;
            }
        }
    }
    found
}

fn check(name: &str, scene: &Scene, moves: &[Move]) -> Vec<String> {
    let of = |by: &Move| {
        let found = differences(scene, by).into_iter();
        found
            .map(|d| format!("{name} {by:?}: {d}"))
            .collect::<Vec<_>>()
    };
    moves.iter().flat_map(of).collect()
}

#[test]
fn bundled_scenes_can_be_moved() {
    let mut found = Vec::new();
    for (place, entry) in bundled().iter().enumerate() {
        found.extend(check(
            &entry.name,
            &opened(entry).unwrap(),
            &some(&MOVES, place, 2),
        ));
    }
    none(&found);
}

#[test]
fn recorded_scenes_can_be_moved() {
    let Some(scenes) = recorded(8) else { return };
    let mut found = Vec::new();
    for (place, (name, scene)) in scenes.enumerate() {
        found.extend(check(&name, &scene, &some(&MOVES, place, 1)));
    }
    none(&found);
}

/// What holds for moved scenes would hold for measures that never have a value.
#[test]
fn every_measure_has_values() {
    let scenes: Vec<Scene> = bundled().iter().filter_map(opened).collect();
    for m in MEASURES {
        let has = |scene: &Scene| {
            let series = Series::compute(scene, vec![m]);
            let values = series
                .obstacles()
                .iter()
                .flat_map(|&id| series.row(m.id, id));
            values.filter(|r| r.value().is_some()).count()
        };
        let values: usize = scenes.iter().map(has).sum();
        println!("{:16} {values}", m.id);
        assert!(values > 0, "{} has no value in any bundled scene", m.id);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(if thorough() { 1000 } else { 24 }))]

    #[test]
    fn random_scenes_can_be_moved(
        scene in random::scene(),
        mirror: bool,
        angle in -PI..PI,
        x in -FAR..FAR,
        y in -FAR..FAR,
        steps in -1000_i64..1000,
    ) {
        let by = Move { mirror, angle, shift: (x, y), steps };
        prop_assert_eq!(differences(&scene, &by), Vec::<String>::new());
    }
}
