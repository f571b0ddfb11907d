//! What stands in a recording and is not used is counted by its kind, in each format: what is planted here is told.

use std::path::Path;

use nearmiss::scenario::Severity;
use rusqlite::Connection;

use super::nuplan_file::{Log, write_log, write_map};
use super::*;

/// The kinds that are not used, with their counts.
fn unused(path: &Path) -> Vec<String> {
    let scenario = open(path);
    let all = scenario
        .diagnostics
        .iter()
        .filter(|d| d.severity == Severity::Unused);
    all.map(|d| format!("{} {}", d.message, d.element))
        .collect()
}

#[track_caller]
fn told(path: &Path, expected: &[&str]) {
    let unused = unused(path);
    for kind in expected {
        assert!(
            unused.iter().any(|u| u == kind),
            "{kind} is not in {unused:#?}"
        );
    }
}

fn written(files: &[(&str, &[u8])]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in files {
        std::fs::write(folder.path().join(name), bytes).unwrap();
    }
    folder
}

#[test]
fn of_sumo() {
    let fcd = sumo::fcd(5).replacen(
        "<timestep time=\"5.00\">",
        "<timestep time=\"5.00\" mood=\"1\"><container id=\"c\"/>",
        1,
    );
    let net = sumo::NET.replacen(
        "<edge id=\"in\"",
        "<junction id=\"j\"/><edge hue=\"1\" id=\"in\"",
        1,
    );
    let types = sumo::ROUTES
        .replacen("vClass=\"truck\"", "vClass=\"truck\" sigma=\"0.5\"", 1)
        .replace(
            "</routes>",
            "<vType id=\"x\" vClass=\"airship\"/><flow/></routes>",
        );
    let folder = written(&[
        ("fcd.xml", fcd.as_bytes()),
        ("cross.net.xml", net.as_bytes()),
        ("cross.rou.xml", types.as_bytes()),
    ]);
    let expected = [
        "1 × timestep@mood",
        "1 × timestep/container",
        "13 × vehicle@slope",
        "1 × net/junction",
        "1 × edge@hue",
        "1 × edge of function walkingarea",
        "1 × vType@sigma",
        "1 × vType@vClass `airship`, taken as passenger",
        "1 × routes/flow",
    ];
    told(&folder.path().join("fcd.xml"), &expected);
    let table = "timestep_time;vehicle_id;vehicle_x;vehicle_y;vehicle_angle;vehicle_speed;vehicle_mood\n0;a;0;0;0;1;7\n1;a;1;0;0;1;7\n";
    let folder = written(&[("fcd.csv", table.as_bytes())]);
    told(&folder.path().join("fcd.csv"), &["2 × column vehicle_mood"]);
}

#[test]
fn of_levelx_and_lanelet2() {
    let mut files = levelx::highd(2);
    files[0].1 = files[0].1.replace("thw", "mood");
    files[1].1 = files[1].1.replace("numFrames", "driver");
    let names = ["01_tracks.csv", "01_tracksMeta.csv", "01_recordingMeta.csv"];
    let all: Vec<_> = names
        .iter()
        .zip(&files)
        .map(|(name, (_, text))| (*name, text.as_bytes()))
        .collect();
    let folder = written(&all);
    let expected = [
        "150 × column mood",
        "3 × tracksMeta, column driver",
        "1 × recordingMeta, column weekDay",
    ];
    told(&folder.path().join("01_tracks.csv"), &expected);
    let files = levelx::ind();
    let names = ["07_tracks.csv", "07_tracksMeta.csv", "07_recordingMeta.csv"];
    let osm = levelx::osm().replacen("<way id='100'>", "<way id='100'><tag k='width' v='1'/>", 1).replacen(
        "<tag k='speed_limit' v='50'/>",
        "<tag k='region' v='de'/><member type='relation' ref='9' role='regulatory_element'/>",
        1,
    ).replace(
        "</osm>",
        "<way id='900'><nd ref='1'/><nd ref='2'/><tag k='type' v='stop_line'/></way><relation id='9'><tag k='type' v='regulatory_element'/><tag k='subtype' v='right_of_way'/></relation></osm>",
    );
    let mut all: Vec<_> = names
        .iter()
        .zip(&files)
        .map(|(name, (_, text))| (*name, text.as_bytes()))
        .collect();
    all.push(("map.osm", osm.as_bytes()));
    let folder = written(&all);
    let expected = [
        "1 × way tag@width",
        "1 × lanelet tag@region",
        "1 × lanelet member regulatory_element",
        "1 × way stop_line of no lanelet",
        "1 × relation regulatory_element right_of_way",
    ];
    told(&folder.path().join("07_tracks.csv"), &expected);
}

#[test]
fn of_waymo() {
    let message = tfrecord_file::Message(waymo::scenario("a"));
    let strange = tfrecord_file::Message::default()
        .double(4, 1.0)
        .whole(11, 1)
        .double(2, 0.0)
        .double(3, 0.0)
        .whole(77, 1);
    let track = tfrecord_file::Message::default()
        .whole(1, 990)
        .message(3, &strange);
    let message = message.message(2, &track).whole(4, 5).bytes(99, b"x");
    let bytes = tfrecord_file::file(&[message.0]);
    let folder = written(&[("a.tfrecord", &bytes)]);
    let expected = [
        "1 × tracks/states/center_z",
        "1 × tracks/states/field 77",
        "1 × objects_of_interest",
        "1 × field 99",
        "1 × map_features/speed_bump",
    ];
    told(&folder.path().join("a.tfrecord"), &expected);
}

#[test]
fn of_argoverse() {
    let map = argoverse::map()
        .replacen("\"is_intersection\"", "\"mood\":1,\"is_intersection\"", 1)
        .replacen('{', "{\"season\":3,", 1);
    let folder = written(&[
        ("scenario_x.parquet", &argoverse::with_column("mood")),
        ("log_map_archive_x.json", map.as_bytes()),
    ]);
    let expected = ["85 × column mood", "1 × lane_segments/mood", "1 × season"];
    told(&folder.path().join("scenario_x.parquet"), &expected);
}

#[test]
fn of_nuplan() {
    let folder = tempfile::tempdir().unwrap();
    let (log, map) = (folder.path().join("a.db"), folder.path().join("map.gpkg"));
    write_log(&log, &Log::default());
    write_map(&map);
    let change =
        |path: &Path, sql: &str| Connection::open(path).unwrap().execute_batch(sql).unwrap();
    change(
        &log,
        "CREATE TABLE image (token BLOB); ALTER TABLE lidar_box ADD COLUMN mood REAL",
    );
    change(
        &map,
        "CREATE TABLE walkways (fid INTEGER); ALTER TABLE lanes_polygons ADD COLUMN mood REAL",
    );
    let expected = [
        "1 × table image",
        "1 × table lidar_box, column mood",
        "1 × table walkways",
        "1 × table lanes_polygons, column mood",
    ];
    told(&log, &expected);
}
