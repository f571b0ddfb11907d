//! Scenes turned, mirrored, moved and renumbered: no measure and no verdict of the built-in judge changes, and the
//! way back leads to the same scene.
#![allow(clippy::unwrap_used, clippy::expect_used)]

mod alike;
use crate::measures::random;
mod rich;
use crate::measures::scenes;
mod verdicts;

use nearmiss::formats::bundled;
use nearmiss::metrics::{MEASURES, Mirrored, Series};
use nearmiss::scenario::{Scene, Transform};
use proptest::prelude::*;
use scenes::{none, opened, recorded, same, some, thorough};

fn changes() -> [Transform; 6] {
    [
        Transform::Rotate(0.7),
        Transform::Mirror,
        Transform::Move(1000.0, -500.0),
        Transform::Renumber(1),
        Transform::Rotate(std::f64::consts::PI),
        Transform::Renumber(77),
    ]
}

/// What a change of the scene changes of the measures.
fn measures(scene: &Scene, change: &Transform) -> Vec<String> {
    let changed = change.apply(scene);
    let all = || MEASURES.iter().collect();
    let before = Series::compute(scene, all());
    let after = Series::compute(&changed.scene, all());
    let mut found = Vec::new();
    for m in MEASURES {
        let turns = *change == Transform::Mirror && m.mirrored == Mirrored::Negated;
        let sign = if turns { -1.0 } else { 1.0 };
        for &id in after.obstacles() {
            let old = changed.original(id);
            let (a, b) = (before.row(m.id, old), after.row(m.id, id));
            assert_eq!(a.len(), b.len(), "{} of {old}", m.id);
            let place = a.iter().zip(b).position(|(a, b)| !same(*a, *b, sign));
            if let Some(place) = place {
                let (a, b) = (a[place], b[place]);
                found.push(format!("{} of {old} at {place}: {a:?} became {b:?}", m.id));
            }
        }
    }
    found
}

/// Everything that must not change and does.
fn differences(scene: &Scene, change: &Transform) -> Vec<String> {
    let mut found = measures(scene, change);
    found.extend(verdicts::differences(scene, change));
    found.extend(alike::on_the_way_back(scene, change));
    found.extend(alike::lanelets(scene, change));
    found
}

fn check(name: &str, scene: &Scene, changes: &[Transform]) -> Vec<String> {
    let of = |change: &Transform| {
        let found = differences(scene, change).into_iter().take(5);
        found
            .map(|d| format!("{name} {change}: {d}"))
            .collect::<Vec<_>>()
    };
    changes.iter().flat_map(of).collect()
}

#[test]
fn bundled_scenes_stay_what_they_are() {
    let mut found = Vec::new();
    for (place, entry) in bundled().iter().enumerate() {
        found.extend(check(
            &entry.name,
            &opened(entry).unwrap(),
            &some(&changes(), place, 3),
        ));
    }
    none(&found);
}

#[test]
fn recorded_scenes_stay_what_they_are() {
    let Some(scenes) = recorded(7) else { return };
    let (mut found, mut count) = (Vec::new(), 0);
    for (place, (name, scene)) in scenes.enumerate() {
        found.extend(check(&name, &scene, &some(&changes(), place, 1)));
        count += 1;
    }
    assert!(count > 5, "{count} scenes");
    none(&found);
}

fn change() -> impl Strategy<Value = Transform> {
    let angle = -std::f64::consts::PI..std::f64::consts::PI;
    let far = || -100_000.0..100_000.0;
    prop_oneof![
        angle.prop_map(Transform::Rotate),
        Just(Transform::Mirror),
        (far(), far()).prop_map(|(x, y)| Transform::Move(x, y)),
        any::<u64>().prop_map(Transform::Renumber),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(if thorough() { 1000 } else { 24 }))]

    #[test]
    fn random_scenes_stay_what_they_are(scene in random::scene(), change in change()) {
        prop_assert_eq!(differences(&scene, &change), Vec::<String>::new());
    }
}
