//! What a log says about itself: its sweeps, tracks and scenes, read once for all windows of it.

use std::collections::HashMap;
use std::mem::size_of;
use std::path::Path;
use std::sync::Arc;

use super::record::Token;
use super::sqlite::{Asked, Database};
use super::sweep_rows::SweepRows;
use crate::commonroad::ReadError;
use crate::recordings::assembly::median;
use nearmiss_base::system::FileCache;
use nearmiss_scene::scenario::ObstacleType;
use nearmiss_scene::scenario::plausibility::limits::{LATEST_STEP, refused_time_step};

/// Logs that are kept for other windows of them, bytes.
const KEPT: usize = 128 << 20;

static LOGS: FileCache<Log> = FileCache::new(KEPT);

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

/// Someone who is tracked.
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
    pub asked: Asked,
}

/// A log, read anew if it changed.
///
/// # Errors
/// A table is missing or damaged: with its row and column.
pub fn of(path: &Path) -> Result<Arc<Log>, ReadError> {
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
            let time = row.whole(1)?;
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
