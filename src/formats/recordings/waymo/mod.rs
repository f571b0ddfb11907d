//! Waymo Open Motion: scenario protos in TFRecord files, of which one is read without the others, and their road users.

mod lanes;
mod map;
#[rustfmt::skip]
mod messages;
mod tfrecord;

use std::path::Path;

use FieldUse::{Unused, Used};
use nearmiss_scene::scenario::{ContentHash, ObstacleType, Scenario};
use prost::Message;

use super::assembly::{
    About, Ids, RecordedTrack, TRUCK_LENGTH, TrackState, assemble, median, signed_speed,
};
use super::{At, Leftovers, Report};
use crate::commonroad::ReadError;
use crate::commonroad::builder::SourceLocation;
use crate::commonroad::wire::{Fields, Value};
use crate::dispatch::{Address, Format, Parts};
use messages::{ObjectState, Scenario as Recorded, Track};
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
    let tracks = read_tracks(&report, &recorded, &mut ids)?;
    let map = map::read(&report, &recorded, &mut ids)?;
    let letters = id.chars().filter(char::is_ascii_alphanumeric);
    let about = About {
        source: "Waymo Open Motion Dataset",
        benchmark_id: format!("USA_Waymo{}-1_1_T-1", letters.take(32).collect::<String>()),
        time_step_size: dt,
        tags: vec!["urban".into()],
        ego: ego_track(&report, &recorded),
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

/// Sizes that vary by more than this over a track are noted, metres.
const VARIES: f64 = 0.05;

/// The ids of tracks as they are in the scenario, in the order of the file.
fn read_tracks(
    report: &Report,
    recorded: &Recorded,
    ids: &mut Ids,
) -> Result<Vec<RecordedTrack>, ReadError> {
    let mut varying = Vec::new();
    let mut long = 0;
    let mut tracks = Vec::with_capacity(recorded.tracks.len());
    for (place, track) in recorded.tracks.iter().enumerate() {
        let name = || format!("tracks[{place}]");
        let Some(id) = track.id.filter(|id| *id > 0).map(i64::from) else {
            report.at(name()).warn("no id; left out");
            continue;
        };
        let (track, spread) = self::track(report, recorded, track, id, &name)?;
        if !ids.take(id) {
            report
                .at(name())
                .warn(format!("track {id} is there twice; the first is used"));
            continue;
        }
        long += usize::from(track.kind == ObstacleType::Truck);
        if spread > VARIES {
            varying.push((id, spread));
        }
        tracks.push(track);
    }
    let most = varying.iter().max_by(|a, b| a.1.total_cmp(&b.1)).copied();
    if let Some((id, spread)) = most {
        report.note(format!(
            "lengths or widths of {} tracks vary over time, most by {spread:.2} m (track {id}); the median of each is used",
            varying.len()
        ));
    }
    report.note_count(long, |n| {
        format!(
            "vehicles longer than {TRUCK_LENGTH} m are taken as trucks, as the data set does not tell: {n}"
        )
    });
    Ok(tracks)
}

/// The id of the track that recorded the scenario.
fn ego_track(report: &Report, recorded: &Recorded) -> Option<i64> {
    let at = || report.at("sdc_track_index");
    let Some(place) = recorded.sdc_track_index else {
        at().warn("missing; no ego");
        return None;
    };
    let track = usize::try_from(place)
        .ok()
        .and_then(|i| recorded.tracks.get(i));
    if track.is_none() {
        at().warn(format!(
            "{place}, but there are {} tracks; no ego",
            recorded.tracks.len()
        ));
    }
    track?.id.map(i64::from)
}

/// A track, and by how much its size varies, metres.
fn track(
    report: &Report,
    recorded: &Recorded,
    track: &Track,
    id: i64,
    name: &impl Fn() -> String,
) -> Result<(RecordedTrack, f64), ReadError> {
    let steps = recorded.timestamps_seconds.len();
    if track.states.len() != steps {
        let message = format!("{} states for {steps} time stamps", track.states.len());
        report.at(name()).warn(message);
    }
    let mut states = Vec::new();
    let (mut lengths, mut widths) = (Vec::new(), Vec::new());
    for (step, said) in track.states.iter().take(steps).enumerate() {
        if said.valid != Some(true) {
            continue;
        }
        let at = LazyPlace { report, name, step };
        states.push(state(&at, said)?);
        lengths.push(at.number(f64::from(said.length.unwrap_or(0.0)))?);
        widths.push(at.number(f64::from(said.width.unwrap_or(0.0)))?);
    }
    let spread = |values: &[f64]| {
        let most = values.iter().copied().fold(f64::MIN, f64::max);
        let least = values.iter().copied().fold(f64::MAX, f64::min);
        if values.is_empty() { 0.0 } else { most - least }
    };
    let varies = spread(&lengths).max(spread(&widths));
    let length = median(lengths);
    let kind = match track.object_type {
        Some(1) if length > TRUCK_LENGTH => ObstacleType::Truck,
        Some(1) => ObstacleType::Car,
        Some(2) => ObstacleType::Pedestrian,
        Some(3) => ObstacleType::Bicycle,
        _ => ObstacleType::Unknown,
    };
    let track = RecordedTrack {
        shape: None,
        is_static: false,
        id,
        kind,
        length,
        width: median(widths),
        states,
    };
    Ok((track, varies))
}

/// A state's place, spelled out only in messages.
struct LazyPlace<'a, N: Fn() -> String> {
    report: &'a Report,
    name: &'a N,
    step: usize,
}

impl<N: Fn() -> String> LazyPlace<'_, N> {
    fn at(&self) -> At<'_> {
        self.report
            .at(format!("{}/states[{}]", (self.name)(), self.step))
    }

    fn number(&self, value: f64) -> Result<f64, ReadError> {
        // Spelling the place out for each of many numbers would take longest of all.
        if value.abs() < 1e6 {
            return Ok(value);
        }
        self.at().number(value)
    }
}

fn state(
    at: &LazyPlace<'_, impl Fn() -> String>,
    said: &ObjectState,
) -> Result<TrackState, ReadError> {
    let (Some(x), Some(y)) = (said.center_x, said.center_y) else {
        return Err(at
            .at()
            .fail("a valid state without `center_x` and `center_y`"));
    };
    let (x, y) = (at.number(x)?, at.number(y)?);
    let heading = at.number(f64::from(said.heading.unwrap_or(0.0)))?;
    let velocity = match (said.velocity_x, said.velocity_y) {
        (Some(x), Some(y)) => {
            let (x, y) = (at.number(f64::from(x))?, at.number(f64::from(y))?);
            Some(signed_speed(heading, x, y))
        }
        _ => None,
    };
    Ok(TrackState {
        step: i64::try_from(at.step).unwrap_or(i64::MAX),
        position: at.at_point(x, y)?,
        heading,
        velocity,
        acceleration: None,
    })
}

impl<N: Fn() -> String> LazyPlace<'_, N> {
    fn at_point(&self, x: f64, y: f64) -> Result<nearmiss_base::geometry::Point, ReadError> {
        if x.abs() < 1e6 && y.abs() < 1e6 {
            return Ok(nearmiss_base::geometry::Point::new(x, y));
        }
        self.at().point(x, y)
    }
}
