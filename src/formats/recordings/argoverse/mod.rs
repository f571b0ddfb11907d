//! Argoverse 2 motion forecasting: a Parquet file of tracks and a map in JSON beside it.

mod map;
mod pages;
mod table;
mod tracks;

use std::path::Path;

use super::assembly::{About, Map, assemble};
use super::ids::Ids;
use super::report::Report;
use super::{sizes, whole_file};
use crate::address::Address;
use crate::commonroad::ReadError;
use crate::commonroad::builder::SourceLocation;
use crate::dispatch::{Format, Parts};
use nearmiss_base::system;
use nearmiss_scene::scenario::{ContentHash, ObstacleType, Scenario};
use table::Table;
pub use table::columns;

/// The format.
pub struct Argoverse;

/// No file of a scenario of eleven seconds is larger, bytes.
const LARGEST: u64 = 64 << 20;

/// Seconds between two steps, where the file does not tell.
const TIME_STEP: f64 = 0.1;

/// The vehicle that records: a Ford Fusion, length and width, metres.
const RECORDER: (f64, f64) = (4.87, 1.85);

impl Format for Argoverse {
    fn recognises(&self, path: &Path, head: &[u8]) -> bool {
        table::is_one(path, head)
    }

    fn parts(&self, _: &Path) -> Result<Parts, ReadError> {
        Ok(Parts::One)
    }

    fn open(&self, address: &Address) -> Result<Scenario, ReadError> {
        let path = whole_file(address)?;
        let name = path.display().to_string();
        let report = Report::about(&name);
        let bytes = system::read_file(path, LARGEST).map_err(|e| ReadError::io(&name, &e))?;
        let table = Table::open(path, &bytes, &report)?;
        let rows = tracks::read(&report, &table)?;
        let dt = time_step(&report, &table)?;
        table.tell_unused();
        drop(table);
        let map = match map::beside(path, &rows.scenario) {
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
    rows: tracks::Rows,
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
        tracks.push(track.recorded(id, RECORDER));
    }
    let kinds = tracks.iter().filter(|t| Some(t.id) != ego).map(|t| t.kind);
    report.note(format!(
        "no sizes given; assumed by class: {}; the recording vehicle {} m × {} m",
        sizes::in_words(kinds.collect::<Vec<ObstacleType>>()),
        RECORDER.0,
        RECORDER.1
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
