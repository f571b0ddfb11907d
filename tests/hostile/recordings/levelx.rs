//! highD and its kin, from their published description: axes, points of reference, lanes of both directions.

use std::f64::consts::PI;
use std::fmt::Write;
use std::path::PathBuf;

use nearmiss::geometry::Point;
use nearmiss::metrics::{MEASURES, Series};
use nearmiss::scenario::ObstacleType;

use super::*;

/// Frames a second.
const RATE: i64 = 25;

/// highD: 1 drives left in the upper half; 2 and 3 drive right in the lower half, 3 behind 2 and faster until 30 s.
pub fn highd(seconds: i64) -> [(&'static str, String); 3] {
    let mut tracks = String::from(
        "frame,id,x,y,width,height,xVelocity,yVelocity,xAcceleration,yAcceleration,frontSightDistance,backSightDistance,dhw,thw,ttc,precedingXVelocity,precedingId,followingId,leftPrecedingId,leftAlongsideId,leftFollowingId,rightPrecedingId,rightAlongsideId,rightFollowingId,laneId\n",
    );
    // The upper left corner of a box, its length and width, and its velocity.
    let mut row = |id: i64, frame: i64, [x, y, length, width, v]: [f64; 5], lane: i64| {
        let _ = writeln!(
            tracks,
            "{frame},{id},{x:.3},{y},{length},{width},{v},0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,{lane}"
        );
    };
    let frames = 1..=seconds * RATE;
    let time = |frame: i64| frame as f64 / RATE as f64;
    for frame in frames.clone() {
        row(
            1,
            frame,
            [2000.0 - 30.0 * time(frame), 9.0, 12.0, 2.5, -30.0],
            2,
        );
    }
    for frame in frames.clone() {
        row(
            2,
            frame,
            [100.0 + 20.0 * time(frame), 22.0, 4.0, 2.0, 20.0],
            5,
        );
    }
    for frame in frames {
        let t = time(frame);
        let x = 20.0 + 20.0 * t + 2.4 * t.min(30.0);
        row(
            3,
            frame,
            [x, 22.0, 5.0, 2.0, if t < 30.0 { 22.4 } else { 20.0 }],
            5,
        );
    }
    let last = seconds * RATE;
    let meta = format!(
        "id,width,height,initialFrame,finalFrame,numFrames,class,drivingDirection\n1,12,2.5,1,{last},{last},Truck,1\n2,4,2,1,{last},{last},Car,2\n3,5,2,1,{last},{last},Car,2\n"
    );
    let about = "id,frameRate,locationId,speedLimit,month,weekDay,startTime,duration,totalDrivenDistance,totalDrivenTime,numVehicles,numCars,numTrucks,upperLaneMarkings,lowerLaneMarkings\n1,25,2,36.11,9.2017,Tue,08:38,900,1,1,3,2,1,8.5;12.5;16.5,21;25;29\n".to_string();
    [
        ("tracks", tracks),
        ("tracksMeta", meta),
        ("recordingMeta", about),
    ]
}

/// inD: a car that turns left, and a pedestrian without a size.
pub fn ind() -> [(&'static str, String); 3] {
    let mut tracks = String::from(
        "recordingId,trackId,frame,trackLifetime,xCenter,yCenter,heading,width,length,xVelocity,yVelocity,xAcceleration,yAcceleration,lonVelocity,latVelocity,lonAcceleration,latAcceleration\n",
    );
    for frame in 0..50 {
        let angle = f64::from(frame) * 0.02;
        let (sin, cos) = angle.sin_cos();
        let _ = writeln!(
            tracks,
            "7,0,{frame},{frame},{},{},{},1.9,4.4,{},{},0,0,0,0,0,0",
            20.0 * sin,
            -20.0 * cos,
            angle.to_degrees(),
            10.0 * cos,
            10.0 * sin
        );
    }
    for frame in 10..50 {
        let _ = writeln!(tracks, "7,1,{frame},{frame},5,-15,270,0,0,0,-1,0,0,0,0,0,0");
    }
    let meta = "recordingId,trackId,initialFrame,finalFrame,numFrames,width,length,class\n7,0,0,49,50,1.9,4.4,car\n7,1,10,49,40,0,0,pedestrian\n".to_string();
    let about = "recordingId,locationId,frameRate,speedLimit,weekday,startTime,duration,numTracks,numVehicles,numVRUs,latLocation,lonLocation,xUtmOrigin,yUtmOrigin,orthoPxToMeter\n7,1,25,13.89,tue,9,2,2,1,1,50.78,6.07,293487.1224,5629711.58163,0.0081\n".to_string();
    [
        ("tracks", tracks),
        ("tracksMeta", meta),
        ("recordingMeta", about),
    ]
}

/// Two lanelets after each other that share their left border with one in the other direction.
pub fn osm() -> String {
    let mut nodes = String::new();
    let corners = [
        (0.0, 0.0),
        (50.0, 0.0),
        (100.0, 0.0),
        (0.0, -3.5),
        (50.0, -3.5),
        (100.0, -3.5),
        (0.0, 3.5),
        (100.0, 3.5),
    ];
    for (i, (x, y)) in corners.iter().enumerate() {
        let _ = write!(
            nodes,
            "<node id='{}' lat='50.78' lon='6.07'><tag k='local_x' v='{x}'/><tag k='local_y' v='{y}'/></node>",
            i + 1
        );
    }
    let way = |id: i64, nodes: &[i64], subtype: &str| {
        let nodes: String = nodes.iter().map(|n| format!("<nd ref='{n}'/>")).collect();
        format!(
            "<way id='{id}'>{nodes}<tag k='type' v='line_thin'/><tag k='subtype' v='{subtype}'/></way>"
        )
    };
    let lanelet = |id: i64, left: i64, right: i64| {
        format!(
            "<relation id='{id}'><member type='way' ref='{left}' role='left'/><member type='way' ref='{right}' role='right'/><tag k='type' v='lanelet'/><tag k='subtype' v='road'/><tag k='location' v='urban'/><tag k='one_way' v='yes'/><tag k='speed_limit' v='50'/></relation>"
        )
    };
    // Way 101 runs against the lanelets that it is the right border of; lanelet 203 is driven the other way.
    format!(
        "<?xml version='1.0'?><osm>{nodes}{}{}{}{}{}{}{}{}</osm>",
        way(100, &[1, 2], "dashed"),
        way(101, &[5, 4], "solid"),
        way(102, &[2, 3], "dashed"),
        way(103, &[5, 6], "solid"),
        way(104, &[7, 8], "solid"),
        lanelet(201, 100, 101),
        lanelet(202, 102, 103),
        lanelet(203, 100, 104)
    )
}

fn written(prefix: &str, files: [(&str, String); 3]) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    for (end, text) in files {
        std::fs::write(folder.path().join(format!("{prefix}_{end}.csv")), text).unwrap();
    }
    let path = folder.path().join(format!("{prefix}_tracks.csv"));
    (folder, path)
}

#[test]
fn corners_become_middles_and_y_points_up() {
    let (_folder, path) = written("01", highd(20));
    let path = part(&path, "track=2@2.0s");
    let (scenario, ego) = own_ego(&path);
    near(scenario.header.time_step_size, 0.04);
    // The window begins at frame 50.
    assert_eq!((ego.id, ego.track.steps()), (2, 0..251));
    let at = ego.track.at(0).unwrap();
    near(at.pose.position.x, 100.0 + 40.0 + 2.0);
    near(at.pose.position.y, -23.0);
    assert_eq!((at.pose.heading, at.velocity), (0.0, 20.0));
    near(ego.footprint.shape().size().0, 4.0);
    let truck = scenario.obstacle(1).unwrap();
    assert_eq!(truck.kind, ObstacleType::Truck);
    let at = truck.track().at(25).unwrap();
    near(at.pose.position.x, 2000.0 - 90.0 + 6.0);
    near(at.pose.position.y, -10.25);
    assert_eq!((at.pose.heading, at.velocity), (PI, 30.0));
    survives_conversion(&scenario);
    any_track_can_be_the_ego(&path, 2, 3);
}

#[test]
fn lanes_of_both_directions_are_driven_their_way() {
    let (_folder, path) = written("01", highd(20));
    let scenario = open(&part(&path, "track=2"));
    let network = &scenario.network;
    assert_eq!(network.lanelets.len(), 4);
    for (at, heading) in [
        (Point::new(1000.0, -10.5), PI),
        (Point::new(300.0, -23.0), 0.0),
    ] {
        let ids = network.lanelets_at(&at);
        assert_eq!(ids.len(), 1);
        let lanelet = network.lanelet(ids[0]).unwrap();
        let along = lanelet.left.points[1] - lanelet.left.points[0];
        near(along.y.atan2(along.x).abs(), heading);
        let across = lanelet.left.points[0] - lanelet.right.points[0];
        assert!(along.perp(&across) > 0.0, "the left border is on the left");
        assert_eq!(lanelet.signs.len(), 1);
    }
    // The rightmost lane of those who drive left is at the top of the picture.
    let top = network
        .lanelet(network.lanelets_at(&Point::new(1000.0, -10.5))[0])
        .unwrap();
    assert!(top.adjacent_right.is_none() && top.adjacent_left.is_some());
    let bottom = network
        .lanelet(network.lanelets_at(&Point::new(300.0, -27.0))[0])
        .unwrap();
    assert!(bottom.adjacent_right.is_none() && bottom.adjacent_left.is_some());
    let said = messages(&scenario);
    assert!(!said.contains("warning"), "{said}");
}

#[test]
fn a_long_recording_is_listed_as_windows_worth_looking_at() {
    let (folder, path) = written("01", highd(60));
    let windows = found(folder.path());
    // 3 comes up to 2 until 30 s; the window shows that, and not twice.
    assert!(
        windows[0].starts_with("01_tracks.csv#track=3@22."),
        "{windows:?}"
    );
    // The truck of the other direction passes in its own lane.
    assert_eq!(windows.len(), 1, "{windows:?}");
    let entry = Entry::of_file(&folder.path().join(&windows[0]));
    assert!(
        entry.name.starts_with("01_tracks-track-3-2"),
        "{}",
        entry.name
    );
    let scenario = entry.read().unwrap();
    let ego = entry.recorded_ego(&scenario).unwrap().unwrap();
    let scene = Scene::new(scenario, ego);
    let ttc = MEASURES.iter().find(|m| m.id == "ttc").unwrap();
    let series = Series::compute(&scene, vec![ttc]);
    let values = series.row("ttc", 2).iter().filter_map(|r| r.value());
    let least = values.fold(f64::MAX, f64::min);
    // 3 m apart at 30 s, closing at 2.4 m/s.
    assert!((1.2..1.4).contains(&least), "{least}");
    let error = refused(&path);
    assert!(
        error.contains("longer than 30 s") && error.contains("01_tracks.csv#track=1@0.0s"),
        "{error}"
    );
    let error = refused(&part(&path, "track=9@1.0s"));
    assert!(
        error.contains("no track `9`; it has tracks 1 to 3"),
        "{error}"
    );
    let error = refused(&part(&path, "track=3@900.0s"));
    assert!(error.contains("not there in that window"), "{error}");
}

#[test]
fn headings_are_degrees_and_people_get_a_size() {
    let (folder, path) = written("07", ind());
    std::fs::write(folder.path().join("map.osm"), osm()).unwrap();
    assert_eq!(found(folder.path()), ["07_tracks.csv"]);
    let path = part(&path, "track=0");
    let (scenario, ego) = own_ego(&path);
    // Ids of CommonRoad begin at 1.
    assert_eq!((ego.id, ego.track.steps()), (2, 0..50));
    assert!(messages(&scenario).contains("track 0 is numbered 2"));
    let at = ego.track.at(40).unwrap();
    near(at.pose.heading, 0.8);
    near(at.pose.position.x, 20.0 * 0.8_f64.sin());
    near(at.velocity, 10.0);
    let pedestrian = scenario.obstacle(1).unwrap();
    near(pedestrian.track().at(10).unwrap().pose.heading, 1.5 * PI);
    near(pedestrian.footprint.as_ref().unwrap().shape().size().0, 0.6);
    assert!(messages(&scenario).contains("tracks without a size: 1; assumed by class: pedestrian"));
    let lanes = &scenario.network.lanelets;
    assert_eq!(
        lanes.iter().map(|l| l.id).collect::<Vec<_>>(),
        [201, 202, 203]
    );
    assert_eq!(lanes[0].right.points[0], Point::new(0.0, -3.5));
    assert_eq!(
        (lanes[0].successors[0], lanes[1].predecessors[0]),
        (202, 201)
    );
    // The borders of 203 are way 100 on its left, which is driven the other way round.
    assert_eq!(lanes[2].left.points.last().unwrap().x, 0.0);
    let beside = lanes[0].adjacent_left.unwrap();
    assert_eq!((beside.id, beside.same_direction), (203, false));
    survives_conversion(&scenario);
}

#[test]
fn errors_name_file_row_and_column() {
    let mut files = highd(2);
    files[0].1 = files[0].1.replacen("1,1,", "1,x,", 1);
    let (folder, path) = written("01", files);
    let error = refused(&part(&path, "track=1"));
    assert!(
        error.contains("01_tracks.csv") && error.contains(":2: in column id: `x` is not a number"),
        "{error}"
    );
    std::fs::remove_file(folder.path().join("01_tracksMeta.csv")).unwrap();
    let error = refused(&path);
    assert!(
        error.contains("`_tracksMeta.csv` is not beside it"),
        "{error}"
    );
}

#[test]
fn tables_may_be_separated_by_semicolons_with_decimal_commas() {
    let plain = {
        let (_folder, path) = written("01", highd(2));
        open(&part(&path, "track=2"))
    };
    for comma in [false, true] {
        let mut files = highd(2);
        for (_, text) in &mut files {
            // The lists of lines stand in quotes then.
            *text = text
                .replace("8.5;12.5;16.5", "\"8.5 12.5 16.5\"")
                .replace("21;25;29", "\"21 25 29\"");
            *text = text.replace(',', ";");
            if comma {
                *text = text.replace('.', ",");
            }
        }
        let (folder, path) = written("01", files);
        assert_eq!(found(folder.path()), ["01_tracks.csv"]);
        let scenario = open(&part(&path, "track=2"));
        assert_eq!(scenario.obstacles, plain.obstacles);
        assert_eq!(scenario.network.lanelets, plain.network.lanelets);
        assert_eq!(messages(&scenario).contains("with a decimal comma"), comma);
    }
    // Fields that are not in quotes would shift all others.
    let mut files = highd(2);
    files[2].1 = files[2].1.replace(',', ";");
    let (_folder, path) = written("01", files);
    let error = refused(&path);
    assert!(
        error.contains("01_recordingMeta.csv:2: 19 fields for 15 columns"),
        "{error}"
    );
}

#[test]
fn rows_that_contradict_each_other_are_told() {
    let mut files = highd(2);
    // The rows of 2 under the id of 1.
    let rows = files[0].1.lines().map(|line| match line.split(',').nth(1) {
        Some("2") => line.replacen(",2,", ",1,", 1),
        _ => line.to_string(),
    });
    files[0].1 = rows.collect::<Vec<_>>().join("\n") + "\n";
    let (_folder, path) = written("01", files);
    let said = messages(&open(&part(&path, "track=3")));
    assert!(
        said.contains("track 1") && said.contains("50 rows are at a step that has one already"),
        "{said}"
    );
    assert!(
        said.contains("1 tracks of its _tracksMeta.csv have no row in their frames, such as 2"),
        "{said}"
    );
    let mut files = highd(2);
    files[1].1 = files[1].1.replace("\n2,", "\n1,");
    let (_folder, path) = written("01", files);
    assert!(refused(&path).contains("track 1 is there twice"));
}

#[test]
fn a_road_has_so_many_lines() {
    let mut files = highd(2);
    let many: Vec<String> = (0..70).map(|i| format!("{}.5", i)).collect();
    files[2].1 = files[2].1.replace("8.5;12.5;16.5", &many.join(";"));
    let (_folder, path) = written("01", files);
    let error = refused(&path);
    assert!(
        error.contains("column upperLaneMarkings: 70 lines; a road has at most 64"),
        "{error}"
    );
}
