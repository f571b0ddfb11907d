//! Waymo Open Motion: scenario protos in TFRecord files, of which one is read without the others.

mod crc32c;
mod index;
mod lanes;
mod lights;
mod map;
#[rustfmt::skip]
mod messages;
mod tfrecord;
mod tracks;
mod unused;
mod widths;

use std::path::Path;

use prost::Message;

use super::assembly::{About, assemble, median};
use super::ids::Ids;
use super::report::Report;
use crate::address::Address;
use crate::commonroad::ReadError;
use crate::commonroad::builder::SourceLocation;
use crate::dispatch::{Format, Parts};
use messages::Scenario as Recorded;
use nearmiss_scene::scenario::{ContentHash, Scenario};
use tfrecord::Records;

/// The format.
pub struct Waymo;

impl Format for Waymo {
    fn recognises(&self, path: &Path, head: &[u8]) -> bool {
        // A damaged file says by its name alone what it is.
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        tfrecord::begins(head) || name.contains(".tfrecord")
    }

    fn parts(&self, path: &Path) -> Result<Parts, ReadError> {
        Ok(Parts::Named(index::of(path)?.names.clone()))
    }

    fn open(&self, address: &Address) -> Result<Scenario, ReadError> {
        let Address { file, part } = address;
        let index = index::of(file)?;
        let name = file.display();
        let report = |part: &str| Report::about(format!("{name}{part}"));
        let found = match part {
            Some(part) => index.record(part),
            None => index.only(),
        };
        let Some(record) = found else {
            let names = &index.names;
            let known: Vec<&str> = names.iter().take(NAMED).map(String::as_str).collect();
            let more = match names.len() - known.len() {
                0 => String::new(),
                more => format!(" and {more} more"),
            };
            let message = match part {
                _ if names.is_empty() => "no scenario in it".to_string(),
                Some(part) => format!("no scenario `{part}`; it has {}{more}", known.join(", ")),
                None => format!(
                    "{} scenarios; name one as {name}#{}: it has {}{more}",
                    names.len(),
                    known[0],
                    known.join(", ")
                ),
            };
            return Err(report("").fail(message));
        };
        let bytes = Records::open(file)?.payload(record)?;
        let shown = part.as_ref().map_or_else(String::new, |p| format!("#{p}"));
        read(&bytes, report(&shown), record.place)
    }
}

/// So many scenarios of a file are named in a message.
const NAMED: usize = 5;

/// Reads the scenario in a record.
fn read(bytes: &[u8], report: Report, place: usize) -> Result<Scenario, ReadError> {
    let recorded = Recorded::decode(bytes).map_err(|error| {
        let message = format!(
            "not a Scenario message, or damaged: {error}; of Waymo Open Motion the files under `scenario` are read"
        );
        report.at(tfrecord::record(place)).fail(message)
    })?;
    unused::count(bytes).tell(&report);
    let id = recorded.scenario_id.clone().unwrap_or_default();
    let dt = time_step(&report, &recorded)?;
    let feature_ids = recorded.map_features.iter().filter_map(|f| f.id);
    let track_ids = recorded.tracks.iter().filter_map(|t| t.id).map(i64::from);
    let mut ids = Ids::beyond(track_ids.chain(feature_ids));
    let tracks = tracks::read(&report, &recorded, &mut ids)?;
    let map = map::read(&report, &recorded, &mut ids)?;
    let letters = id.chars().filter(char::is_ascii_alphanumeric);
    let about = About {
        source: "Waymo Open Motion Dataset",
        benchmark_id: format!("USA_Waymo{}-1_1_T-1", letters.take(32).collect::<String>()),
        time_step_size: dt,
        tags: vec!["urban".into()],
        ego: tracks::ego(&report, &recorded),
        hash: ContentHash::digest(bytes),
    };
    assemble(report, about, map, tracks)
}

/// The time between two steps, seconds: clocks of recorders are off by microseconds, and steps are milliseconds.
fn time_step(report: &Report, recorded: &Recorded) -> Result<f64, ReadError> {
    let times = &recorded.timestamps_seconds;
    let at = report.at("timestamps_seconds");
    if times.len() < 2 {
        let message = format!("{} time stamps; at least 2 are needed", times.len());
        return Err(at.fail(message));
    }
    for time in times {
        at.number(*time)?;
    }
    let between: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let dt = (median(between.clone()) * 1e3).round() / 1e3;
    let off = between.iter().filter(|d| (*d - dt).abs() > dt / 4.0);
    match off.count() {
        0 => {}
        off => at.warn(format!(
            "{off} steps are not {dt} s after the one before; taken as such"
        )),
    }
    Ok(dt)
}
