//! The three tables of a recording in the shape of highD (Krajewski et al., ITSC 2018): a straight road along the x-axis,
//! y downwards, boxes by their upper left corner.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

use nalgebra::Rotation2;
use nearmiss_base::geometry::{Point, angle_between, normalize_angle};
use nearmiss_record::csv;
use nearmiss_scene::scenario::{LaneletNetwork, Motion, ObstacleType};

use super::{Recording, TableError, User, WrittenTables, number};

const TRACKS: [&str; 11] = [
    "frame",
    "id",
    "x",
    "y",
    "width",
    "height",
    "xVelocity",
    "yVelocity",
    "xAcceleration",
    "yAcceleration",
    "laneId",
];

const TRACKS_META: [&str; 13] = [
    "id",
    "width",
    "height",
    "initialFrame",
    "finalFrame",
    "numFrames",
    "class",
    "drivingDirection",
    "traveledDistance",
    "minXVelocity",
    "maxXVelocity",
    "meanXVelocity",
    "numLaneChanges",
];

const RECORDING_META: [&str; 15] = [
    "id",
    "frameRate",
    "locationId",
    "speedLimit",
    "month",
    "weekDay",
    "startTime",
    "duration",
    "totalDrivenDistance",
    "totalDrivenTime",
    "numVehicles",
    "numCars",
    "numTrucks",
    "upperLaneMarkings",
    "lowerLaneMarkings",
];

/// Who drives slower may stand in any direction, m/s.
const MOVING: f64 = 1.0;

/// A heading farther off the road is told, radians.
const ALONG: f64 = 0.01;

/// Of a recording whose road leads elsewhere, turned until it is along the x-axis.
pub fn write(recording: Recording, roads: &LaneletNetwork) -> Result<WrittenTables, TableError> {
    let axis = axis(&recording.users);
    let is_turned = axis.abs() > ALONG;
    let turn = Rotation2::new(if is_turned { -axis } else { 0.0 });
    let mut notes = Vec::new();
    if is_turned {
        notes.push(format!(
            "turned by {:.2}° about the origin, so that its road is along the x-axis",
            -axis.to_degrees()
        ));
    }
    let recording = &turned(recording, turn);
    let mut most = (0, 0.0_f64);
    for user in &recording.users {
        let direction = direction(user);
        for (_, motion) in &user.states {
            let off = angle_between(motion.pose.heading, direction).abs();
            if off > FRAC_PI_4 && motion.velocity.abs() > MOVING {
                let name = if user.is_ego {
                    "the ego".into()
                } else {
                    format!("obstacle {}", user.id)
                };
                let degrees = off.min(PI - off).to_degrees();
                return Err(TableError::Across { name, degrees });
            }
            most = (most.0 + usize::from(off > ALONG), most.1.max(off));
        }
    }
    if most.0 > 0 {
        notes.push(format!(
            "headings are along the road in this shape: {} rows are up to {:.1}° off it",
            most.0,
            most.1.to_degrees()
        ));
    }
    let markings = Markings::of(roads, turn);
    if markings.all().next().is_none() {
        notes.push(
            "no lane is straight along the x-axis: there are no lane markings, and laneId is 0"
                .into(),
        );
    }
    let is_other = |user: &&User| !matches!(user.kind, ObstacleType::Car | ObstacleType::Truck);
    match recording.users.iter().filter(is_other).count() {
        0 => {}
        count => notes.push(format!(
            "{count} road users are neither cars nor trucks, and written as the one that is nearer"
        )),
    }
    notes.push(
        "columns about others around a vehicle (dhw, thw, ttc, precedingId, …) are left out".into(),
    );
    notes.extend(recording.ego_in_words());
    let header = |names: &[&str]| names.iter().map(ToString::to_string).collect::<Vec<_>>();
    let tracks = recording.users.iter().flat_map(|user| {
        let states = user.states.iter();
        states.map(|(step, motion)| row(recording, user, *step, motion, &markings))
    });
    let users = recording.users.iter();
    let metas = users.map(|user| meta(recording, user, &markings));
    let about = about(recording, roads, &markings);
    Ok(WrittenTables {
        // What the tracks need comes first: a recording is never there without.
        files: vec![
            ("_recordingMeta.csv", csv([header(&RECORDING_META), about])),
            (
                "_tracksMeta.csv",
                csv(std::iter::once(header(&TRACKS_META)).chain(metas)),
            ),
            (
                "_tracks.csv",
                csv(std::iter::once(header(&TRACKS)).chain(tracks)),
            ),
        ],
        notes,
    })
}

/// Where the road leads on which all drive, in either direction: from -90° to 90° off the x-axis, radians.
fn axis(users: &[User]) -> f64 {
    let states = users.iter().flat_map(|user| &user.states);
    let moving = states.filter(|(_, motion)| motion.velocity.abs() > MOVING);
    let (mut x, mut y) = (0.0, 0.0);
    for (_, motion) in moving {
        // Twice the angle is the same in both directions.
        let (sin, cos) = (2.0 * motion.pose.heading).sin_cos();
        (x, y) = (x + cos, y + sin);
    }
    f64::atan2(y, x) / 2.0
}

fn turned(mut recording: Recording, turn: Rotation2<f64>) -> Recording {
    if turn.angle() == 0.0 {
        return recording;
    }
    let users = recording.users.iter_mut();
    for (_, motion) in users.flat_map(|user| &mut user.states) {
        motion.pose.position = turn * motion.pose.position;
        motion.pose.heading = normalize_angle(motion.pose.heading + turn.angle());
    }
    recording
}

/// Where a road user drives, radians: along the x-axis or against it.
fn direction(user: &User) -> f64 {
    let ends = user.states.first().zip(user.states.last());
    let moved = ends.map_or(0.0, |((_, a), (_, b))| {
        b.pose.position.x - a.pose.position.x
    });
    let heading = user.states.first().map_or(0.0, |(_, m)| m.pose.heading);
    let is_back = if moved.abs() > 0.5 {
        moved < 0.0
    } else {
        angle_between(heading, 0.0).abs() > FRAC_PI_2
    };
    if is_back { PI } else { 0.0 }
}

fn frame(recording: &Recording, step: i64) -> i64 {
    step - recording.steps.0 + 1
}

fn row(
    recording: &Recording,
    user: &User,
    step: i64,
    motion: &Motion,
    markings: &Markings,
) -> Vec<String> {
    let at = motion.pose.position;
    let (velocity, acceleration) = (motion.velocity_vector(), motion.acceleration_vector());
    let numbers = [
        at.x - user.length / 2.0,
        -at.y - user.width / 2.0,
        user.length,
        user.width,
        velocity.x,
        -velocity.y,
        acceleration.x,
        -acceleration.y,
    ];
    let mut row = vec![frame(recording, step).to_string(), user.id.to_string()];
    row.extend(numbers.map(number));
    row.push(markings.lane(at.y).to_string());
    row
}

fn meta(recording: &Recording, user: &User, markings: &Markings) -> Vec<String> {
    let frames: Vec<i64> = user
        .states
        .iter()
        .map(|(s, _)| frame(recording, *s))
        .collect();
    let (first, last) = (frames.first(), frames.last());
    let along: Vec<f64> = user
        .states
        .iter()
        .map(|(_, m)| m.velocity_vector().x.abs())
        .collect();
    let lanes: Vec<usize> = user
        .states
        .iter()
        .map(|(_, m)| markings.lane(m.pose.position.y))
        .collect();
    let changes = lanes.windows(2).filter(|pair| pair[0] != pair[1]).count();
    vec![
        user.id.to_string(),
        number(user.length),
        number(user.width),
        first.map_or(0, |f| *f).to_string(),
        last.map_or(0, |f| *f).to_string(),
        frames.len().to_string(),
        class(user.kind).to_string(),
        (if direction(user) == 0.0 { 2 } else { 1 }).to_string(),
        number(distance(user)),
        number(along.iter().copied().fold(f64::MAX, f64::min)),
        number(along.iter().copied().fold(0.0, f64::max)),
        number(along.iter().sum::<f64>() / along.len().max(1) as f64),
        changes.to_string(),
    ]
}

fn about(recording: &Recording, roads: &LaneletNetwork, markings: &Markings) -> Vec<String> {
    let users = &recording.users;
    let trucks = users.iter().filter(|u| class(u.kind) == "Truck").count();
    let seconds = |steps: i64| number(steps as f64 * recording.time_step);
    let driven: i64 = users.iter().map(|u| u.states.len() as i64 - 1).sum();
    let limit = roads.signs.iter().filter_map(|sign| sign.limit());
    let lines = |lines: &[f64]| {
        lines
            .iter()
            .map(|y| number(*y))
            .collect::<Vec<_>>()
            .join(";")
    };
    vec![
        "1".into(),
        number(1.0 / recording.time_step),
        "0".into(),
        // None has -1.
        number(limit.reduce(f64::min).unwrap_or(-1.0)),
        String::new(),
        String::new(),
        String::new(),
        seconds(recording.steps.1 - recording.steps.0 + 1),
        number(users.iter().map(distance).sum()),
        seconds(driven),
        users.len().to_string(),
        (users.len() - trucks).to_string(),
        trucks.to_string(),
        lines(&markings.upper),
        lines(&markings.lower),
    ]
}

fn class(kind: ObstacleType) -> &'static str {
    match kind {
        ObstacleType::Truck | ObstacleType::Bus | ObstacleType::Train => "Truck",
        _ => "Car",
    }
}

/// How far a road user drives along the road, metres.
fn distance(user: &User) -> f64 {
    let moved = user.states.first().zip(user.states.last());
    moved.map_or(0.0, |((_, a), (_, b))| {
        (b.pose.position.x - a.pose.position.x).abs()
    })
}

/// Lines of a road: those of lanes against the x-axis, which are the upper ones, and those along it. y downwards, in order.
#[derive(Default)]
struct Markings {
    upper: Vec<f64>,
    lower: Vec<f64>,
}

/// A line that is farther off is not along the axis, and one that is nearer to another one is the same, metres.
const SAME: f64 = 0.3;

impl Markings {
    fn of(roads: &LaneletNetwork, turn: Rotation2<f64>) -> Self {
        let mut markings = Self::default();
        for lanelet in &roads.lanelets {
            let sides = [&lanelet.left.points, &lanelet.right.points];
            let bounds = sides.map(|points| points.iter().map(|p| turn * p).collect());
            let lines = bounds.each_ref().map(|points: &Vec<Point>| {
                let first = points.first()?;
                let is_straight = points.iter().all(|p| (p.y - first.y).abs() < SAME);
                is_straight.then_some(-first.y)
            });
            let ends = bounds[0].first().zip(bounds[0].last());
            let ([Some(left), Some(right)], Some((from, to))) = (lines, ends) else {
                continue;
            };
            let side = if to.x < from.x {
                &mut markings.upper
            } else {
                &mut markings.lower
            };
            for line in [left, right] {
                if !side.iter().any(|known| (known - line).abs() < SAME) {
                    side.push(line);
                }
            }
        }
        markings.upper.sort_by(f64::total_cmp);
        markings.lower.sort_by(f64::total_cmp);
        markings
    }

    fn all(&self) -> impl Iterator<Item = f64> {
        self.upper.iter().chain(&self.lower).copied()
    }

    /// The number of the lane at a place, counted from the top with 1 above the first line; 0 where there are no lines.
    fn lane(&self, y: f64) -> usize {
        if self.all().next().is_none() {
            return 0;
        }
        1 + self.all().filter(|line| *line <= -y).count()
    }
}
