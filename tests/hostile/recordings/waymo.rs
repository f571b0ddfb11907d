//! Waymo Open Motion.

use std::path::PathBuf;

use nearmiss::geometry::Point;
use nearmiss::scenario::{LineMarking, ObstacleType, SignalColor};

use super::tfrecord_file::{Message, file, header};
use super::*;

/// Steps of 0.1 s.
const STEPS: i64 = 20;

fn point(x: f64, y: f64) -> Message {
    Message::default().double(1, x).double(2, y).double(3, 7.0)
}

fn line(number: u64, y: f64) -> Message {
    let points = (0..=10).map(|i| point(f64::from(i) * 10.0, y));
    points.fold(Message::default(), |m, p| m.message(number, &p))
}

/// A track whose state at a step is x, y, heading, vx, vy, or nothing.
fn track(id: i64, kind: i64, size: (f32, f32), at: impl Fn(i64) -> Option<[f64; 5]>) -> Message {
    let states = (0..STEPS).map(|step| match at(step) {
        Some([x, y, heading, vx, vy]) => Message::default()
            .double(2, x)
            .double(3, y)
            .float(5, size.0)
            .float(6, size.1)
            .float(8, heading as f32)
            .float(9, vx as f32)
            .float(10, vy as f32)
            .whole(11, 1),
        None => Message::default().double(2, -1.0).whole(11, 0),
    });
    let head = Message::default().whole(1, id).whole(2, kind);
    states.fold(head, |m, state| m.message(3, &state))
}

fn boundary(to: i64, feature: i64, kind: i64) -> Message {
    Message::default()
        .whole(1, 0)
        .whole(2, to)
        .whole(3, feature)
        .whole(4, kind)
}

fn neighbor(lane: i64) -> Message {
    Message::default().whole(1, lane).whole(2, 0).whole(3, 10)
}

fn feature(id: i64, number: u64, of: &Message) -> Message {
    Message::default().whole(1, id).message(number, of)
}

/// Two lanes of 3 m and 4 m, a crosswalk, a stop sign, a light, and three tracks; the second records.
pub fn scenario(id: &str) -> Vec<u8> {
    let mut message = (0..STEPS).fold(Message::default(), |m, i| {
        m.double(1, 0.1 * i as f64 + 1e-5)
    });
    let time = |step: i64| 0.1 * step as f64;
    message = message
        .message(
            2,
            &track(1, 1, (4.5, 1.9), |i| {
                // Not seen for two steps.
                (i != 7 && i != 8).then(|| [30.0 + 10.0 * time(i), 0.0, 0.0, 10.0, 0.0])
            }),
        )
        .message(
            2,
            &track(77, 1, (5.0, 2.0), |i| {
                Some([8.0 * time(i), 0.0, 0.0, 8.0, 0.0])
            }),
        )
        .message(
            2,
            &track(5, 2, (0.6, 0.7), |i| {
                (i > 3).then(|| [50.0, -6.0 + time(i), 1.5, 0.0, 1.0])
            }),
        )
        .bytes(5, id.as_bytes())
        .whole(6, 1);
    for step in 0..STEPS {
        let state = if step < 12 { 4 } else { 6 };
        let light = Message::default()
            .whole(1, 1)
            .whole(2, state)
            .message(3, &point(90.0, 0.0));
        message = message.message(7, &Message::default().message(1, &light));
    }
    // Lane 1 along y = 0 with borders at ±1.5; lane 2 along y = 3.5 with one at 5.5, its right one from its neighbour.
    let lane = |y: f64| {
        Message::default()
            .double(1, 25.0)
            .whole(2, 2)
            .0
            .into_iter()
            .chain(line(8, y).0)
            .collect::<Vec<u8>>()
    };
    let right = Message(lane(0.0))
        .bytes(10, &[3])
        .message(11, &neighbor(2))
        .message(13, &boundary(10, 10, 1))
        .message(14, &boundary(10, 11, 0));
    let left = Message(lane(3.5))
        .message(12, &neighbor(1))
        .message(13, &boundary(10, 12, 7));
    let after = Message::default()
        .message(8, &point(100.0, 0.0))
        .message(8, &point(120.0, 0.0))
        .bytes(9, &[1]);
    let edge = Message(line(2, -1.5).0).whole(1, 1);
    let crosswalk = [(50.0, -3.0), (54.0, -3.0), (54.0, 7.0), (50.0, 7.0)]
        .iter()
        .fold(Message::default(), |m, (x, y)| m.message(1, &point(*x, *y)));
    let stop = Message::default()
        .whole(1, 3)
        .message(2, &point(99.0, -3.0));
    for feature in [
        feature(1, 3, &right),
        feature(2, 3, &left),
        feature(3, 3, &after),
        feature(10, 4, &line(2, 1.5)),
        feature(11, 5, &edge),
        feature(12, 4, &line(2, 5.5)),
        feature(20, 7, &stop),
        feature(21, 8, &crosswalk),
        feature(22, 9, &crosswalk_bump()),
    ] {
        message = message.message(8, &feature);
    }
    message.whole(10, 10).0
}

fn crosswalk_bump() -> Message {
    Message::default().message(1, &point(0.0, 0.0))
}

fn written(records: &[Vec<u8>]) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("validation.tfrecord-00000-of-00150");
    std::fs::write(&path, file(records)).unwrap();
    (folder, path)
}

#[test]
fn a_scenario_is_read_whole() {
    let (_folder, path) = written(&[scenario("abc123")]);
    let (scenario, ego) = own_ego(&path);
    assert_eq!(scenario.header.time_step_size, 0.1);
    assert_eq!(scenario.header.benchmark_id, "USA_Waymoabc123-1_1_T-1");
    assert_eq!((ego.id, ego.track.steps()), (77, 0..STEPS));
    near(ego.track.at(10).unwrap().pose.position.x, 8.0);
    near(ego.track.at(10).unwrap().velocity, 8.0);
    let car = scenario.obstacle(1).unwrap();
    assert_eq!(
        (car.kind, car.track().steps()),
        (ObstacleType::Car, 0..STEPS)
    );
    assert!(car.track().at(7).is_none() && car.track().at(9).is_some());
    let size = car.footprint.as_ref().unwrap().shape().size();
    near(size.0, 4.5);
    near(size.1, f64::from(1.9_f32));
    let pedestrian = scenario.obstacle(5).unwrap();
    assert_eq!(pedestrian.kind, ObstacleType::Pedestrian);
    assert_eq!(pedestrian.track().steps(), 4..STEPS);
    near(pedestrian.track().at(9).unwrap().pose.heading, 1.5);
    let problem = &scenario.planning_problems[0];
    assert_eq!((problem.id, problem.goals[0].time.to), (77, STEPS - 1));
    survives_conversion(&scenario);
    any_track_can_be_the_ego(&path, 77, 1);
}

#[test]
fn lanes_have_borders_links_signs_and_lights() {
    let (_folder, path) = written(&[scenario("abc123")]);
    let scenario = open(&path);
    let network = &scenario.network;
    let of_type = |name: &str| {
        let lanes = network.lanelets.iter();
        lanes
            .filter(|l| l.types.iter().any(|t| t.name() == name))
            .collect::<Vec<_>>()
    };
    let lanes = of_type("urban");
    assert_eq!(lanes.len(), 3);
    // Track 1 and lane 1 have one id; the track keeps it.
    assert_ne!(lanes[0].id, 1);
    assert_eq!(lanes[1].id, 2);
    let [right, left, after] = [0, 1, 2].map(|i| lanes[i]);
    assert_eq!(right.left.points[3], Point::new(30.0, 1.5));
    assert_eq!(right.right.points[3], Point::new(30.0, -1.5));
    assert_eq!(right.left.heights[3], 7.0);
    assert_eq!(left.left.points[0], Point::new(0.0, 5.5));
    assert_eq!(left.right.points[0], Point::new(0.0, 1.75));
    assert_eq!(right.left.marking, LineMarking::Dashed);
    assert_eq!(right.right.marking, LineMarking::Curb);
    assert_eq!(left.left.marking, LineMarking::SolidSolid);
    assert_eq!(right.adjacent_left.unwrap().id, left.id);
    assert_eq!(left.adjacent_right.unwrap().id, right.id);
    assert_eq!(right.successors, [after.id]);
    assert_eq!(after.predecessors, [right.id]);
    // As wide as the lane before.
    near(after.left.points[0].y, 1.5);
    let sign = |id: i64| network.signs.iter().find(|s| s.id == id).unwrap();
    let limit = sign(right.signs[0]);
    assert_eq!(
        (
            limit.elements[0].id.as_str(),
            limit.elements[0].values[0].as_str()
        ),
        ("R2-1", "11.176")
    );
    assert_eq!(right.signs, left.signs);
    assert_eq!(sign(after.signs[0]).elements[0].id, "R1-1");
    let light = &network.lights[0];
    assert_eq!(right.lights, [light.id]);
    assert_eq!(
        [11, 12].map(|step| light.color_at(step)),
        [SignalColor::Red, SignalColor::Green]
    );
    let ends = right.stop_line_ends().unwrap();
    assert_eq!(ends, (Point::new(90.0, 1.5), Point::new(90.0, -1.5)));
    let crosswalk = of_type("crosswalk");
    let along = crosswalk[0].left.points[1] - crosswalk[0].left.points[0];
    assert_eq!(
        (crosswalk.len(), along.x.abs(), along.y.abs()),
        (1, 0.0, 10.0)
    );
    assert!(messages(&scenario).contains("map_features/speed_bump: 1 ×"));
}

#[test]
fn one_of_many_is_opened_without_the_others() {
    let names = ["aa01", "bb02", "cc03"];
    let (folder, path) = written(&names.map(scenario));
    let file = "validation.tfrecord-00000-of-00150";
    assert_eq!(
        found(folder.path()),
        names.map(|name| format!("{file}#{name}"))
    );
    let entry = Entry::of_file(&part(&path, "bb02"));
    assert_eq!((entry.name.as_str(), entry.group.as_str()), ("bb02", file));
    assert!(entry.read().unwrap().header.benchmark_id.contains("bb02"));
    assert!(open(&part(&path, "3")).header.benchmark_id.contains("cc03"));
    let hashes = names.map(|name| open(&part(&path, name)).hash);
    assert!(
        hashes[0] != hashes[1]
            && hashes[1] == Entry::of_file(&part(&path, "bb02")).content_hash().unwrap()
    );
    let error = refused(&path);
    assert!(
        error.contains("3 scenarios; name one as") && error.contains("#aa01"),
        "{error}"
    );
    let error = refused(&part(&path, "dd04"));
    assert!(
        error.contains("no scenario `dd04`; it has aa01, bb02, cc03"),
        "{error}"
    );
    // The payload of the first record is damaged: the others open all the same.
    let mut bytes = std::fs::read(&path).unwrap();
    bytes[40] ^= 1;
    std::fs::write(&path, bytes).unwrap();
    assert!(
        open(&part(&path, "cc03"))
            .header
            .benchmark_id
            .contains("cc03")
    );
    let error = refused(&part(&path, "aa01"));
    assert!(error.contains("record 1: its checksum is wrong"), "{error}");
}

#[test]
fn what_is_wrong_is_named_with_its_record() {
    let (_folder, path) = written(&[scenario("a1"), scenario("b2")]);
    let whole = std::fs::read(&path).unwrap();
    let mut cut = whole.clone();
    cut.truncate(whole.len() - 5);
    std::fs::write(&path, &cut).unwrap();
    let error = refused(&part(&path, "a1"));
    assert!(
        error.contains("record 2: it has") && error.contains("truncated"),
        "{error}"
    );
    let mut lying = header(1 << 60);
    lying.extend([0; 100]);
    std::fs::write(&path, &lying).unwrap();
    let error = refused(&path);
    assert!(
        error.contains("record 1: it has 1152921504606846976 bytes"),
        "{error}"
    );
    std::fs::write(&path, file(&[b"no message".to_vec()])).unwrap();
    let error = refused(&path);
    assert!(
        error.contains("record 1: not a Scenario message"),
        "{error}"
    );
}
