//! The scenarios that the paper's authors published: found, opened and judged as the geometry says.
//!
//! They are not part of this repository. The folder that holds `data/from-words-to-collisions` is `../shared`,
//! or what `NEARMISS_SHARED` names; without it these tests say so and end.
#![allow(clippy::unwrap_used, clippy::expect_used)]

use crate::support;

use std::collections::BTreeMap;
use std::sync::{Arc, OnceLock};

use nearmiss::formats::{Entry, find};
use nearmiss::judge::judge;
use nearmiss::scenario::{Scene, Window};
use nearmiss::verdict::{Task, Verdict};

use support::recorded::folder;

/// A published scenario with its recorded ego.
struct Published {
    entry: Entry,
    scene: Scene,
    /// Whether the authors call it a collision.
    collides: bool,
}

/// Annotations that are wrong, and who it is in truth: the ego overlaps another obstacle.
const WRONGLY_ANNOTATED: [(&str, i64); 2] =
    [("DEU_Bonn-38_4_T-1", 30233), ("ESP_Vigo-99_21_T-1", 3515)];

/// All published scenarios, read once; nothing, and a word about it, where they are not there.
fn published() -> Option<&'static [Published]> {
    static ALL: OnceLock<Vec<Published>> = OnceLock::new();
    let folder = folder()?;
    let read = || {
        let open = |entry: Entry| {
            let scenario = entry.read().unwrap_or_else(|error| panic!("{error}"));
            let ego = entry
                .recorded_ego(&scenario)
                .unwrap_or_else(|error| panic!("{error}"))
                .unwrap_or_else(|| panic!("{}: no ego", entry.name));
            let collides = entry.group == "collision_scenarios";
            let scene = Scene::new(Arc::clone(&scenario), ego);
            Published {
                entry,
                scene,
                collides,
            }
        };
        find(&[folder])
            .unwrap()
            .entries
            .into_iter()
            .map(open)
            .collect()
    };
    Some(ALL.get_or_init(read))
}

fn verdict(scene: &Scene, task: Task, window: Window) -> Verdict {
    judge(scene, task, &window).verdict
}

fn collision(scene: &Scene) -> Verdict {
    verdict(
        scene,
        Task::Collision,
        Window::ending_at(scene, i64::MAX, 10),
    )
}

/// The obstacle that collides, as annotated, by scenario.
fn annotations() -> BTreeMap<String, i64> {
    let path = folder()
        .unwrap()
        .join("Results/LLM/Scenario_Collision/ego/annotations.csv");
    let mut reader = csv::Reader::from_path(path).unwrap();
    let rows = reader.records().map(Result::unwrap);
    rows.map(|row| (row[0].to_string(), row[1].parse().unwrap()))
        .collect()
}

#[test]
fn sixty_scenarios_are_found_and_open() {
    let Some(all) = published() else { return };
    assert_eq!(all.len(), 60);
    assert_eq!(all.iter().filter(|p| p.collides).count(), 30);
    for Published { entry, scene, .. } in all {
        let scenario = &scene.scenario;
        assert_eq!(scenario.header.benchmark_id, entry.name);
        assert_eq!(scenario.dt(), 0.1, "{}", entry.name);
        assert!(!scenario.network.lanelets.is_empty(), "{}", entry.name);
        assert!(!scenario.obstacles.is_empty(), "{}", entry.name);
        assert!(scene.steps().count() > 10, "{}", entry.name);
    }
}

#[test]
fn the_bodies_collide_where_the_authors_say_so() {
    let Some(all) = published() else { return };
    let (mut hits, mut false_alarms) = (Vec::new(), Vec::new());
    for p in all {
        if collision(&p.scene).dangerous {
            if p.collides {
                &mut hits
            } else {
                &mut false_alarms
            }
            .push(p.entry.name.as_str());
        }
    }
    println!(
        "collisions: {} of 30; false alarms: {false_alarms:?}",
        hits.len()
    );
    assert!(hits.len() >= 29, "{hits:?}");
    assert!(false_alarms.is_empty(), "{false_alarms:?}");
}

#[test]
fn the_obstacle_named_first_is_the_annotated_one() {
    let Some(all) = published() else { return };
    let annotations = annotations();
    let mut others = Vec::new();
    for p in all.iter().filter(|p| p.collides) {
        let name = p.entry.name.as_str();
        let named = collision(&p.scene).obstacles.first().map(|o| o.id);
        let annotated = annotations.get(name).copied();
        if named != annotated {
            others.push(format!("{name}: {named:?}, annotated {annotated:?}"));
        }
        if let Some((_, truth)) = WRONGLY_ANNOTATED.iter().find(|(wrong, _)| *wrong == name) {
            assert_eq!(named, Some(*truth), "{name}");
        }
    }
    println!("not the annotated obstacle: {others:?}");
    assert!(others.len() <= 2, "{others:?}");
}

#[test]
fn danger_is_seen_at_the_windows_of_the_paper() {
    let Some(all) = published() else { return };
    let (mut hits, mut missed, mut alarms) = (0, Vec::new(), Vec::new());
    for p in all {
        let steps = p.scene.steps();
        // Ten steps that end two steps before the last one, or the first ten.
        let last = if p.collides {
            steps.end - 1 - 2
        } else {
            steps.start + 9
        };
        let window = Window::ending_at(&p.scene, last, 10);
        assert_eq!(window.steps().count(), 10);
        let dangerous = verdict(&p.scene, Task::Safety, window).dangerous;
        match (p.collides, dangerous) {
            (true, true) => hits += 1,
            (true, false) => missed.push(p.entry.name.as_str()),
            (false, true) => alarms.push(p.entry.name.as_str()),
            (false, false) => {}
        }
    }
    let precision = f64::from(hits) / (f64::from(hits) + alarms.len() as f64);
    let recall = f64::from(hits) / (f64::from(hits) + missed.len() as f64);
    let f1 = 2.0 * precision * recall / (precision + recall);
    println!(
        "safety: precision {precision:.3}, recall {recall:.3}, F1 {f1:.3}; missed {missed:?}, false alarms {alarms:?}"
    );
    assert!(
        f1 >= 0.95,
        "F1 {f1:.3}; missed {missed:?}, false alarms {alarms:?}"
    );
}

#[test]
fn the_heading_of_a_standing_ego_is_held() {
    let Some(all) = published() else { return };
    let mut standing = 0;
    for p in all {
        let motions: Vec<_> = p.scene.ego.track.iter().collect();
        for pair in motions.windows(2) {
            let ((_, before), (step, after)) = (pair[0], pair[1]);
            let moved = (after.pose.position - before.pose.position).norm();
            if moved < 0.005 {
                standing += 1;
                let turn =
                    (after.pose.heading - before.pose.heading).rem_euclid(std::f64::consts::TAU);
                let turn = turn.min(std::f64::consts::TAU - turn);
                assert!(
                    turn <= 0.1,
                    "{} step {step}: {turn:.2} rad at {:.1} mm",
                    p.entry.name,
                    moved * 1e3
                );
            }
        }
    }
    assert!(
        standing > 20,
        "only {standing} steps at standstill were seen"
    );
}
