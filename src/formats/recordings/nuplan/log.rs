//! What a log says about itself: its sweeps, tracks and scenes, read once for all windows of it.

use std::collections::HashMap;
use std::mem::size_of;
use std::path::Path;
use std::sync::Arc;

use nearmiss_base::system::FileCache;
use nearmiss_scene::scenario::ObstacleType;
use nearmiss_scene::scenario::plausibility::{LATEST_STEP, refused_time_step};

use super::motion::SweepRows;
use super::sqlite::{Database, MAGIC, TableColumns, Token, first_names};
use crate::commonroad::builder::SourceLocation;
use crate::commonroad::{ReadError, beginning_of_file};
use crate::recordings::assembly::median;
use crate::recordings::{Report, has_extension};

/// Logs that are kept for other windows of them, bytes.
const MAX_CACHED: usize = 128 << 20;

static LOGS: FileCache<Log> = FileCache::new(MAX_CACHED);

/// The vehicle that records has this id; tracks have those after it.
pub const EGO: i64 = 1;

/// A sweep of the lidar, for which there are boxes.
#[derive(Debug, Clone, Copy)]
pub struct Sweep {
    pub token: Token,
    /// Microseconds.
    pub time: i64,
    /// The row of `ego_pose`.
    pub pose: Token,
    pub scene: Option<Token>,
}

/// A tracked object.
#[derive(Debug, Clone)]
pub struct Track {
    pub token: Token,
    /// As the data set calls it.
    pub category: String,
    /// Length and width, metres.
    pub size: (Option<f64>, Option<f64>),
}

/// A log without its boxes.
#[derive(Debug)]
pub struct Log {
    /// The name of its map, by which folders of maps are called.
    pub map: String,
    /// The name of its place; some logs tell the map only by it.
    pub location: String,
    /// By time.
    pub sweeps: Vec<Sweep>,
    /// Places in [`sweeps`](Self::sweeps).
    pub by_sweep: HashMap<Token, usize>,
    /// In the order of the file.
    pub tracks: Vec<Track>,
    /// Places in [`tracks`](Self::tracks).
    pub by_track: HashMap<Token, usize>,
    pub scenes: Vec<(Token, String)>,
    /// Between two sweeps, seconds.
    pub time_step: f64,
    /// East and north of what coordinates are relative to, metres.
    pub origin: (f64, f64),
    /// The reference system of its coordinates.
    pub system: Option<i64>,
    /// The rows of `lidar_box`.
    pub boxes: SweepRows,
    /// The rows of `traffic_light_status`.
    pub lights: SweepRows,
    /// The columns that were asked for.
    pub asked: TableColumns,
}

/// A log, read anew if it changed.
///
/// # Errors
/// A table is missing or damaged: with its row and column.
pub fn open_log(path: &Path) -> Result<Arc<Log>, ReadError> {
    LOGS.get(&[path], || {
        let log = Log::read(&Database::open(path)?)?;
        let size = log.size();
        Ok((log, size))
    })
}

impl Log {
    fn read(database: &Database) -> Result<Self, ReadError> {
        let (mut map, mut location) = (String::new(), String::new());
        let about = ["token", "?map_version", "?location"];
        database.each("log", &about, &mut |row| {
            let name = row.text(1);
            map = name.strip_suffix(".gpkg").unwrap_or(&name).to_string();
            location = row.text(2);
            Ok(())
        })?;
        let mut sweeps = Vec::new();
        let columns = ["token", "timestamp", "ego_pose_token", "?scene_token"];
        database.each("lidar_pc", &columns, &mut |row| {
            let time = row.integer(1)?;
            row.at(1).number(time as f64 / 1e7)?;
            sweeps.push(Sweep {
                token: row.token(0)?,
                time,
                pose: row.token(2)?,
                scene: row.optional_token(3)?,
            });
            Ok(())
        })?;
        sweeps.sort_by_key(|sweep| sweep.time);
        let [first, .., _] = sweeps[..] else {
            let count = sweeps.len();
            return Err(database.fail(format!(
                "{count} sweeps in table lidar_pc; at least 2 are needed"
            )));
        };
        let between = sweeps
            .windows(2)
            .map(|pair| (pair[1].time - pair[0].time) as f64 / 1e6);
        // Clocks of recorders are off by microseconds, and steps are milliseconds.
        let time_step = (median(between.collect()) * 1e3).round() / 1e3;
        let span = (sweeps[sweeps.len() - 1].time - first.time) as f64 / 1e6;
        if let Some(why) = refused_time_step(time_step) {
            let message = format!("table lidar_pc: the time step `{time_step}` {why}");
            return Err(database.fail(message));
        }
        if span / time_step > LATEST_STEP as f64 {
            let message =
                format!("table lidar_pc: {span} s in steps of {time_step} s are too many");
            return Err(database.fail(message));
        }
        let (tracks, scenes) = (tracks(database)?, scenes(database)?);
        let (origin, system) = origin(database, &first)?;
        let by_sweep = sweeps.iter().map(|sweep| sweep.token).zip(0..).collect();
        let boxes = SweepRows::find(database, "lidar_box", &by_sweep)?;
        let lights = SweepRows::find(database, "traffic_light_status", &by_sweep)?;
        Ok(Self {
            map,
            location,
            boxes,
            lights,
            asked: database.asked(),
            by_sweep,
            by_track: tracks.iter().map(|track| track.token).zip(0..).collect(),
            time_step,
            sweeps,
            tracks,
            scenes,
            origin,
            system,
        })
    }

    /// Bytes.
    fn size(&self) -> usize {
        let keys = size_of::<(Token, usize)>();
        self.sweeps.len() * (size_of::<Sweep>() + keys)
            + self.boxes.size()
            + self.lights.size()
            + self.tracks.len() * (size_of::<Track>() + keys + 16)
    }

    /// When a sweep is, seconds from the first one.
    pub fn seconds(&self, sweep: usize) -> f64 {
        (self.sweeps[sweep].time - self.sweeps[0].time) as f64 / 1e6
    }

    /// How long it is, seconds.
    pub fn duration(&self) -> f64 {
        self.seconds(self.sweeps.len() - 1)
    }

    /// The sweeps from one time to another, seconds from the first one, and those at their rims.
    pub fn between(&self, from: f64, to: f64) -> Vec<usize> {
        let half = self.time_step / 2.0;
        let all = 0..self.sweeps.len();
        all.filter(|sweep| (from - half..=to + half).contains(&self.seconds(*sweep)))
            .collect()
    }
}

/// The id of a track in scenarios.
pub fn id_of(track: usize) -> i64 {
    EGO + 1 + i64::try_from(track).unwrap_or(i64::MAX / 4)
}

/// The kind of a category, of which all but the first three stand.
pub fn kind(category: &str) -> ObstacleType {
    match category {
        "vehicle" => ObstacleType::Car,
        "bicycle" => ObstacleType::Bicycle,
        "pedestrian" => ObstacleType::Pedestrian,
        "traffic_cone" | "czone_sign" => ObstacleType::ConstructionZone,
        "barrier" => ObstacleType::RoadBoundary,
        _ => ObstacleType::Unknown,
    }
}

fn tracks(database: &Database) -> Result<Vec<Track>, ReadError> {
    let mut categories = HashMap::new();
    database.each("category", &["token", "name"], &mut |row| {
        categories.insert(row.token(0)?, row.text(1));
        Ok(())
    })?;
    let mut tracks = Vec::new();
    let columns = ["token", "category_token", "?length", "?width"];
    // Their numbers are those of their rows; an index has another order.
    let query = database.query("track", &columns, "ORDER BY rowid")?;
    query.each([], &mut |row| {
        let category = row
            .optional_token(1)?
            .and_then(|token| categories.get(&token));
        tracks.push(Track {
            token: row.token(0)?,
            category: category.cloned().unwrap_or_default(),
            size: (row.optional_number(2)?, row.optional_number(3)?),
        });
        Ok(())
    })?;
    Ok(tracks)
}

fn scenes(database: &Database) -> Result<Vec<(Token, String)>, ReadError> {
    let mut scenes = Vec::new();
    if database.has("scene") {
        database.each("scene", &["token", "?name"], &mut |row| {
            scenes.push((row.token(0)?, row.text(1)));
            Ok(())
        })?;
    }
    Ok(scenes)
}

/// A whole kilometre near the beginning: coordinates of UTM are large.
const KILOMETRE: f64 = 1000.0;

fn origin(database: &Database, first: &Sweep) -> Result<((f64, f64), Option<i64>), ReadError> {
    let (mut origin, mut system) = ((0.0, 0.0), None);
    let columns = &["token", "x", "y", "?epsg"];
    database.with_token("ego_pose", columns, "token", first.pose, &mut |row| {
        let round = |value: f64| (value / KILOMETRE).floor() * KILOMETRE;
        origin = (round(row.number(1)?), round(row.number(2)?));
        system = row.optional_whole(3)?;
        Ok(())
    })?;
    Ok((origin, system))
}

/// Sweeps with the steps that they are at.
pub struct Clock<'l> {
    pub log: &'l Log,
    /// Places in the log, and steps; each step once.
    pub sweeps: Vec<(usize, i64)>,
    /// Sweeps of which the step had one already.
    pub twice: usize,
    /// Sweeps that are more than a quarter of a step off.
    pub off: usize,
}

impl<'l> Clock<'l> {
    /// Of sweeps in order; the first one is at step 0, and one takes so many seconds.
    pub fn new(log: &'l Log, sweeps: &[usize], time_step: f64) -> Self {
        let start = sweeps.first().map_or(0.0, |first| log.seconds(*first));
        let mut clock = Self {
            log,
            sweeps: Vec::with_capacity(sweeps.len()),
            twice: 0,
            off: 0,
        };
        for sweep in sweeps {
            let at = (log.seconds(*sweep) - start) / time_step;
            let step = at.round();
            if clock
                .sweeps
                .last()
                .is_some_and(|(_, last)| step as i64 <= *last)
            {
                clock.twice += 1;
                continue;
            }
            clock.off += usize::from((at - step).abs() > 0.25);
            clock.sweeps.push((*sweep, step as i64));
        }
        clock
    }

    /// The last step.
    pub fn last(&self) -> i64 {
        self.sweeps.last().map_or(0, |(_, step)| *step)
    }

    /// Says what is odd about it.
    pub fn report_to(&self, report: &Report) {
        let missing = usize::try_from(self.last() + 1)
            .unwrap_or(0)
            .saturating_sub(self.sweeps.len());
        let at = report.at("table lidar_pc");
        if self.off > 0 {
            at.warn(format!(
                "{} sweeps are not on a grid of {} s; taken as at the nearest step",
                self.off, self.log.time_step
            ));
        }
        if self.twice + missing > 0 {
            at.warn(format!(
                "{missing} steps of {} s have no sweep, and {} have two, of which the first is used",
                self.log.time_step, self.twice
            ));
        }
    }
}

/// What a SQLite file is.
pub enum Evidence {
    /// A log.
    Log,
    /// Its tables cannot be read.
    Damaged(ReadError),
    /// A GeoPackage, such as a map.
    Map,
    /// Answers that this program keeps.
    Store,
    /// A bag of ROS 2.
    Bag,
    /// Something else with these tables.
    Other(Vec<String>),
}

/// Tables that a log has, and hardly another file has all of.
const TABLES: [&str; 3] = ["lidar_pc", "ego_pose", "lidar_box"];

/// Tables of the answers that this program keeps.
const OWN: [&str; 2] = ["runs", "batches"];

/// Tables of a bag of ROS 2.
const BAG: [&str; 2] = ["topics", "messages"];

/// Whether a file is named or begins like one, also if it is none: what is wrong with it is said here.
pub fn is_named_or_begins_so(path: &Path, head: &[u8]) -> bool {
    // XML and the like under another name is read as what it is.
    let text = head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(head);
    let is_xml = text.trim_ascii_start().starts_with(b"<");
    let named = has_extension(path, "db") || has_extension(path, "gpkg");
    head.starts_with(MAGIC) || named && !is_xml
}

/// What a SQLite file is.
pub fn database_kind(path: &Path) -> Evidence {
    let database = match Database::open(path) {
        Ok(database) => database,
        Err(error) => return Evidence::Damaged(error),
    };
    if TABLES.iter().all(|table| database.has(table)) {
        return Evidence::Log;
    }
    if database.has("gpkg_contents") {
        Evidence::Map
    } else if OWN.iter().all(|table| database.has(table)) {
        Evidence::Store
    } else if BAG.iter().all(|table| database.has(table)) {
        Evidence::Bag
    } else {
        Evidence::Other(database.tables().to_vec())
    }
}

/// Refuses what is no log, and says what it is.
pub fn check(path: &Path) -> Result<(), ReadError> {
    let report = Report::about(path.display().to_string());
    let wants =
        "a nuPlan log is a SQLite file with the tables lidar_pc, ego_pose, lidar_box and others";
    let head = beginning_of_file(path, MAGIC.len())
        .map_err(|error| report.fail(format!("{error}; {wants}")))?;
    if !head.starts_with(MAGIC) {
        return Err(report.fail(format!("not a SQLite file; {wants}")));
    }
    let message = match database_kind(path) {
        Evidence::Log => return Ok(()),
        Evidence::Damaged(error) => return Err(error),
        Evidence::Map => {
            "a GeoPackage, not a recording; name a nuPlan log (`*.db`), which finds its map where `nearmiss help scenarios` says"
                .to_string()
        }
        Evidence::Store => {
            "a store of answers of nearmiss, not a recording; `nearmiss report` reads it".into()
        }
        Evidence::Bag => {
            "a bag of ROS 2, not a scenario; `nearmiss help scenarios` lists the formats that are read".into()
        }
        Evidence::Other(tables) if tables.is_empty() => {
            format!("a SQLite file without tables; {wants}")
        }
        Evidence::Other(tables) => {
            format!("a SQLite file with the tables {}; {wants}", first_names(&tables))
        }
    };
    Err(report.fail(message))
}
