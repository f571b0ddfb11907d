//! nuPlan: axes and axles, sizes, lanes with their rules, lights, windows, and files that are none of its.

use std::f64::consts::FRAC_PI_2;
use std::fs::{create_dir_all, read_dir, write as write_file};

use nearmiss::geometry::Point;
use nearmiss::metrics::{MEASURES, Series};
use nearmiss::scenario::{LineMarking, ObstacleRole, ObstacleType, SignalColor, TrafficDirection};

use super::nuplan_file::{
    LOCAL, Log, SCENE, SWEEP, TAG, TRACK, axle, hex, token, write_log, write_map,
};
use super::*;

/// A log in a folder, with its map beside it.
fn written(log: &Log, with_map: bool) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.db");
    write_log(&path, log);
    if with_map {
        write_map(&folder.path().join("map.gpkg"));
    }
    (folder, path)
}

#[track_caller]
fn at(point: Point, (x, y): (f64, f64)) {
    near_by(point.x, LOCAL.0 + x, 1e-6);
    near_by(point.y, LOCAL.1 + y, 1e-6);
}

#[track_caller]
fn near_by(a: f64, b: f64, by: f64) {
    assert!((a - b).abs() < by, "{a} is not {b}");
}

fn file_names(folder: &Path) -> Vec<String> {
    let files = read_dir(folder).unwrap().flatten();
    let mut names: Vec<String> = files
        .map(|file| file.file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

#[test]
fn poses_are_of_the_rear_axle_and_headings_counterclockwise() {
    let log = Log {
        heading: 0.5,
        seconds: 4.0,
        ..Log::default()
    };
    let (folder, path) = written(&log, false);
    let (scenario, ego) = own_ego(&path);
    near(scenario.header.time_step_size, 0.05);
    assert_eq!((ego.id, ego.track.steps()), (1, 0..81));
    let (length, width) = ego.footprint.shape().size();
    near(length, 5.176);
    near(width, 2.297);
    let state = ego.track.at(40).unwrap();
    let (x, y, _) = axle(&log, 2.0);
    // The middle is 1.461 m ahead of the axle.
    let (sin, cos) = 0.5_f64.sin_cos();
    at(state.pose.position, (x + 1.461 * cos, y + 1.461 * sin));
    near(state.pose.heading, 0.5);
    near(state.velocity, 10.0);
    let bicycle = scenario.obstacle(3).unwrap();
    assert_eq!(bicycle.kind, ObstacleType::Bicycle);
    let state = bicycle.track().at(40).unwrap();
    at(state.pose.position, (150.0, -22.0));
    near(state.pose.heading, FRAC_PI_2);
    near(state.velocity, 4.0);
    near(bicycle.footprint.as_ref().unwrap().shape().size().0, 1.8);
    let said = messages(&scenario);
    for part in [
        "0.05 s",
        "Chrysler Pacifica",
        "east 664000, north 3996000 in UTM zone 11N",
        "no map: no us-nv-las-vegas-strip/VERSION/map.gpkg",
    ] {
        assert!(said.contains(part), "{part}: {said}");
    }
    assert_eq!(file_names(folder.path()), ["a.db"]);
    survives_conversion(&scenario);
    any_track_can_be_the_ego(&path, 1, 3);
}

#[test]
fn kinds_and_sizes_of_all_categories() {
    let (_folder, path) = written(&Log::default(), false);
    let scenario = open(&path);
    let known = |id: i64| {
        let obstacle = scenario.obstacle(id).unwrap();
        let (length, width) = obstacle.footprint.as_ref().unwrap().shape().size();
        (obstacle.kind, obstacle.role, length, width)
    };
    let (moves, stands) = (ObstacleRole::Dynamic, ObstacleRole::Static);
    assert_eq!(known(2), (ObstacleType::Car, moves, 4.5, 1.9));
    assert_eq!(known(4), (ObstacleType::Pedestrian, moves, 0.8, 0.7));
    assert_eq!(known(5), (ObstacleType::ConstructionZone, stands, 0.4, 0.4));
    assert_eq!(known(6), (ObstacleType::Truck, moves, 12.0, 2.5));
    assert_eq!(known(7), (ObstacleType::Unknown, moves, 0.6, 0.5));
    // The boxes of its track have a size, the track has none.
    assert_eq!(known(8), (ObstacleType::RoadBoundary, stands, 0.9, 0.9));
    let cone = scenario
        .obstacle(5)
        .unwrap()
        .states()
        .next()
        .unwrap()
        .clone();
    near_by(cone.point().unwrap().x, LOCAL.0 + 30.0, 0.1);
    assert_eq!(scenario.obstacle(5).unwrap().states().count(), 1);
    let without_velocity = scenario
        .obstacle(4)
        .unwrap()
        .states()
        .next()
        .unwrap()
        .velocity;
    assert_eq!(without_velocity, None);
    let said = messages(&scenario);
    assert!(
        said.contains("taken as trucks, as the data set does not tell: 1"),
        "{said}"
    );
}

#[test]
fn lanes_continue_and_lie_beside_each_other_and_are_in_place() {
    let (_folder, path) = written(&Log::default(), true);
    let scenario = open(&path);
    let network = &scenario.network;
    let mut ids: Vec<i64> = network.lanelets.iter().map(|l| l.id).collect();
    ids.sort_unstable();
    // 99 is far away, 400 is a crossing.
    assert_eq!(ids, [10, 11, 12, 13, 14, 20, 21, 22, 400]);
    let lane = |id: i64| network.lanelet(id).unwrap();
    // From degrees to metres and within a millimetre of where it is; drawn either way.
    for (id, left, right) in [
        (10, [(0.0, 3.5), (100.0, 3.5)], [(0.0, 0.0), (100.0, 0.0)]),
        (11, [(0.0, 0.0), (100.0, 0.0)], [(0.0, -3.5), (100.0, -3.5)]),
        (
            14,
            [(111.75, -12.0), (111.75, -60.0)],
            [(108.25, -12.0), (108.25, -60.0)],
        ),
    ] {
        for (line, wanted) in [(&lane(id).left, left), (&lane(id).right, right)] {
            let ends = [line.points[0], *line.points.last().unwrap()];
            for (point, (x, y)) in ends.into_iter().zip(wanted) {
                near_by(point.x, LOCAL.0 + x, 1e-3);
                near_by(point.y, LOCAL.1 + y, 1e-3);
            }
        }
    }
    assert_eq!(lane(10).left.marking, LineMarking::Solid);
    assert_eq!(lane(10).right.marking, LineMarking::Dashed);
    assert_eq!(
        (&lane(10).successors[..], &lane(12).predecessors[..]),
        (&[20][..], &[20][..])
    );
    assert_eq!(lane(11).successors, [21, 22]);
    assert_eq!(
        (&lane(22).predecessors[..], &lane(22).successors[..]),
        (&[11][..], &[14][..])
    );
    let beside = |id: i64| {
        let of =
            |side: Option<nearmiss::scenario::Adjacent>| side.map(|a| (a.id, a.same_direction));
        (of(lane(id).adjacent_left), of(lane(id).adjacent_right))
    };
    assert_eq!(beside(10), (None, Some((11, true))));
    assert_eq!(beside(11), (Some((10, true)), None));
    assert_eq!(beside(20), (None, None));
    // The right turn has no borders in the map.
    let middle = network.lanelets_at(&Point::new(LOCAL.0 + 108.0, LOCAL.1 - 5.5));
    assert_eq!(middle, [22]);
    let said = messages(&scenario);
    assert!(
        said.contains("lanes without a border: 1; that side is 1.75 m"),
        "{said}"
    );
    assert!(said.contains("map.gpkg"), "{said}");
    // 25 miles an hour; connectors have no limit here.
    let limit = network
        .signs
        .iter()
        .find(|s| s.elements[0].id == "R2-1")
        .unwrap();
    assert_eq!(limit.elements[0].values, ["11.176"]);
    assert!(lane(10).signs.contains(&limit.id) && lane(20).signs.is_empty());
    let stop = network
        .signs
        .iter()
        .find(|s| s.elements[0].id == "R1-1")
        .unwrap();
    assert!(lane(14).signs.contains(&stop.id));
    let (a, b) = lane(14).stop_line.as_ref().unwrap().points.unwrap();
    near_by(a.y, LOCAL.1 - 57.5, 1e-3);
    near_by((a - b).norm(), 3.5, 1e-3);
    let [intersection] = &network.intersections[..] else {
        panic!("{:?}", network.intersections)
    };
    let [incoming] = &intersection.incomings[..] else {
        panic!("{intersection:?}")
    };
    assert_eq!(
        (&incoming.lanelets[..], &incoming.straight[..]),
        (&[10, 11][..], &[20, 21][..])
    );
    assert_eq!((&incoming.right[..], incoming.left.len()), (&[22][..], 0));
    survives_conversion(&scenario);
}

#[test]
fn a_red_light_turns_green() {
    let (_folder, path) = written(&Log::default(), true);
    let scenario = open(&part(&path, "track=ego@2.0s"));
    let network = &scenario.network;
    let of = |id: i64| {
        let lane = network.lanelet(id).unwrap();
        let [light] = &lane.lights[..] else {
            panic!("{lane:?}")
        };
        let line = lane.stop_line.as_ref().unwrap();
        assert_eq!(line.lights, [*light]);
        near_by(line.points.unwrap().0.x, LOCAL.0 + 97.5, 1e-3);
        network.lights.iter().find(|l| l.id == *light).unwrap()
    };
    // 5 s in the log are 3 s in the window.
    let (left, right) = (of(10), of(11));
    for light in [left, right] {
        let colors = [0, 59, 60, 160].map(|step| light.color_at(step));
        let (red, green) = (SignalColor::Red, SignalColor::Green);
        assert_eq!(colors, [red, red, green, green]);
    }
    assert_eq!(left.direction, Some(TrafficDirection::All));
    // Of the right turn nothing is known.
    assert_eq!(right.direction, Some(TrafficDirection::Straight));
}

#[test]
fn a_long_log_is_listed_as_windows_of_its_ego() {
    let log = Log {
        seconds: 60.0,
        starts: 30.0,
        ..Log::default()
    };
    let (folder, path) = written(&log, true);
    let windows = found(folder.path());
    assert!(!windows.is_empty());
    // It stops behind the car at 35.5 s.
    let start = windows[0].strip_prefix("a.db#track=ego@").unwrap();
    let start: f64 = start.strip_suffix('s').unwrap().parse().unwrap();
    assert!((start..start + 10.0).contains(&35.0), "{windows:?}");
    assert!(
        windows.iter().all(|w| w.starts_with("a.db#track=ego@")),
        "{windows:?}"
    );
    let (scenario, ego) = own_ego(&folder.path().join(&windows[0]));
    assert_eq!(ego.track.steps(), 0..201);
    let scene = Scene::new(Arc::clone(&scenario), ego);
    let ttc = MEASURES.iter().find(|m| m.id == "ttc").unwrap();
    let series = Series::compute(&scene, vec![ttc]);
    let values = series.row("ttc", 2).iter().filter_map(|r| r.value());
    // 8.7 m before it, at 10 m/s.
    let least = values.fold(f64::MAX, f64::min);
    assert!((0.8..1.0).contains(&least), "{least}");
    let error = refused(&path);
    assert!(
        error.contains("longer than 30 s") && error.contains("a.db#track=ego@0.0s"),
        "{error}"
    );
    // Other tracks, by number and token; scenes; sweeps and tags.
    let ego_of = |said: &str| own_ego(&part(&path, said));
    assert_eq!(ego_of("track=3@1.0s").1.id, 3);
    assert_eq!(ego_of(&format!("track={}@1.0s", hex(TRACK, 1))).1.id, 3);
    assert_eq!(ego_of("track=3").1.track.steps(), 0..1201);
    for said in [
        "scene=scene-1".to_string(),
        format!("scene={}", hex(SCENE, 1)),
        hex(SCENE, 1),
    ] {
        let (_, ego) = ego_of(&said);
        assert_eq!((ego.id, ego.track.steps()), (1, 0..400), "{said}");
    }
    for said in [hex(SWEEP, 600), hex(TAG, 0)] {
        let (scenario, ego) = ego_of(&said);
        // From 3 s before 30 s.
        assert_eq!(ego.track.steps(), 0..201, "{said}");
        assert!(
            scenario.header.benchmark_id.ends_with("-1_1_T-541"),
            "{}",
            scenario.header.benchmark_id
        );
    }
    for (said, why) in [
        (
            "track=9@1.0s",
            "no track `9`; it has ego, and tracks 2 to 8",
        ),
        (
            "track=5@1.0s",
            "track 5 stands, and is no ego: a constructionZone",
        ),
        (
            "track=ego@900.0s",
            "no sweep in that window; the log takes 60.0 s",
        ),
        ("scene=x", "no scene `x`; it has scene-0, scene-1, scene-2"),
        ("0123456789abcdef", "no sweep, scene or scenario tag"),
        (
            "12",
            "`12` is no part of a log; name ten seconds around a track as `track=ego@34.0s`",
        ),
    ] {
        let error = refused(&part(&path, said));
        assert!(error.contains(why), "{said}: {error}");
    }
    assert_eq!(file_names(folder.path()), ["a.db", "map.gpkg"]);
}

#[test]
fn a_log_without_indexes_is_read_the_same() {
    let read = |indexed: bool| {
        let log = Log {
            indexed,
            ..Log::default()
        };
        let (_folder, path) = written(&log, true);
        open(&part(&path, "track=ego@2.0s"))
    };
    let (with, without) = (read(true), read(false));
    assert_eq!(with.obstacles, without.obstacles);
    assert_eq!(with.network, without.network);
    assert_eq!(with.hash, without.hash);
}

#[test]
fn maps_are_found_in_the_folders_of_the_data_set() {
    let root = tempfile::tempdir().unwrap();
    let logs = root.path().join("nuplan-v1.1/splits/mini");
    let maps = root.path().join("maps/us-nv-las-vegas-strip/9.15.1915");
    create_dir_all(&logs).unwrap();
    create_dir_all(&maps).unwrap();
    write_log(&logs.join("a.db"), &Log::default());
    write_map(&maps.join("map.gpkg"));
    let scenario = open(&logs.join("a.db"));
    assert_eq!(scenario.network.lanelets.len(), 9);
    // Both are in one search, and the map is no scenario.
    assert_eq!(found(root.path()), ["nuplan-v1.1/splits/mini/a.db"]);
    // A name that leads elsewhere leads nowhere.
    let odd = logs.join("b.db");
    let log = Log {
        map: "../../maps/us-nv-las-vegas-strip",
        seconds: 1.0,
        ..Log::default()
    };
    write_log(&odd, &log);
    assert!(messages(&open(&odd)).contains("no map: no ?/VERSION/map.gpkg"));
}

#[test]
fn files_that_are_no_logs_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    write_file(path("text.db"), "no database at all").unwrap();
    write_file(path("empty.db"), "").unwrap();
    write_file(path("xml.db"), "<commonRoad/>").unwrap();
    write_map(&path("map.gpkg"));
    std::fs::copy(path("map.gpkg"), path("map.db")).unwrap();
    let other = rusqlite::Connection::open(path("other.db")).unwrap();
    other
        .execute_batch("CREATE TABLE cars (id INTEGER); CREATE TABLE log (id INTEGER)")
        .unwrap();
    drop(other);
    drop(nearmiss::store::Store::open(&path("store.db")).unwrap());
    write_log(
        &path("whole.db"),
        &Log {
            seconds: 1.0,
            ..Log::default()
        },
    );
    let whole = std::fs::read(path("whole.db")).unwrap();
    write_file(path("cut.db"), &whole[..whole.len() / 3]).unwrap();
    for (name, why) in [
        (
            "text.db",
            "not a SQLite file; a nuPlan log is a SQLite file with the tables lidar_pc",
        ),
        ("empty.db", "empty"),
        (
            "map.gpkg",
            "a GeoPackage, not a recording; name a nuPlan log",
        ),
        ("map.db", "a GeoPackage, not a recording"),
        (
            "other.db",
            "a SQLite file with the tables cars, log; a nuPlan log",
        ),
        (
            "store.db",
            "a store of answers of nearmiss, not a recording",
        ),
        ("cut.db", "damaged or cut short"),
    ] {
        let error = refused(&path(name));
        assert!(
            error.contains(name) && error.contains(why),
            "{name}: {error}"
        );
    }
    assert!(!refused(&path("xml.db")).contains("SQLite"));
    let results = find(&[folder.path().to_path_buf()]).unwrap();
    let names: Vec<&str> = results.entries.iter().map(|e| e.name.as_str()).collect();
    assert_eq!(names, ["whole"]);
    let passed: Vec<String> = results
        .passed_over
        .iter()
        .map(ToString::to_string)
        .collect();
    assert!(
        passed.len() == 1 && passed[0].contains("cut.db"),
        "{passed:?}"
    );
}

#[test]
fn errors_name_table_row_and_column() {
    let why = |change: &str| {
        let (folder, path) = written(
            &Log {
                seconds: 1.0,
                ..Log::default()
            },
            true,
        );
        let (of, sql) = change.split_once(": ").unwrap();
        let file = rusqlite::Connection::open(folder.path().join(of)).unwrap();
        file.execute_batch(sql).unwrap();
        drop(file);
        refused(&path)
    };
    let pose = u64::from_be_bytes(token(2, 0));
    let pose = format!("{pose:016x}");
    for (change, parts) in [
        (
            "a.db: UPDATE ego_pose SET x = 'east' WHERE rowid = 21".to_string(),
            vec![
                "table ego_pose, row ",
                &pose,
                "column x",
                "`east`, not a number",
            ],
        ),
        (
            "a.db: UPDATE lidar_box SET yaw = NULL WHERE rowid = 1".into(),
            vec![
                "table lidar_box, row 05",
                "column yaw",
                "it is empty, not a number",
            ],
        ),
        (
            "a.db: DELETE FROM ego_pose WHERE rowid = 7".into(),
            vec!["table lidar_pc, row 01", "its ego_pose 02", "is missing"],
        ),
        (
            "a.db: DROP TABLE track".into(),
            vec!["table track", "the table is missing"],
        ),
        (
            "a.db: ALTER TABLE lidar_box RENAME COLUMN yaw TO heading".into(),
            vec!["table lidar_box", "no column `yaw`; it has token"],
        ),
        (
            "a.db: DELETE FROM lidar_pc WHERE rowid > 1".into(),
            vec!["1 sweeps", "at least 2"],
        ),
        (
            "a.db: UPDATE lidar_pc SET timestamp = 7".into(),
            vec![
                "table lidar_pc",
                "the time step `0` is not a positive number",
            ],
        ),
        (
            "a.db: UPDATE lidar_pc SET timestamp = 9000000000000000 WHERE rowid = 1".into(),
            vec!["table lidar_pc", "in steps of 0.05 s are too many"],
        ),
        (
            "a.db: UPDATE ego_pose SET qw = 0, qz = 0".into(),
            vec!["column qw", "is no heading"],
        ),
        (
            "map.gpkg: UPDATE boundaries SET geom = x'4750' WHERE fid = 3".into(),
            vec![
                "map.gpkg",
                "table boundaries, row 3, column geom",
                "ends early",
            ],
        ),
        (
            "map.gpkg: UPDATE meta SET value = 'epsg:25832' WHERE fid = 2".into(),
            vec!["map.gpkg", "`epsg:25832` is not a zone of UTM on WGS 84"],
        ),
        (
            "map.gpkg: UPDATE meta SET value = 'epsg:32619' WHERE fid = 2".into(),
            vec!["map.gpkg", "not in or beside UTM zone 19"],
        ),
        (
            "map.gpkg: DROP TABLE lanes_polygons".into(),
            vec!["map.gpkg", "not a map of nuPlan"],
        ),
    ] {
        let error = why(&change);
        for part in parts {
            assert!(error.contains(part), "{change}: {part}: {error}");
        }
    }
}

#[test]
fn sweeps_that_are_missing_leave_their_steps_out() {
    let (folder, path) = written(
        &Log {
            seconds: 4.0,
            ..Log::default()
        },
        false,
    );
    let file = rusqlite::Connection::open(folder.path().join("a.db")).unwrap();
    // Rows are written backwards: the steps 20 to 29.
    file.execute_batch("DELETE FROM lidar_pc WHERE rowid BETWEEN 52 AND 61")
        .unwrap();
    drop(file);
    let (scenario, ego) = own_ego(&path);
    assert!(ego.track.at(19).is_some() && ego.track.at(30).is_some());
    let (x, ..) = axle(&Log::default(), 1.5);
    at(ego.track.at(30).unwrap().pose.position, (x + 1.461, -1.75));
    let said = messages(&scenario);
    assert!(said.contains("10 steps of 0.05 s have no sweep"), "{said}");
}
