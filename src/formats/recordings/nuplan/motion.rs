//! Where everyone is at the sweeps of a log: the vehicle that records by its poses, the others by their boxes.

use std::collections::{BTreeMap, HashMap};
use std::mem::size_of;

use nearmiss_base::geometry::{Point, Vector};
use nearmiss_scene::scenario::ObstacleType;

use super::log::{Clock, EGO, Log, id_of, kind};
use super::sqlite::{Database, Record, Token};
use crate::commonroad::ReadError;
use crate::commonroad::builder::SourceLocation;
use crate::recordings::assembly::{
    self, RecordedTrack, TRUCK_LENGTH, TrackState, median, signed_speed,
};
use crate::recordings::{Report, rows};

/// Length and width of the vehicle that records, metres: a Chrysler Pacifica, by the data set's devkit.
const VEHICLE: (f64, f64) = (4.049 + 1.127, 2.297);

/// Its middle ahead of its rear axle, which poses are of, metres.
const AXLE_TO_MIDDLE: f64 = (4.049 - 1.127) / 2.0;

/// An object that is farther from its middle place than this moves, metres.
const MOVES: f64 = 1.0;

/// The place of a point in a scenario.
fn place(log: &Log, (x, y): (f64, f64), row: &Record<'_>) -> Result<Point, ReadError> {
    let (x, y) = (x - log.origin.0, y - log.origin.1);
    if x.abs() < 1e6 && y.abs() < 1e6 {
        Ok(Point::new(x, y))
    } else {
        row.at(1).point(x, y)
    }
}

/// The states of the vehicle that records.
///
/// # Errors
/// A pose is missing or damaged.
pub fn recorder(database: &Database, clock: &Clock<'_>) -> Result<RecordedTrack, ReadError> {
    let log = clock.log;
    let columns = [
        "token",
        "x",
        "y",
        "qw",
        "qx",
        "qy",
        "qz",
        "?vx",
        "?vy",
        "?angular_rate_z",
    ];
    let query = database.query("ego_pose", &columns, "WHERE token = ?1")?;
    let mut states = Vec::with_capacity(clock.sweeps.len());
    for (sweep, step) in &clock.sweeps {
        let sweep = &log.sweeps[*sweep];
        let mut found = None;
        query.each([sweep.pose.to_be_bytes()], &mut |row| {
            let heading = heading(row)?;
            let (sin, cos) = heading.sin_cos();
            let x = row.number(1)? + AXLE_TO_MIDDLE * cos;
            let y = row.number(2)? + AXLE_TO_MIDDLE * sin;
            let velocity = match (row.optional_number(7)?, row.optional_number(8)?) {
                (Some(ahead), Some(left)) => {
                    // In the vehicle's frame; the middle turns around the axle.
                    let turn = row.optional_number(9)?.unwrap_or(0.0);
                    Some(signed_speed(0.0, ahead, left + turn * AXLE_TO_MIDDLE))
                }
                _ => None,
            };
            found = Some(TrackState {
                step: *step,
                position: place(log, (x, y), row)?,
                heading,
                velocity,
                acceleration: None,
            });
            Ok(())
        })?;
        states.push(found.ok_or_else(|| {
            database.fail(format!(
                "table lidar_pc, row {:016x}: its ego_pose {:016x} is missing",
                sweep.token, sweep.pose
            ))
        })?);
    }
    Ok(RecordedTrack {
        id: EGO,
        kind: ObstacleType::Car,
        length: VEHICLE.0,
        width: VEHICLE.1,
        shape: None,
        is_static: false,
        states,
    })
}

/// Where the vehicle's front is turned to, seen from above.
fn heading(row: &Record<'_>) -> Result<f64, ReadError> {
    let [w, x, y, z] = [3, 4, 5, 6].map(|column| row.number(column));
    let (w, x, y, z) = (w?, x?, y?, z?);
    let (along, across) = (w * w + x * x - y * y - z * z, 2.0 * (x * y + w * z));
    if along.hypot(across) < 0.1 {
        let message = "the quaternion (qw, qx, qy, qz) is no heading";
        return Err(row.at(3).fail(message));
    }
    Ok(across.atan2(along))
}

/// A box of a track.
struct TrackBox {
    step: i64,
    position: Point,
    heading: f64,
    velocity: Option<f64>,
    size: (f64, f64),
}

const BOX: [&str; 9] = [
    "token",
    "x",
    "y",
    "yaw",
    "?vx",
    "?vy",
    "?length",
    "?width",
    "track_token",
];

/// Everyone else, by the places of their tracks in the log.
///
/// # Errors
/// A box is damaged.
pub fn others(
    database: &Database,
    clock: &Clock<'_>,
    report: &Report,
) -> Result<Vec<RecordedTrack>, ReadError> {
    let log = clock.log;
    let mut seen: BTreeMap<usize, Vec<TrackBox>> = BTreeMap::new();
    let mut unknown = 0;
    log.boxes
        .each(database, "lidar_box", &BOX, clock, &mut |row, step| {
            let Some(track) = log.by_track.get(&row.token(8)?) else {
                unknown += 1;
                return Ok(());
            };
            let heading = row.number(3)?;
            let velocity = match (row.optional_number(4)?, row.optional_number(5)?) {
                (Some(x), Some(y)) => Some(signed_speed(heading, x, y)),
                _ => None,
            };
            let size = |column| row.optional_number(column).map(Option::unwrap_or_default);
            seen.entry(*track).or_default().push(TrackBox {
                step,
                position: place(log, (row.number(1)?, row.number(2)?), row)?,
                heading,
                velocity,
                size: (size(6)?, size(7)?),
            });
            Ok(())
        })?;
    if unknown > 0 {
        let message = format!("{unknown} boxes of no row in table track left out");
        report.at("table lidar_box").warn(message);
    }
    let mut assumed = Vec::new();
    let mut long = 0;
    let tracks = seen
        .into_iter()
        .map(|(place, boxes)| {
            let track = track(report, log, place, boxes, &mut assumed);
            long += usize::from(track.kind == ObstacleType::Truck);
            track
        })
        .collect();
    report.note_count(long, |n| {
        format!(
            "vehicles longer than {TRUCK_LENGTH} m are taken as trucks, as the data set does not tell: {n}"
        )
    });
    if !assumed.is_empty() {
        report.note(format!(
            "tracks without a size: {}; assumed by class: {}",
            assumed.len(),
            assembly::in_words(assumed)
        ));
    }
    Ok(tracks)
}

fn track(
    report: &Report,
    log: &Log,
    place: usize,
    mut boxes: Vec<TrackBox>,
    assumed: &mut Vec<ObstacleType>,
) -> RecordedTrack {
    let name = || format!("track {}", id_of(place));
    rows::once(report, name, &mut boxes, |s| s.step, |s| s.position);
    let said = &log.tracks[place];
    let mut kind = kind(&said.category);
    let of_boxes = |each: fn(&TrackBox) -> f64| median(boxes.iter().map(each).collect());
    let usable = |size: Option<f64>| size.filter(|size| *size > 0.0);
    let length = usable(said.size.0).or_else(|| usable(Some(of_boxes(|seen| seen.size.0))));
    let width = usable(said.size.1).or_else(|| usable(Some(of_boxes(|seen| seen.size.1))));
    let (length, width) = match (length, width) {
        (Some(length), Some(width)) => (length, width),
        _ => {
            assumed.push(kind);
            assembly::default_size(kind)
        }
    };
    if kind == ObstacleType::Car && length > TRUCK_LENGTH {
        kind = ObstacleType::Truck;
    }
    let middle = Point::new(
        of_boxes(|seen| seen.position.x),
        of_boxes(|seen| seen.position.y),
    );
    let moves = |seen: &TrackBox| -> bool {
        let off: Vector = seen.position - middle;
        off.norm() > MOVES
    };
    let is_static = match kind {
        ObstacleType::ConstructionZone | ObstacleType::RoadBoundary => true,
        ObstacleType::Unknown => !boxes.iter().any(moves),
        _ => false,
    };
    let states = match (is_static, boxes.get(boxes.len() / 2)) {
        (true, Some(seen)) => vec![TrackState {
            step: 0,
            position: middle,
            heading: seen.heading,
            velocity: Some(0.0),
            acceleration: None,
        }],
        _ => {
            let states = boxes.iter().map(|seen| TrackState {
                step: seen.step,
                position: seen.position,
                heading: seen.heading,
                velocity: seen.velocity,
                acceleration: None,
            });
            states.collect()
        }
    };
    RecordedTrack {
        id: id_of(place),
        kind,
        length,
        width,
        shape: None,
        is_static,
        states,
    }
}

/// The column that names the sweep of a row.
const SWEEP: &str = "lidar_pc_token";

/// Where the rows of each sweep are.
#[derive(Debug)]
pub enum SweepRows {
    /// An index of the file finds them.
    Indexed,
    /// From one row to another, by the places of sweeps.
    Runs(Vec<Vec<(i64, i64)>>),
}

impl SweepRows {
    /// Of a table, which may be missing; `sweeps` are the places of sweeps.
    ///
    /// # Errors
    /// The table is damaged.
    pub fn find(
        database: &Database,
        table: &str,
        sweeps: &HashMap<Token, usize>,
    ) -> Result<Self, ReadError> {
        if database.has_index(table, SWEEP) {
            return Ok(Self::Indexed);
        }
        let mut runs = vec![Vec::new(); sweeps.len()];
        if !database.has(table) {
            return Ok(Self::Runs(runs));
        }
        database.each(table, &["rowid", SWEEP], &mut |row| {
            let Some(place) = sweeps.get(&row.token(1)?) else {
                return Ok(());
            };
            let number = row.integer(0)?;
            let runs: &mut Vec<(i64, i64)> = &mut runs[*place];
            match runs.last_mut() {
                Some((_, last)) if last.checked_add(1) == Some(number) => *last = number,
                _ => runs.push((number, number)),
            }
            Ok(())
        })?;
        Ok(Self::Runs(runs))
    }

    /// Bytes.
    pub fn size(&self) -> usize {
        match self {
            Self::Indexed => 0,
            Self::Runs(runs) => {
                let each = runs
                    .iter()
                    .map(|runs| size_of::<Vec<()>>() + 16 * runs.capacity());
                each.sum()
            }
        }
    }

    /// Gives the rows of the sweeps of a clock to `take`, with their steps.
    ///
    /// # Errors
    /// The table is missing or damaged, or `take` refuses a row.
    pub fn each(
        &self,
        database: &Database,
        table: &str,
        columns: &[&str],
        clock: &Clock<'_>,
        take: &mut dyn FnMut(&Record<'_>, i64) -> Result<(), ReadError>,
    ) -> Result<(), ReadError> {
        match self {
            Self::Indexed => {
                let query = database.query(table, columns, &format!("WHERE {SWEEP} = ?1"))?;
                for (place, step) in &clock.sweeps {
                    let token = clock.log.sweeps[*place].token.to_be_bytes();
                    query.each([token], &mut |row| take(row, *step))?;
                }
            }
            Self::Runs(runs) => {
                let query = database.query(table, columns, "WHERE rowid BETWEEN ?1 AND ?2")?;
                for (place, step) in &clock.sweeps {
                    for (first, last) in &runs[*place] {
                        query.each([first, last], &mut |row| take(row, *step))?;
                    }
                }
            }
        }
        Ok(())
    }
}
