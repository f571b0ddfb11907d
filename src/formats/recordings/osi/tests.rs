//! Recordings of OSI that are written here by its field numbers and the specification of MCAP.

#![allow(clippy::unwrap_used)]

use std::io::Write;
use std::path::{Path, PathBuf};

use nearmiss_scene::scenario::Severity;

use super::messages::{BaseMoving, Dimension, Identifier, Orientation, Timestamp, Vector};
use super::*;
use crate::Entry;

/// A car `7` that follows a truck `9`, seconds after 1970 where `start` is large.
fn moment(step: i64, start: i64) -> GroundTruth {
    let object = |id: u64, x: f64, size: (f64, f64), class: i32| MovingObject {
        id: Some(Identifier { value: Some(id) }),
        base: Some(BaseMoving {
            dimension: Some(Dimension {
                length: Some(size.0),
                width: Some(size.1),
            }),
            position: Some(Vector {
                x: Some(x),
                y: Some(2.0),
            }),
            orientation: Some(Orientation { yaw: Some(0.0) }),
            velocity: Some(Vector {
                x: Some(12.0),
                y: Some(0.0),
            }),
            acceleration: Some(Vector {
                x: Some(-0.5),
                y: Some(3.0),
            }),
        }),
        r#type: Some(2),
        vehicle_classification: Some(VehicleClassification {
            r#type: Some(class),
            role: None,
        }),
    };
    let nanos = step * 50_000_000;
    let along = 12.0 * step as f64 * 0.05;
    GroundTruth {
        timestamp: Some(Timestamp {
            seconds: Some(start + nanos / 1_000_000_000),
            nanos: Some((nanos % 1_000_000_000) as u32),
        }),
        host_vehicle_id: Some(Identifier { value: Some(7) }),
        moving_object: vec![
            object(7, along, (4.5, 1.8), 4),
            object(9, along + 30.0, (12.0, 2.5), 7),
        ],
        map_reference: Some("road.xodr".into()),
    }
}

const ROAD: &str = "<OpenDRIVE><header revMajor='1' revMinor='6'/><road id='1' length='300' junction='-1'>\
    <planView><geometry s='0' x='-50' y='0' hdg='0' length='300'><line/></geometry></planView><lanes><laneSection s='0'>\
    <left><lane id='1' type='driving' level='false'><width sOffset='0' a='4' b='0' c='0' d='0'/></lane></left>\
    <center><lane id='0' type='none' level='false'/></center></laneSection></lanes></road></OpenDRIVE>";

/// Records of MCAP.
fn record(kind: u8, content: &[&[u8]]) -> Vec<u8> {
    let content = content.concat();
    let mut all = vec![kind];
    all.extend((content.len() as u64).to_le_bytes());
    all.extend(content);
    all
}

fn text(text: &str) -> Vec<u8> {
    let mut all = (text.len() as u32).to_le_bytes().to_vec();
    all.extend(text.as_bytes());
    all
}

fn message(channel: u16, content: &[u8]) -> Vec<u8> {
    record(5, &[&channel.to_le_bytes(), &[0; 20], content])
}

fn channel(id: u16, topic: &str, schema: &str) -> Vec<u8> {
    let id = id.to_le_bytes();
    let schema = record(3, &[&id, &text(schema), &text("protobuf"), &text("")]);
    let channel = record(4, &[&id, &id, &text(topic), &text("protobuf"), &text("")]);
    [schema, channel].concat()
}

fn chunk(compression: &str, records: &[u8]) -> Vec<u8> {
    let packed = match compression {
        "zstd" => zstd::encode_all(records, 0).unwrap(),
        "lz4" => {
            let mut encoder = lz4_flex::frame::FrameEncoder::new(Vec::new());
            encoder.write_all(records).unwrap();
            encoder.finish().unwrap()
        }
        _ => records.to_vec(),
    };
    let size = (records.len() as u64).to_le_bytes();
    let length = (packed.len() as u64).to_le_bytes();
    record(
        6,
        &[
            &[0; 16],
            &size,
            &[0; 4],
            &text(compression),
            &length,
            &packed,
        ],
    )
}

fn mcap(compression: &str, start: i64, with_map: bool) -> Vec<u8> {
    let mut truths = channel(1, "ground_truth", "osi3.GroundTruth");
    for step in 0..40 {
        truths.extend(message(1, &moment(step, start).encode_to_vec()));
    }
    let mut all = MAGIC.to_vec();
    all.extend(record(1, &[&text(""), &text("test")]));
    all.extend(chunk(compression, &truths));
    if with_map {
        let map = MapAsamOpenDrive {
            open_drive_xml_content: Some(ROAD.into()),
        };
        all.extend(channel(2, "ground_truth_map", "osi3.MapAsamOpenDrive"));
        all.extend(message(2, &map.encode_to_vec()));
    }
    all.extend(record(0x0f, &[&[0; 4]]));
    // With a summary or without.
    let summary = if with_map { all.len() as u64 } else { 0 };
    if with_map {
        all.extend(channel(1, "ground_truth", "osi3.GroundTruth"));
    }
    all.extend(record(2, &[&summary.to_le_bytes(), &[0; 12]]));
    all.extend(MAGIC);
    all
}

fn trace(messages: impl Iterator<Item = Vec<u8>>) -> Vec<u8> {
    let mut all = Vec::new();
    for message in messages {
        all.extend((message.len() as u32).to_le_bytes());
        all.extend(message);
    }
    all
}

fn write(folder: &Path, name: &str, bytes: &[u8]) -> PathBuf {
    let path = folder.join(name);
    std::fs::write(&path, bytes).unwrap();
    path
}

fn check(scenario: &Scenario, name: &str) {
    assert_eq!(scenario.header.other_format, Some("ASAM OSI"), "{name}");
    assert!((scenario.dt() - 0.05).abs() < 1e-9, "{name}");
    let ego = scenario.recorded_ego.as_ref().unwrap().ego().unwrap();
    assert_eq!(
        (ego.id, ego.footprint.shape().size()),
        (7, (4.5, 1.8)),
        "{name}"
    );
    assert_eq!(ego.track.steps(), 0..40, "{name}");
    let truck = scenario.obstacle(9).unwrap();
    assert_eq!(truck.kind, ObstacleType::Truck, "{name}");
    let motion = truck.track().at(39).unwrap();
    assert!(
        (motion.pose.position - Point::new(53.4, 2.0)).norm() < 1e-9,
        "{name}"
    );
    assert!((motion.velocity - 12.0).abs() < 1e-9, "{name}");
    assert!((motion.acceleration + 0.5).abs() < 1e-9, "{name}");
}

#[test]
fn ground_truth_is_read_from_mcap_in_every_compression_with_its_map() {
    let folder = tempfile::tempdir().unwrap();
    for compression in ["", "zstd", "lz4"] {
        for start in [0, 1_700_000_000] {
            let path = write(folder.path(), "a.mcap", &mcap(compression, start, true));
            let scenario = Entry::of_file(&path).read().unwrap();
            check(&scenario, compression);
            assert_eq!(scenario.network.lanelets.len(), 1, "{compression}");
        }
    }
}

#[test]
fn a_map_that_is_referred_to_lies_beside() {
    let folder = tempfile::tempdir().unwrap();
    let path = write(folder.path(), "a.mcap", &mcap("zstd", 0, false));
    let without = Entry::of_file(&path).read().unwrap();
    assert!(without.network.lanelets.is_empty());
    assert!(
        without
            .diagnostics
            .iter()
            .any(|d| d.message.contains("no map"))
    );
    let other = tempfile::tempdir().unwrap();
    write(other.path(), "road.xodr", ROAD.as_bytes());
    let path = write(other.path(), "a.mcap", &mcap("zstd", 0, false));
    assert_eq!(
        Entry::of_file(&path).read().unwrap().network.lanelets.len(),
        1
    );
}

#[test]
fn traces_have_ground_truth_alone_or_in_the_view_of_a_sensor() {
    let folder = tempfile::tempdir().unwrap();
    let truths = (0..40).map(|step| moment(step, 0));
    let views = truths.clone().map(|truth| SensorView {
        global_ground_truth: Some(truth),
    });
    let of_truths = trace(truths.map(|truth| truth.encode_to_vec()));
    let of_views: Vec<u8> = trace(views.map(|view| {
        // Its own time comes first.
        [&[0x12, 0][..], &view.encode_to_vec()].concat()
    }));
    for (name, bytes) in [("a_gt_3.osi", &of_truths), ("a_sv_3.osi", &of_views)] {
        let path = write(folder.path(), name, bytes);
        check(&Entry::of_file(&path).read().unwrap(), name);
    }
    let found = crate::find(&[folder.path().to_path_buf()]).unwrap();
    assert_eq!(found.entries.len(), 2);
    let cut = write(folder.path(), "cut.osi", &of_truths[..of_truths.len() - 9]);
    let error = Entry::of_file(&cut).read().unwrap_err().to_string();
    assert!(
        error.contains("message 40") && error.contains("truncated"),
        "{error}"
    );
}

#[test]
fn damage_other_schemas_and_odd_messages_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let whole = mcap("zstd", 0, false);
    let path = write(folder.path(), "cut.mcap", &whole[..whole.len() / 2]);
    let error = Entry::of_file(&path).read().unwrap_err().to_string();
    assert!(error.contains("truncated"), "{error}");
    let mut other = MAGIC.to_vec();
    other.extend(channel(1, "/scan", "sensor_msgs/msg/LaserScan"));
    other.extend(message(1, b"x"));
    let path = write(folder.path(), "ros.mcap", &other);
    let error = Entry::of_file(&path).read().unwrap_err().to_string();
    assert!(error.contains("no ground truth of ASAM OSI"), "{error}");
    let nested = chunk("", &chunk("", &channel(1, "g", "osi3.GroundTruth")));
    let path = write(folder.path(), "nested.mcap", &[MAGIC, &nested].concat());
    assert!(Entry::of_file(&path).read().is_err());
    // A message that comes twice, and an object without a place.
    let mut messages: Vec<GroundTruth> = (0..40).map(|step| moment(step, 0)).collect();
    messages[5].moving_object[1].base = None;
    messages.insert(10, messages[9].clone());
    let bytes = trace(messages.iter().map(Message::encode_to_vec));
    let path = write(folder.path(), "odd.osi", &bytes);
    let scenario = Entry::of_file(&path).read().unwrap();
    let warned = |words: &str| {
        let mut all = scenario.diagnostics.iter();
        all.any(|d| d.severity == Severity::Warning && d.message.contains(words))
    };
    assert!(warned("1 messages are not after") && warned("1 moving objects without"));
}
