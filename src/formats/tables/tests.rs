//! What is written is read back the same.

#![allow(clippy::unwrap_used)]

use std::path::{Path, PathBuf};
use std::sync::Arc;

use nearmiss_base::geometry::angle_between;
use nearmiss_scene::scenario::{EgoSource, Scene, Track};

use super::*;
use crate::Entry;

/// Bundled scenarios with their egos.
fn scenes() -> impl Iterator<Item = (String, Scene)> {
    crate::bundled().into_iter().map(|entry| {
        let scenario = entry.read().unwrap();
        let ego = entry.recorded_ego(&scenario).unwrap().unwrap();
        (entry.name.clone(), Scene::new(scenario, ego))
    })
}

/// Writes a scene's tables as a recording `a` of a folder, and gives the path of the last file.
fn write(folder: &Path, scene: &Scene, shape: TableShape, name: &str) -> (PathBuf, Vec<String>) {
    let written = write_tables(shape, &scene.scenario, Some(&scene.ego)).unwrap();
    let mut path = PathBuf::new();
    for (end, bytes) in written.files {
        path = folder.join(name.replace('*', end));
        std::fs::write(&path, bytes).unwrap();
    }
    (path, written.notes)
}

/// How much headings may be off, radians.
const EXACT: f64 = 1e-9;

fn compare(before: &Track, after: &Track, shift: i64, headings: f64, name: &str) {
    let steps = before.steps();
    assert_eq!(
        after.steps(),
        steps.start - shift..steps.end - shift,
        "{name}"
    );
    for (step, motion) in before.iter() {
        let found = after.at(step - shift).unwrap();
        let off = (found.pose.position - motion.pose.position).norm();
        assert!(off < 1e-6, "{name}, step {step}: {off} m");
        let turned = angle_between(found.pose.heading, motion.pose.heading).abs();
        assert!(turned <= headings, "{name}, step {step}: {turned} rad");
        let faster = (found.velocity - motion.velocity).abs();
        assert!(faster < 1e-6, "{name}, step {step}: {faster} m/s");
    }
}

/// The first step with traffic.
fn start(scene: &Scene) -> i64 {
    let all = scene.scenario.obstacles.iter();
    let moving = all.filter(|o| o.role == nearmiss_scene::scenario::ObstacleRole::Dynamic);
    let starts = moving.map(|o| o.track().steps().start);
    starts.chain([scene.ego.track.steps().start]).min().unwrap()
}

/// Compares everyone with what a file has; that is told to have the same ego.
fn compare_all(scene: &Scene, opened: &Scenario, headings: f64, name: &str) {
    assert!((opened.dt() - scene.scenario.dt()).abs() < 1e-9, "{name}");
    let shift = start(scene);
    for obstacle in &scene.scenario.obstacles {
        let found = opened.obstacle(obstacle.id).unwrap();
        let size =
            |o: &nearmiss_scene::scenario::Obstacle| o.any_footprint().unwrap().shape().size();
        let (a, b) = (size(obstacle), size(found));
        assert!((a.0 - b.0).hypot(a.1 - b.1) < 1e-6, "{name}: {a:?} {b:?}");
        if obstacle.role == nearmiss_scene::scenario::ObstacleRole::Dynamic {
            let name = format!("{name}, {}", obstacle.id);
            compare(obstacle.track(), found.track(), shift, headings, &name);
        }
    }
    let ego = opened.recorded_ego.as_ref().unwrap().ego().unwrap();
    let sizes = [&scene.ego, &ego].map(|ego| ego.footprint.shape().size());
    assert!((sizes[0].0 - sizes[1].0).abs() < 1e-6, "{sizes:?}");
    compare(
        &scene.ego.track,
        &ego.track,
        shift,
        headings,
        &format!("{name}, ego"),
    );
}

#[test]
fn our_own_tables_come_back_the_same_with_their_ego() {
    let folder = tempfile::tempdir().unwrap();
    for (name, scene) in scenes() {
        for (format, file) in [(Format::Csv, "a.csv"), (Format::Parquet, "a.parquet")] {
            let shape = TableShape::Tracks(format);
            let (path, notes) = write(folder.path(), &scene, shape, file);
            let opened = Entry::of_file(&path).read().unwrap();
            compare_all(&scene, &opened, EXACT, &name);
            for obstacle in &scene.scenario.obstacles {
                assert_eq!(
                    opened.obstacle(obstacle.id).unwrap().kind,
                    obstacle.kind,
                    "{name}"
                );
            }
            assert!(
                notes
                    .iter()
                    .any(|note| note.contains("the road is left out"))
            );
            let said: Vec<String> = opened.diagnostics.iter().map(ToString::to_string).collect();
            assert!(
                !said.iter().any(|said| said.contains("so they agree")),
                "{said:?}"
            );
        }
        let text = std::fs::read_to_string(folder.path().join("a.csv")).unwrap();
        assert!(
            text.starts_with("time,id,x,y,heading,speed,acceleration,length,width,class,ego\n")
        );
    }
}

#[test]
fn tables_of_interaction_come_back_the_same_and_say_who_the_ego_is() {
    let folder = tempfile::tempdir().unwrap();
    for (name, scene) in scenes() {
        let (path, notes) = write(folder.path(), &scene, TableShape::Interaction, "a.csv");
        let ego = notes.iter().find(|note| note.contains("the ego")).unwrap();
        let id = ego
            .split("#track=")
            .nth(1)
            .unwrap()
            .split('`')
            .next()
            .unwrap();
        let whole = Entry::of_file(&path).read().unwrap();
        assert_eq!(whole.header.other_format, Some("INTERACTION Dataset"));
        assert_eq!(whole.obstacles.len(), scene.scenario.obstacles.len() + 1);
        let part = PathBuf::from(format!("{}#track={id}", path.display()));
        let opened = Entry::of_file(&part).read().unwrap();
        // The window is as long as the ego is there.
        if scene.ego.track.steps().start == start(&scene) {
            let ego = opened.recorded_ego.as_ref().unwrap().ego().unwrap();
            compare(&scene.ego.track, &ego.track, start(&scene), EXACT, &name);
        }
        for obstacle in &scene.scenario.obstacles {
            if obstacle.role == nearmiss_scene::scenario::ObstacleRole::Dynamic {
                let found = whole.obstacle(obstacle.id).unwrap();
                compare(obstacle.track(), found.track(), start(&scene), EXACT, &name);
            }
        }
    }
}

/// A straight road of two lanes each way that leads `axis` radians off the x-axis, and who drives on it.
fn highway(axis: f64) -> Scene {
    let at = |along: f64, across: f64| {
        let (sin, cos) = axis.sin_cos();
        let (x, y) = (along * cos - across * sin, along * sin + across * cos);
        format!("<x>{x}</x><y>{y}</y>")
    };
    let line = |across: f64, is_back: bool| {
        let ends = if is_back {
            [300.0, -50.0]
        } else {
            [-50.0, 300.0]
        };
        ends.map(|along| format!("<point>{}</point>", at(along, across)))
            .concat()
    };
    let lane = |id: i64, left: f64, right: f64, is_back: bool| {
        format!(
            "<lanelet id='{id}'><leftBound>{}</leftBound><rightBound>{}</rightBound></lanelet>",
            line(left, is_back),
            line(right, is_back)
        )
    };
    let drives = |id: i64, kind: &str, size: [f64; 2], across: f64, from: f64, speed: f64| {
        let heading = axis
            + if speed < 0.0 {
                std::f64::consts::PI
            } else {
                0.0
            };
        let state = |name: &str, step: i64| {
            let place = at(from + speed * 0.04 * step as f64, across);
            format!(
                "<{name}><position><point>{place}</point></position><orientation><exact>{heading}</exact></orientation>\
                 <time><exact>{step}</exact></time><velocity><exact>{}</exact></velocity></{name}>",
                speed.abs()
            )
        };
        let later: String = (1..=50).map(|step| state("state", step)).collect();
        format!(
            "<dynamicObstacle id='{id}'><type>{kind}</type><shape><rectangle><length>{}</length><width>{}</width>\
             </rectangle></shape>{}<trajectory>{later}</trajectory></dynamicObstacle>",
            size[0],
            size[1],
            state("initialState", 0)
        )
    };
    let parts = [
        lane(1, 0.0, -3.75, false),
        lane(2, -3.75, -7.5, false),
        lane(3, 0.0, 3.75, true),
        drives(11, "car", [4.6, 1.9], -1.875, 0.0, 33.0),
        drives(12, "truck", [12.5, 2.5], -5.625, 20.0, 22.0),
        drives(13, "car", [4.4, 1.8], 1.875, 200.0, -30.0),
    ];
    let text = format!(
        "<commonRoad commonRoadVersion='2020a' benchmarkID='A' timeStepSize='0.04'>{}</commonRoad>",
        parts.concat()
    );
    let scenario = crate::commonroad::read(text.as_bytes(), "a.xml").unwrap();
    Scene::with_obstacle_as_ego(Arc::new(scenario), 12).unwrap()
}

#[test]
fn straight_roads_come_back_from_highd_turned_along_the_axis() {
    let folder = tempfile::tempdir().unwrap();
    let straight = highway(0.0);
    for axis in [0.0, 0.6, -1.2] {
        let scene = highway(axis);
        let (path, notes) = write(folder.path(), &scene, TableShape::HighD, "01*");
        assert!(path.ends_with("01_tracks.csv"));
        assert_eq!(
            notes.iter().any(|n| n.contains("turned by")),
            axis != 0.0,
            "{notes:?}"
        );
        assert!(notes.iter().any(|n| n.contains("#track=12")), "{notes:?}");
        let part = PathBuf::from(format!("{}#track=12", path.display()));
        let opened = Entry::of_file(&part).read().unwrap();
        assert_eq!(opened.header.other_format, Some("highD (levelXdata)"));
        let ego = opened.recorded_ego.as_ref().unwrap().ego().unwrap();
        compare(&straight.ego.track, &ego.track, 0, EXACT, "ego");
        assert_eq!(ego.footprint.shape().size(), (12.5, 2.5));
        for id in [11, 13] {
            let before = straight.scenario.obstacle(id).unwrap();
            compare(
                before.track(),
                opened.obstacle(id).unwrap().track(),
                0,
                EXACT,
                "other",
            );
        }
        // Two lanes along the axis, one against it.
        assert_eq!(opened.network.lanelets.len(), 3);
        let text = std::fs::read_to_string(&path).unwrap();
        let lanes = |id: &str| {
            let own = text.lines().map(|l| l.split(',').collect::<Vec<_>>());
            let own = own
                .filter(|fields| fields[1] == id)
                .map(|fields| fields[10].to_string());
            own.collect::<std::collections::BTreeSet<_>>()
                .into_iter()
                .collect::<Vec<_>>()
        };
        assert_eq!(
            [lanes("13"), lanes("11"), lanes("12")],
            [["2"], ["4"], ["5"]]
        );
    }
}

#[test]
fn highd_refuses_who_drives_across_the_road() {
    for (name, scene) in scenes().filter(|(name, _)| name.contains("RedLight")) {
        let refused = write_tables(TableShape::HighD, &scene.scenario, Some(&scene.ego));
        match refused {
            Err(TableError::Across { degrees, .. }) => {
                assert!((45.0..=90.0).contains(&degrees), "{name}: {degrees}");
            }
            other => panic!("{name}: {other:?}"),
        }
    }
}

#[test]
fn an_obstacle_that_is_the_ego_keeps_its_id_and_another_ego_gets_a_free_one() {
    let (_, scene) = scenes().next().unwrap();
    let ids = |scene: &Scene| {
        let written = write_tables(TableShape::Interaction, &scene.scenario, Some(&scene.ego));
        let text = String::from_utf8(written.unwrap().files.remove(0).1).unwrap();
        let ids = text
            .lines()
            .skip(1)
            .map(|l| l.split(',').next().unwrap().to_string());
        ids.collect::<std::collections::BTreeSet<_>>()
    };
    let obstacle = scene.scenario.possible_egos()[0];
    let taken = Scene::with_obstacle_as_ego(Arc::clone(&scene.scenario), obstacle).unwrap();
    assert!(matches!(taken.ego.source, EgoSource::Obstacle(id) if id == obstacle));
    assert!(ids(&taken).contains(&obstacle.to_string()));
    let mut same = scene.clone();
    same.ego.id = obstacle;
    assert_eq!(ids(&same).len(), ids(&scene).len());
}
