//! Argoverse 2 motion forecasting: a Parquet file of tracks and a map in JSON beside it.

mod map;
mod table;

use std::collections::HashMap;
use std::path::Path;

use nearmiss_base::system;
use nearmiss_scene::scenario::plausibility::LATEST_STEP;
use nearmiss_scene::scenario::{ContentHash, ObstacleType, Scenario};

use super::assembly::{self, About, Ids, Map, assemble};
use super::{Report, whole_file};
use crate::commonroad::ReadError;
use crate::commonroad::builder::SourceLocation;
use crate::dispatch::{Address, Applies, Format};
use crate::recordings::assembly::{RecordedTrack, TrackState, signed_speed};
use crate::recordings::rows;
use table::{Table, Text};

pub use table::columns;

/// The format.
pub struct Argoverse;

/// No file of a scenario of eleven seconds is larger, bytes.
const LARGEST: u64 = 64 << 20;

/// Seconds between two steps, where the file does not tell.
const TIME_STEP: f64 = 0.1;

/// The vehicle that records: a Ford Fusion, length and width, metres.
const RECORDER_SIZE: (f64, f64) = (4.87, 1.85);

impl Format for Argoverse {
    fn recognises(&self, path: &Path, head: &[u8]) -> bool {
        table::is_one(path, head)
    }

    /// A damaged table may have been any.
    fn applies(&self, path: &Path, head: &[u8]) -> Applies {
        match columns(path, head) {
            Some(_) => Applies::Nothing,
            None => Applies::All,
        }
    }

    fn open(&self, address: &Address) -> Result<Scenario, ReadError> {
        let path = whole_file(address)?;
        let name = path.display().to_string();
        let report = Report::about(&name);
        let bytes = system::read_file(path, LARGEST).map_err(|e| ReadError::io(&name, &e))?;
        let table = Table::open(path, &bytes, &report)?;
        let rows = read(&report, &table)?;
        let dt = time_step(&report, &table)?;
        table.tell_unused();
        drop(table);
        let map = match map::find_map(path, &rows.scenario) {
            Some(file) => Some(map::Archive::read(&file)?),
            None => {
                let message = format!(
                    "no map: log_map_archive_{}.json is not beside it; the scenario has no lanes",
                    rows.scenario
                );
                report.at("").warn(message);
                None
            }
        };
        scenario(report, &bytes, dt, rows, map)
    }
}

fn scenario(
    report: Report,
    bytes: &[u8],
    dt: f64,
    rows: Rows,
    archive: Option<map::Archive>,
) -> Result<Scenario, ReadError> {
    let numbered = rows
        .tracks
        .iter()
        .filter_map(|t| t.name.parse::<i64>().ok());
    let features = archive.iter().flat_map(map::Archive::ids);
    let mut ids = Ids::beyond(numbered.clone().chain(features));
    numbered.for_each(|id| {
        ids.take(id);
    });
    let mut ego = None;
    let mut tracks = Vec::with_capacity(rows.tracks.len());
    for track in rows.tracks {
        let id = match track.name.parse::<i64>() {
            Ok(id) if id > 0 => id,
            _ => {
                let id = ids.fresh();
                let what = if track.is_recorder() {
                    ego = Some(id);
                    "the vehicle that recorded, `AV`,".to_string()
                } else {
                    format!("track `{}`", track.name)
                };
                report.note(format!("{what} is track {id}"));
                id
            }
        };
        if track.name == rows.focal {
            report.note(format!("track {id} is the focal track"));
        }
        tracks.push(track.recorded(id, RECORDER_SIZE));
    }
    let kinds = tracks.iter().filter(|t| Some(t.id) != ego).map(|t| t.kind);
    report.note(format!(
        "no sizes given; assumed by class: {}; the recording vehicle {} m × {} m",
        assembly::in_words(kinds.collect::<Vec<ObstacleType>>()),
        RECORDER_SIZE.0,
        RECORDER_SIZE.1
    ));
    if ego.is_none() {
        report.at("").warn("no track `AV`; no ego");
    }
    let (map, map_hash) = match archive {
        Some(archive) => (archive.map(&report, &mut ids)?, archive.hash),
        None => (Map::default(), ContentHash::digest(b"")),
    };
    let letters = rows.scenario.chars().filter(char::is_ascii_alphanumeric);
    let about = About {
        source: "Argoverse 2 Motion Forecasting Dataset",
        benchmark_id: format!(
            "USA_Argoverse{}-1_1_T-1",
            letters.take(32).collect::<String>()
        ),
        time_step_size: dt,
        tags: vec!["urban".into()],
        ego,
        hash: ContentHash::of_parts([bytes, &map_hash.bytes()[..]]),
    };
    assemble(report, about, map, tracks)
}

/// Nanoseconds in a second: the unit of time stamps.
const NANOSECONDS: f64 = 1e9;

/// The time between two steps, seconds, from when the recording starts and ends.
fn time_step(report: &Report, table: &Table<'_>) -> Result<f64, ReadError> {
    let said = (
        table.first_number("start_timestamp")?,
        table.first_number("end_timestamp")?,
        table.first_number("num_timestamps")?,
    );
    if let (Some(start), Some(end), Some(count)) = said
        && count > 1.0
    {
        let dt = (end - start) / NANOSECONDS / (count - 1.0);
        let rounded = (dt * 1e3).round() / 1e3;
        if rounded > 0.0 && rounded <= 1.0 {
            return Ok(rounded);
        }
        let message = format!("time stamps {dt} s apart; taken as {TIME_STEP} s");
        report.at("column start_timestamp").warn(message);
    }
    Ok(TIME_STEP)
}

/// The track of the vehicle that records.
const RECORDER_TRACK: &str = "AV";

/// The rows of a file.
struct Rows {
    /// The id of the scenario.
    pub scenario: String,
    /// The track whose future is to be forecast.
    pub focal: String,
    /// In the order in which they first appear.
    pub tracks: Vec<NamedTrack>,
}

/// A track under its name in the file.
struct NamedTrack {
    pub name: String,
    kind: ObstacleType,
    states: Vec<TrackState>,
}

impl NamedTrack {
    /// Whether it is that of the vehicle that records.
    pub fn is_recorder(&self) -> bool {
        self.name == RECORDER_TRACK
    }

    /// The track under an id of the scenario.
    pub fn recorded(self, id: i64, recorder: (f64, f64)) -> RecordedTrack {
        let (length, width) = if self.is_recorder() {
            recorder
        } else {
            assembly::default_size(self.kind)
        };
        RecordedTrack {
            shape: None,
            is_static: false,
            id,
            kind: self.kind,
            length,
            width,
            states: self.states,
        }
    }
}

/// Reads all rows.
fn read(report: &Report, table: &Table<'_>) -> Result<Rows, ReadError> {
    let names = table.needed_texts("track_id")?;
    let kinds = table.needed_texts("object_type")?;
    let steps = table.needed_numbers("timestep")?;
    let (x, y) = (
        table.needed_numbers("position_x")?,
        table.needed_numbers("position_y")?,
    );
    let headings = table.needed_numbers("heading")?;
    let velocities = (table.numbers("velocity_x")?, table.numbers("velocity_y")?);
    let first = |name| Ok::<_, ReadError>(table.first_text(name)?.unwrap_or_default());
    let (scenario, focal) = (first("scenario_id")?, first("focal_track_id")?);
    let mut places: HashMap<&str, usize> = HashMap::new();
    let mut tracks: Vec<NamedTrack> = Vec::new();
    let mut last: Option<(&Text, usize)> = None;
    for (row, name) in names.iter().enumerate() {
        // Rows are counted from 1 in messages, as other tables do.
        let at = || report.at(format!("row {}", row + 1));
        let step = steps[row];
        if step.fract() != 0.0 || step.abs() > LATEST_STEP as f64 {
            return Err(at().fail(format!("`timestep` is {step}")));
        }
        let plain = |value: f64| {
            if value.abs() < 1e6 {
                Ok(value)
            } else {
                at().number(value)
            }
        };
        let heading = plain(headings[row])?;
        let velocity = match &velocities {
            (Some(x), Some(y)) => Some(signed_speed(heading, plain(x[row])?, plain(y[row])?)),
            _ => None,
        };
        let (x, y) = (plain(x[row])?, plain(y[row])?);
        let place = match last.filter(|(before, _)| before.is_same(name)) {
            Some((_, place)) => place,
            None => *places.entry(name.as_str()).or_insert_with(|| {
                tracks.push(NamedTrack {
                    name: name.as_str().to_string(),
                    kind: kind(kinds[row].as_str()),
                    states: Vec::new(),
                });
                tracks.len() - 1
            }),
        };
        last = Some((name, place));
        tracks[place].states.push(TrackState {
            step: step as i64,
            position: at_point(x, y, at)?,
            heading,
            velocity,
            acceleration: None,
        });
    }
    for track in &mut tracks {
        let name = || format!("track {}", track.name);
        rows::once(report, name, &mut track.states, |s| s.step, |s| s.position);
    }
    Ok(Rows {
        scenario,
        focal,
        tracks,
    })
}

fn at_point<'r>(
    x: f64,
    y: f64,
    at: impl Fn() -> crate::recordings::At<'r>,
) -> Result<nearmiss_base::geometry::Point, ReadError> {
    if x.abs() < 1e6 && y.abs() < 1e6 {
        Ok(nearmiss_base::geometry::Point::new(x, y))
    } else {
        at().point(x, y)
    }
}

/// The kind of a class.
fn kind(class: &str) -> ObstacleType {
    match class {
        "vehicle" => ObstacleType::Car,
        "bus" => ObstacleType::Bus,
        "pedestrian" => ObstacleType::Pedestrian,
        "motorcyclist" => ObstacleType::Motorcycle,
        "cyclist" | "riderless_bicycle" => ObstacleType::Bicycle,
        "construction" => ObstacleType::ConstructionZone,
        _ => ObstacleType::Unknown,
    }
}
