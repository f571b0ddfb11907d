//! A small data set that is written here by the published description of its tables.

#![allow(clippy::unwrap_used)]

use std::path::Path;

use serde_json::{Value, json};

use super::*;
use crate::Entry;

/// Seconds of key frames: as uneven as they are.
fn time(frame: u32) -> f64 {
    f64::from(frame) * 0.5 + f64::from(frame % 3) * 0.02
}

fn token(kind: u128, number: u32) -> String {
    format!("{:032x}", (kind << 100) + u128::from(number))
}

/// About the z-axis.
fn quaternion(heading: f64) -> Value {
    json!([(heading / 2.0).cos(), 0.0, 0.0, (heading / 2.0).sin()])
}

/// Two scenes of `frames` key frames: the vehicle that records drives along the diagonal, a bus comes towards it, and
/// a road user stands.
fn write(folder: &Path, frames: u32) {
    let [mut samples, mut data, mut poses, mut boxes] = [(); 4].map(|()| Vec::new());
    let diagonal = std::f64::consts::FRAC_PI_4;
    let start: i64 = 1_532_402_927_000_000;
    for scene in 0..2 {
        for frame in 0..frames {
            let number = scene * 100 + frame;
            let stamp = start + i64::from(scene) * 60_000_000 + (time(frame) * 1e6) as i64;
            samples.push(
                json!({"token": token(1, number), "timestamp": stamp, "prev": "", "next": "",
                "scene_token": token(2, scene)}),
            );
            // The camera is farther from the key frame than the lidar, and sweeps are none.
            for (sensor, (late, is_key)) in (0..).zip([(40_000, true), (300, true), (9, false)]) {
                let pose = number * 10 + sensor;
                data.push(json!({"token": token(3, pose), "sample_token": token(1, number), "is_key_frame": is_key,
                    "ego_pose_token": token(4, pose), "timestamp": stamp + late, "filename": "sweeps/x"}));
                let along = 10.0 * time(frame) + if sensor == 1 { 0.0 } else { 50.0 };
                let (x, y) = (
                    600.0 + along * diagonal.cos(),
                    1600.0 + along * diagonal.sin(),
                );
                poses.push(json!({"token": token(4, pose), "timestamp": stamp + late, "translation": [x, y, 0.0],
                    "rotation": quaternion(diagonal)}));
            }
            let mut annotate = |object: u32, place: [f64; 3], size: [f64; 3], heading: f64| {
                boxes.push(json!({"token": token(5, number * 10 + object), "sample_token": token(1, number),
                    "instance_token": token(6, scene * 10 + object), "visibility_token": "4", "attribute_tokens": [],
                    "translation": place, "size": size, "rotation": quaternion(heading), "num_lidar_pts": 5}));
            };
            let x = 700.0 - 8.0 * time(frame);
            annotate(0, [x, 1650.0, 1.5], [2.9, 11.2, 3.4], std::f64::consts::PI);
            annotate(1, [640.0, 1660.0, 0.9], [0.6, 0.7, 1.8], 1.0);
        }
    }
    let scenes: Vec<Value> = (0..2)
        .map(|i| json!({"token": token(2, i), "log_token": token(7, 0), "nbr_samples": frames, "name": format!("scene-{:04}", 61 + i),
            "first_sample_token": token(1, i * 100), "last_sample_token": "", "description": "x"}))
        .collect();
    let instances: Vec<Value> = [(0, 0), (1, 1), (10, 0), (11, 1)]
        .map(|(object, kind)| json!({"token": token(6, object), "category_token": token(8, kind), "nbr_annotations": frames}))
        .to_vec();
    let categories = vec![
        json!({"token": token(8, 0), "name": "vehicle.bus.rigid", "description": ""}),
        json!({"token": token(8, 1), "name": "human.pedestrian.adult", "description": ""}),
    ];
    let tables = [
        ("scene.json", scenes),
        ("sample.json", samples),
        ("category.json", categories),
        ("instance.json", instances),
        ("sample_annotation.json", boxes),
        ("sample_data.json", data),
        ("ego_pose.json", poses),
    ];
    for (name, rows) in tables {
        std::fs::write(
            folder.join(name),
            serde_json::to_string_pretty(&rows).unwrap(),
        )
        .unwrap();
    }
}

fn opened(folder: &Path, part: &str) -> Result<Arc<Scenario>, ReadError> {
    let file = folder.join("scene.json").display().to_string();
    Entry::of_file(Path::new(&(file + part))).read()
}

#[test]
fn scenes_have_their_objects_and_the_vehicle_that_recorded() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), 12);
    let found = crate::find(&[folder.path().to_path_buf()]).unwrap().entries;
    let names: Vec<&str> = found.iter().map(|entry| entry.name.as_str()).collect();
    assert_eq!(names, ["scene-0061", "scene-0062"]);
    let scenario = found[1].read().unwrap();
    assert_eq!(scenario.header.other_format, Some("nuScenes"));
    assert!((scenario.dt() - 0.5).abs() < 1e-9);
    let ego = scenario.recorded_ego.as_ref().unwrap().ego().unwrap();
    assert_eq!(ego.footprint.shape().size(), EGO);
    for (step, motion) in ego.track.iter() {
        let along = 10.0 * time(step as u32) + AHEAD;
        let turned = std::f64::consts::FRAC_PI_4;
        let place = Point::new(600.0 + along * turned.cos(), 1600.0 + along * turned.sin());
        assert!((motion.pose.position - place).norm() < 1e-6, "step {step}");
        assert!((motion.pose.heading - turned).abs() < 1e-9);
        assert!(
            (motion.velocity - 10.0).abs() < 1e-3,
            "step {step}: {}",
            motion.velocity
        );
    }
    let of = |kind| scenario.obstacles.iter().find(|o| o.kind == kind).unwrap();
    let bus = of(ObstacleType::Bus);
    let size = bus.footprint.as_ref().unwrap().shape().size();
    assert!((size.0 - 11.2).hypot(size.1 - 2.9) < 1e-5, "{size:?}");
    let motion = bus.track().at(5).unwrap();
    assert!((motion.pose.position.x - (700.0 - 8.0 * time(5))).abs() < 1e-9);
    assert!((motion.velocity - 8.0).abs() < 1e-3 && motion.pose.heading.abs() > 3.1);
    assert!(
        of(ObstacleType::Pedestrian)
            .track()
            .iter()
            .all(|(_, m)| m.velocity == 0.0)
    );
    let said: Vec<String> = scenario
        .diagnostics
        .iter()
        .map(ToString::to_string)
        .collect();
    for words in [
        "0.040 s off steps",
        "Renault Zoe",
        "no map",
        "tracks are numbered",
    ] {
        assert!(said.iter().any(|d| d.contains(words)), "{words}: {said:?}");
    }
}

#[test]
fn damage_and_what_is_missing_have_file_and_line() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), 4);
    let error = |part: &str| opened(folder.path(), part).unwrap_err().to_string();
    assert!(error("").contains("scene.json#scene-0061"), "{}", error(""));
    assert!(
        error("#scene-0099").contains("scene-0099"),
        "{}",
        error("#scene-0099")
    );
    let boxes = folder.path().join("sample_annotation.json");
    let whole = std::fs::read_to_string(&boxes).unwrap();
    std::fs::write(&boxes, whole.replacen(&token(6, 0), "bad", 1)).unwrap();
    let said = error("#scene-0061");
    assert!(
        said.contains("sample_annotation.json:") && said.contains("`bad` is no token"),
        "{said}"
    );
    std::fs::write(&boxes, &whole[..whole.len() / 2]).unwrap();
    assert!(
        error("#scene-0061").contains("EOF"),
        "{}",
        error("#scene-0061")
    );
    std::fs::remove_file(&boxes).unwrap();
    assert!(error("#scene-0061").contains("not there; a scene of nuScenes needs"));
}
