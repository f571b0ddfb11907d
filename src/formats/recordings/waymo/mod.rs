//! Waymo Open Motion: scenario protos in TFRecord files, of which one is read without the others.

mod lanes;
mod map;
#[rustfmt::skip]
mod messages;
mod tfrecord;
mod tracks;

use std::path::Path;

use nearmiss_scene::scenario::{ContentHash, Scenario};
use prost::Message;

use super::assembly::{About, Ids, assemble, median};
use super::report::Report;
use crate::commonroad::ReadError;
use crate::commonroad::builder::SourceLocation;
use crate::commonroad::wire::{Fields, Value};
use crate::dispatch::{Address, Format, Parts};
use crate::recordings::report::Leftovers;
use FieldUse::{Unused, Used};
use messages::Scenario as Recorded;
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
        Ok(Parts::Named(tfrecord::scenario_index(path)?.names.clone()))
    }

    fn open(&self, address: &Address) -> Result<Scenario, ReadError> {
        let Address { file, part } = address;
        let index = tfrecord::scenario_index(file)?;
        let name = file.display();
        let report = |part: &str| Report::about(format!("{name}{part}"));
        let found = match part {
            Some(part) => index.record(part),
            None => index.only(),
        };
        let Some(record) = found else {
            let names = &index.names;
            let known: Vec<&str> = names.iter().take(MAX_LISTED).map(String::as_str).collect();
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
const MAX_LISTED: usize = 5;

/// Reads the scenario in a record.
fn read(bytes: &[u8], report: Report, place: usize) -> Result<Scenario, ReadError> {
    let recorded = Recorded::decode(bytes).map_err(|error| {
        let message = format!(
            "not a Scenario message, or damaged: {error}; of Waymo Open Motion the files under `scenario` are read"
        );
        report.at(tfrecord::record(place)).fail(message)
    })?;
    count(bytes).report_to(&report);
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

/// A field that a message can have: its number, its name, and what is known of the message in it.
type Field = (u32, &'static str, FieldUse);

/// What is made of a field.
#[derive(Clone, Copy)]
enum FieldUse {
    /// Its value is used.
    Used,
    /// Nothing.
    Unused,
    /// It is a message with such fields.
    Message(&'static [Field]),
}

const POINT: &[Field] = &[(1, "x", Used), (2, "y", Used), (3, "z", Used)];
const LINE: &[Field] = &[
    (1, "type", Unused),
    (2, "polyline", FieldUse::Message(POINT)),
];
const POLYGON: &[Field] = &[(1, "polygon", FieldUse::Message(POINT))];
const NEIGHBOUR: &[Field] = &[
    (1, "feature_id", Used),
    (2, "self_start_index", Used),
    (3, "self_end_index", Used),
    (4, "neighbor_start_index", Unused),
    (5, "neighbor_end_index", Unused),
    (6, "boundaries", Unused),
];
const BOUNDARY: &[Field] = &[
    (1, "lane_start_index", Used),
    (2, "lane_end_index", Used),
    (3, "boundary_feature_id", Used),
    (4, "boundary_type", Used),
];
const LANE: &[Field] = &[
    (1, "speed_limit_mph", Used),
    (2, "type", Used),
    (3, "interpolating", Unused),
    (8, "polyline", FieldUse::Message(POINT)),
    (9, "entry_lanes", Used),
    (10, "exit_lanes", Used),
    (11, "left_neighbors", FieldUse::Message(NEIGHBOUR)),
    (12, "right_neighbors", FieldUse::Message(NEIGHBOUR)),
    (13, "left_boundaries", FieldUse::Message(BOUNDARY)),
    (14, "right_boundaries", FieldUse::Message(BOUNDARY)),
];
const STOP_SIGN: &[Field] = &[(1, "lane", Used), (2, "position", FieldUse::Message(POINT))];
const MAP_FEATURE: &[Field] = &[
    (1, "id", Used),
    (3, "lane", FieldUse::Message(LANE)),
    (4, "road_line", FieldUse::Message(LINE)),
    (5, "road_edge", FieldUse::Message(LINE)),
    (7, "stop_sign", FieldUse::Message(STOP_SIGN)),
    (8, "crosswalk", FieldUse::Message(POLYGON)),
    (9, "speed_bump", Unused),
    (10, "driveway", Unused),
];
const LANE_STATE: &[Field] = &[
    (1, "lane", Used),
    (2, "state", Used),
    (3, "stop_point", FieldUse::Message(POINT)),
];
const MAP_STATE: &[Field] = &[(1, "lane_states", FieldUse::Message(LANE_STATE))];
const STATE: &[Field] = &[
    (2, "center_x", Used),
    (3, "center_y", Used),
    (4, "center_z", Unused),
    (5, "length", Used),
    (6, "width", Used),
    (7, "height", Unused),
    (8, "heading", Used),
    (9, "velocity_x", Used),
    (10, "velocity_y", Used),
    (11, "valid", Used),
];
const TRACK: &[Field] = &[
    (1, "id", Used),
    (2, "object_type", Used),
    (3, "states", FieldUse::Message(STATE)),
];
const SCENARIO: &[Field] = &[
    (1, "timestamps_seconds", Used),
    (2, "tracks", FieldUse::Message(TRACK)),
    (4, "objects_of_interest", Unused),
    (5, "scenario_id", Used),
    (6, "sdc_track_index", Used),
    (7, "dynamic_map_states", FieldUse::Message(MAP_STATE)),
    (8, "map_features", FieldUse::Message(MAP_FEATURE)),
    (10, "current_time_index", Unused),
    (11, "tracks_to_predict", Unused),
    (12, "compressed_frame_laser_data", Unused),
    (13, "frame_camera_tokens", Unused),
];

/// Counts the fields of a scenario that are not used.
fn count(scenario: &[u8]) -> Leftovers {
    let mut leftovers = Leftovers::default();
    fields(scenario, SCENARIO, "", &mut leftovers);
    leftovers
}

fn fields(message: &[u8], known: &[Field], within: &str, leftovers: &mut Leftovers) {
    for field in Fields::new(message).map_while(Result::ok) {
        let found = known.iter().find(|(number, ..)| *number == field.number);
        match (found, field.value) {
            (Some((.., Used)), _) => {}
            (Some((_, name, FieldUse::Message(known))), Value::Bytes(bytes)) => {
                let within = match within {
                    "" => (*name).to_string(),
                    _ => format!("{within}/{name}"),
                };
                fields(bytes, known, &within, leftovers);
            }
            (Some((_, name, _)), _) => leftovers.field(within, name),
            (None, _) => leftovers.field(within, &format!("field {}", field.number)),
        }
    }
}
