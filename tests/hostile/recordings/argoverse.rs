//! Argoverse 2 motion forecasting.

use std::path::PathBuf;

use nearmiss::geometry::Point;
use nearmiss::scenario::{LineMarking, ObstacleType};
use parquet::basic::{BrotliLevel, Compression, GzipLevel, ZstdLevel};

use super::parquet_file::{Column, compressed, file};
use super::*;

const ID: &str = "0a1b2c3d-0000-4a98-b02e-0123456789ab";

/// Track, class, step, and x, y, heading and the two velocities.
type Row = (&'static str, &'static str, i64, [f64; 5]);

/// Three tracks: the recording vehicle, a car that comes later, and a pedestrian.
pub fn table() -> Vec<u8> {
    packed(Compression::SNAPPY)
}

/// The same, compressed so.
fn packed(compression: Compression) -> Vec<u8> {
    made(compression, None)
}

/// The same with a column more.
pub fn with_column(name: &str) -> Vec<u8> {
    made(Compression::SNAPPY, Some(name))
}

fn made(compression: Compression, more: Option<&str>) -> Vec<u8> {
    let mut rows: Vec<Row> = Vec::new();
    for step in 0..30 {
        let t = 0.1 * step as f64;
        rows.push(("AV", "vehicle", step, [10.0 * t, 0.0, 0.0, 10.0, 0.0]));
        if step > 4 {
            rows.push(("900", "bus", step, [40.0, 3.5 - t, -1.5, 0.0, -1.0]));
        }
        rows.push(("12", "pedestrian", step, [20.0, 6.0, 0.3, 0.0, 0.0]));
    }
    let text = |of: fn(&Row) -> String| Column::Text(rows.iter().map(of).collect());
    let number = |i: usize| Column::Number(rows.iter().map(|row| row.3[i]).collect());
    let same = |value: f64| Column::Number(vec![value; rows.len()]);
    let mut columns = vec![
        ("track_id", text(|r| r.0.into())),
        ("object_type", text(|r| r.1.into())),
        (
            "timestep",
            Column::Whole(rows.iter().map(|r| r.2).collect()),
        ),
        ("position_x", number(0)),
        ("position_y", number(1)),
        ("heading", number(2)),
        ("velocity_x", number(3)),
        ("velocity_y", number(4)),
        ("scenario_id", text(|_| ID.into())),
        ("focal_track_id", text(|_| "900".into())),
        ("start_timestamp", same(3.0e17)),
        ("end_timestamp", same(3.0e17 + 2.9e9)),
        ("num_timestamps", Column::Whole(vec![30; rows.len()])),
    ];
    columns.extend(more.map(|name| (name, number(0))));
    compressed(&columns, compression)
}

#[test]
fn all_compressions_open() {
    let codecs = [
        Compression::UNCOMPRESSED,
        Compression::GZIP(GzipLevel::default()),
        Compression::ZSTD(ZstdLevel::default()),
        Compression::BROTLI(BrotliLevel::default()),
        Compression::LZ4,
        Compression::LZ4_RAW,
    ];
    for codec in codecs {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scenario_x.parquet");
        std::fs::write(&path, packed(codec)).unwrap();
        let (scenario, ego) = own_ego(&path);
        assert_eq!(ego.track.steps(), 0..30, "{codec:?}");
        assert_eq!(scenario.obstacles.len(), 2, "{codec:?}");
    }
}

/// The table with the first page to be 2 GiB when unpacked, and no byte longer for it.
fn lying() -> Vec<u8> {
    let mut bytes = table();
    // The header of the dictionary of the first column: its kind, the two sizes, each with a byte before it.
    assert_eq!(bytes[4..7], [0x15, 0x04, 0x15]);
    let varint = |at: usize| bytes[at..].iter().position(|b| *b < 0x80).unwrap() + 1;
    let unpacked = 7..7 + varint(7);
    let packed = unpacked.end + 1..unpacked.end + 1 + varint(unpacked.end + 1);
    assert_eq!(packed.len(), 1, "a small page");
    let largest = [0xfe, 0xff, 0xff, 0xff, 0x0f];
    let longer = largest.len() - unpacked.len();
    let size = usize::from(bytes[packed.start] / 2);
    // What follows the header is as much shorter.
    bytes[packed.start] -= 2 * longer as u8;
    let struct_end = 9;
    let from = packed.end + struct_end;
    bytes.drain(from..from + longer.min(size));
    bytes.splice(unpacked, largest);
    bytes
}

#[test]
fn sizes_that_lie_are_refused_before_there_is_room_for_them() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scenario_x.parquet");
    let bytes = lying();
    assert_eq!(bytes.len(), table().len());
    std::fs::write(&path, bytes).unwrap();
    let error = refused(&path);
    assert!(
        error.contains("in column track_id: page 1 is to have 2147483647 bytes unpacked"),
        "{error}"
    );
}

pub fn map() -> String {
    let line = |points: &[(f64, f64)]| {
        let each = points
            .iter()
            .map(|(x, y)| format!("{{\"x\":{x},\"y\":{y},\"z\":1.0}}"));
        format!("[{}]", each.collect::<Vec<_>>().join(","))
    };
    let lane = |id: i64, left: &str, right: &str, marks: [&str; 2], links: &str| {
        format!(
            "\"{id}\":{{\"id\":{id},\"is_intersection\":false,\"lane_type\":\"VEHICLE\",\"left_lane_boundary\":{left},\"right_lane_boundary\":{right},\"left_lane_mark_type\":\"{}\",\"right_lane_mark_type\":\"{}\",{links}}}",
            marks[0], marks[1]
        )
    };
    let middle = line(&[(0.0, 1.75), (30.0, 1.75), (60.0, 1.75)]);
    let own = lane(
        900,
        &middle,
        &line(&[(0.0, -1.75), (60.0, -1.75)]),
        ["DOUBLE_SOLID_YELLOW", "NONE"],
        "\"successors\":[902,555],\"predecessors\":[],\"left_neighbor_id\":901,\"right_neighbor_id\":null",
    );
    let oncoming = lane(
        901,
        &line(&[(60.0, 1.75), (0.0, 1.75)]),
        &line(&[(60.0, 5.25), (0.0, 5.25)]),
        ["SOLID_WHITE", "DASHED_WHITE"],
        "\"successors\":[],\"predecessors\":[],\"left_neighbor_id\":900,\"right_neighbor_id\":null",
    );
    let next = lane(
        902,
        &line(&[(60.0, 1.75), (90.0, 1.75)]),
        &line(&[(60.0, -1.75), (90.0, -1.75)]),
        ["NONE", "NONE"],
        "\"successors\":[],\"predecessors\":[900],\"left_neighbor_id\":null,\"right_neighbor_id\":null",
    );
    let crossing = format!(
        "\"7\":{{\"id\":7,\"edge1\":{},\"edge2\":{}}}",
        line(&[(20.0, -3.0), (20.0, 7.0)]),
        line(&[(24.0, 7.0), (24.0, -3.0)])
    );
    let area = line(&[(-5.0, -4.0), (95.0, -4.0), (95.0, 8.0)]);
    format!(
        "{{\"lane_segments\":{{{own},{oncoming},{next}}},\"pedestrian_crossings\":{{{crossing}}},\"drivable_areas\":{{\"1\":{{\"id\":1,\"area_boundary\":{area}}},\"2\":{{\"id\":2}}}}}}"
    )
}

fn written() -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(format!("scenario_{ID}.parquet"));
    std::fs::write(&path, table()).unwrap();
    std::fs::write(
        folder.path().join(format!("log_map_archive_{ID}.json")),
        map(),
    )
    .unwrap();
    (folder, path)
}

#[test]
fn a_scenario_is_read_with_its_map() {
    let (folder, path) = written();
    assert_eq!(found(folder.path()), [format!("scenario_{ID}.parquet")]);
    let (scenario, ego) = own_ego(&path);
    near(scenario.header.time_step_size, 0.1);
    assert_eq!(ego.track.steps(), 0..30);
    near(ego.footprint.shape().size().0, 4.87);
    let bus = scenario.obstacle(900).unwrap();
    assert_eq!((bus.kind, bus.track().steps()), (ObstacleType::Bus, 5..30));
    near(bus.track().at(10).unwrap().pose.heading, -1.5);
    near(bus.track().at(10).unwrap().velocity, 1.0);
    let said = messages(&scenario);
    for words in [
        "track 900 is the focal track",
        "no sizes given",
        "bus 12 m × 2.6 m",
        "drivable_areas/2: no boundary of three points",
        "beyond the map left out: 1",
    ] {
        assert!(said.contains(words), "{words}: {said}");
    }
    let lanes = &scenario.network.lanelets;
    // Lane 900 and track 900 have one id; the track keeps it.
    let (own, oncoming, next, crossing) = (&lanes[0], &lanes[1], &lanes[2], &lanes[3]);
    assert_eq!((oncoming.id, next.id, crossing.id), (901, 902, 7));
    assert_ne!(own.id, 900);
    let middle: Vec<Point> = [0.0, 30.0, 60.0].map(|x| Point::new(x, 1.75)).to_vec();
    assert_eq!(own.left.points, middle);
    assert_eq!(own.right.points[1], Point::new(30.0, -1.75));
    assert_eq!(own.left.marking, LineMarking::SolidSolid);
    assert_eq!(own.successors, [902]);
    let beside = own.adjacent_left.unwrap();
    assert_eq!((beside.id, beside.same_direction), (901, false));
    assert_eq!(oncoming.adjacent_left.unwrap().id, own.id);
    assert_eq!(crossing.left.points[0], Point::new(20.0, -3.0));
    assert_eq!(crossing.right.points[0], Point::new(24.0, -3.0));
    let area = [(-5.0, -4.0), (95.0, -4.0), (95.0, 8.0)].map(|(x, y)| Point::new(x, y));
    assert_eq!(scenario.network.areas, [area.to_vec()]);
    survives_conversion(&scenario);
    any_track_can_be_the_ego(&path, ego.id, 12);
    let entry = Entry::of_file(&path);
    assert_eq!(entry.content_hash().unwrap(), scenario.hash);
}

#[test]
fn a_map_may_be_missing_and_errors_name_column_and_element() {
    let (folder, path) = written();
    let map_file = folder.path().join(format!("log_map_archive_{ID}.json"));
    std::fs::write(
        &map_file,
        map().replace("\"right_lane_boundary\"", "\"other\""),
    )
    .unwrap();
    let error = refused(&path);
    assert!(
        error.contains("lane_segments/900") && error.contains("right_lane_boundary"),
        "{error}"
    );
    std::fs::remove_file(&map_file).unwrap();
    let scenario = open(&path);
    assert!(scenario.network.lanelets.is_empty());
    assert!(messages(&scenario).contains("no map"));
    let columns = [
        ("track_id", Column::Text(vec!["AV".into()])),
        ("object_type", Column::Text(vec!["vehicle".into()])),
        ("timestep", Column::Number(vec![0.5])),
        ("position_x", Column::Number(vec![0.0])),
        ("position_y", Column::Number(vec![0.0])),
        ("heading", Column::Number(vec![0.0])),
    ];
    std::fs::write(&path, file(&columns)).unwrap();
    let error = refused(&path);
    assert!(error.contains("row 1: `timestep` is 0.5"), "{error}");
    std::fs::write(&path, file(&columns[..5])).unwrap();
    let error = refused(&path);
    assert!(error.contains("column `heading` is missing"), "{error}");
}
