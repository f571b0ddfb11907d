//! No measure depends on where, which way and when a scene is; in a mirror only signed lateral ones turn.

use std::f64::consts::{FRAC_PI_2, PI};
use std::path::{Path, PathBuf};

use nearmiss::metrics::{Context, MEASURES, Mirrored, Reading, SCENE_MEASURES, Series};
use nearmiss::scenario::{Entry, Scene, bundled, find};
use proptest::prelude::*;

use super::random;
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

fn same(a: Reading, b: Reading, sign: f64) -> bool {
    match (a, b) {
        (Reading::Value(a), Reading::Value(b)) => {
            // Very long times and distances are compared by their digits.
            (sign * a - b).abs() <= 1e-6 * a.abs().max(1.0)
        }
        (a, b) => a == b,
    }
}

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

fn opened(entry: &Entry) -> Option<Scene> {
    let scenario = entry.read().unwrap();
    let ego = entry.recorded_ego(&scenario).unwrap()?;
    Some(Scene::new(scenario, ego))
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

/// All moves of all scenes instead of a sample: set this to look closely (minutes without optimisation).
fn thorough() -> bool {
    std::env::var_os("NEARMISS_ALL_MOVES").is_some()
}

/// The moves for the scene at a place: each move is on one scene or another.
fn moves(place: usize, count: usize) -> Vec<Move> {
    let count = if thorough() { MOVES.len() } else { count };
    MOVES
        .iter()
        .copied()
        .cycle()
        .skip(place * count)
        .take(count)
        .collect()
}

fn none(found: &[String]) {
    let shown = &found[..found.len().min(40)];
    assert!(found.is_empty(), "{} differences: {shown:#?}", found.len());
}

#[test]
fn bundled_scenes_can_be_moved() {
    let mut found = Vec::new();
    for (place, entry) in bundled().iter().enumerate() {
        found.extend(check(
            &entry.name,
            &opened(entry).unwrap(),
            &moves(place, 2),
        ));
    }
    none(&found);
}

#[test]
fn recorded_scenes_can_be_moved() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let shared = std::env::var_os("NEARMISS_SHARED").map_or(root.join("../shared"), PathBuf::from);
    let published = shared.join("data/from-words-to-collisions");
    if !published.is_dir() {
        println!(
            "skipped: there are no recorded scenes at {}",
            published.display()
        );
        return;
    }
    let entries = find(&[published]).unwrap().entries;
    let scenes: Vec<_> = entries
        .iter()
        .filter_map(|e| Some((e, opened(e)?)))
        .collect();
    let every = if thorough() { 1 } else { 8 };
    let mut found = Vec::new();
    for (place, (entry, scene)) in scenes.iter().step_by(every).enumerate() {
        found.extend(check(&entry.name, scene, &moves(place, 1)));
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
