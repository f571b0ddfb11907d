//! ASAM OSI: ground truth in MCAP files, as omega-prime writes it, and in traces (`*.osi`).
//!
//! Places are the middle of bodies. The host vehicle is the ego. The map is the OpenDRIVE file in the recording, or the
//! one that it refers to.

mod container;
#[rustfmt::skip]
mod messages;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use nearmiss_base::geometry::Point;
use nearmiss_scene::scenario::{ObstacleType, Scenario};
use prost::Message;

use super::assembly::{TrackState, default_size, in_words, kind_by_size, median, signed_speed};
use super::rows::Steps;
use super::tracks::table::{Decided, Recorded, Track};
use super::tracks::{AboutTable, MapOfTable, Table, cached};
use super::{Leftovers, Report, has_extension};
use crate::commonroad::ReadError;
use crate::commonroad::builder::SourceLocation;
use crate::commonroad::wire::Fields;
use crate::dispatch::{Address, Applies, Format, Parts};
use container::{MAGIC, Next, Schema};
use messages::{GroundTruth, MapAsamOpenDrive, MovingObject, SensorView, VehicleClassification};

/// The format.
pub struct Osi;

impl Format for Osi {
    fn recognises(&self, path: &Path, head: &[u8]) -> bool {
        if head.starts_with(MAGIC) {
            // What is wrong with a damaged one is told when it is read.
            return container::has_ground_truth(path).unwrap_or(true);
        }
        // A length, and a version or a time.
        let begins = head.len() > 6 && head[3] == 0 && matches!(head[4], 0x0a | 0x12);
        has_extension(path, "osi") && begins
    }

    fn applies(&self, _: &Path, _: &[u8]) -> Applies {
        Applies::Map
    }

    fn parts(&self, path: &Path) -> Result<Parts, ReadError> {
        read(path)?.parts(path)
    }

    fn open(&self, address: &Address) -> Result<Scenario, ReadError> {
        read(&address.file)?.open_at(address)
    }
}

/// The data in a file.
fn read(path: &Path) -> Result<Arc<Table>, ReadError> {
    cached(&[path], || {
        let report = Report::about(path.display().to_string());
        let mut seen = Seen::default();
        let is_mcap = !has_extension(path, "osi");
        let mut take = |schema, bytes: &[u8]| seen.take(schema, bytes);
        let read = if is_mcap {
            container::mcap(path, &mut take)
        } else {
            trace_schema(path).and_then(|schema| container::trace(path, schema, &mut take))
        };
        read.map_err(|error| report.fail(error))?;
        seen.table(path, report)
    })
}

/// What the messages of a trace are, by the first one: a sensor's view has the ground truth in it.
fn trace_schema(path: &Path) -> Result<Schema, String> {
    let mut schema = Schema::GroundTruth;
    container::trace(path, schema, &mut |_, bytes| {
        let is_empty = |truth: &GroundTruth| truth.moving_object.is_empty();
        let own = GroundTruth::decode(bytes).ok();
        let view = SensorView::decode(bytes).ok();
        let inside = view.and_then(|view| view.global_ground_truth);
        if own.is_none_or(|own| is_empty(&own)) && inside.is_some_and(|truth| !is_empty(&truth)) {
            schema = Schema::SensorView;
        }
        Ok(Next::Enough)
    })?;
    Ok(schema)
}

/// Fields of ground truth that are not used, by number.
const UNUSED: [(u32, &str); 14] = [
    (4, "stationary_object"),
    (6, "traffic_sign"),
    (7, "traffic_light"),
    (8, "road_marking"),
    (9, "lane_boundary"),
    (10, "lane"),
    (11, "occupant"),
    (12, "environmental_conditions"),
    (14, "proj_string"),
    (16, "model_reference"),
    (17, "reference_line"),
    (18, "logical_lane_boundary"),
    (19, "logical_lane"),
    (20, "proj_frame_offset"),
];

/// What was seen of a recording.
#[derive(Default)]
struct Seen {
    /// Nanoseconds of each moment.
    times: Vec<i64>,
    objects: BTreeMap<u64, Object>,
    host: Option<u64>,
    map: Option<Vec<u8>>,
    map_reference: Option<String>,
    leftovers: Leftovers,
    /// Moments that do not follow the one before, and objects without an id or a place.
    odd: (usize, usize),
}

#[derive(Default)]
struct Object {
    kind: Option<(i32, VehicleClassification)>,
    lengths: Vec<f64>,
    widths: Vec<f64>,
    /// By moment.
    states: Vec<TrackState>,
}

impl Seen {
    fn take(&mut self, schema: Schema, bytes: &[u8]) -> Result<Next, String> {
        let damaged = |error: prost::DecodeError| format!("damaged: {error}");
        let truth = match schema {
            Schema::Map => {
                let map = MapAsamOpenDrive::decode(bytes).map_err(damaged)?;
                let xml = map.open_drive_xml_content.filter(|xml| !xml.is_empty());
                self.map = self.map.take().or(xml.map(String::into_bytes));
                return Ok(Next::More);
            }
            Schema::SensorView => {
                let view = SensorView::decode(bytes).map_err(damaged)?;
                view.global_ground_truth.unwrap_or_default()
            }
            Schema::GroundTruth => {
                for field in Fields::new(bytes).map_while(Result::ok) {
                    let unused = UNUSED.iter().find(|(number, _)| *number == field.number);
                    if let Some((_, name)) = unused {
                        self.leftovers.field("", name);
                    }
                }
                GroundTruth::decode(bytes).map_err(damaged)?
            }
        };
        let time = truth.timestamp.unwrap_or_default();
        let nanos = i64::from(time.nanos.unwrap_or_default());
        let seconds = time.seconds.unwrap_or_default();
        let time = seconds.saturating_mul(1_000_000_000).saturating_add(nanos);
        if self.times.last().is_some_and(|before| *before >= time) {
            self.odd.0 += 1;
            return Ok(Next::More);
        }
        let moment = self.times.len() as i64;
        self.times.push(time);
        let host = truth.host_vehicle_id.and_then(|id| id.value);
        self.host = self.host.or(host);
        let reference = truth.map_reference.filter(|name| !name.is_empty());
        self.map_reference = self.map_reference.take().or(reference);
        for object in truth.moving_object {
            if self.object(&object, moment).is_none() {
                self.odd.1 += 1;
            }
        }
        Ok(Next::More)
    }

    /// Adds an object at a moment; nothing where it lacks an id or a place.
    fn object(&mut self, object: &MovingObject, moment: i64) -> Option<()> {
        let id = object.id?.value?;
        let base = object.base?;
        let place = base.position?;
        let position = Point::new(place.x.unwrap_or_default(), place.y.unwrap_or_default());
        let heading = base.orientation.and_then(|o| o.yaw).unwrap_or_default();
        let numbers = [position.x, position.y, heading];
        if numbers
            .iter()
            .any(|value| !value.is_finite() || value.abs() > 1e9)
        {
            return None;
        }
        let along = |of: Option<messages::Vector>| {
            let (x, y) = (of?.x?, of?.y?);
            (x.is_finite() && y.is_finite()).then_some((x, y))
        };
        let known = self.objects.entry(id).or_default();
        known.kind.get_or_insert((
            object.r#type.unwrap_or_default(),
            object.vehicle_classification.unwrap_or_default(),
        ));
        if let Some(size) = base.dimension {
            let is_size = |value: &f64| *value > 0.0 && value.is_finite();
            known.lengths.extend(size.length.filter(is_size));
            known.widths.extend(size.width.filter(is_size));
        }
        known.states.push(TrackState {
            step: moment,
            position,
            heading,
            velocity: along(base.velocity).map(|(x, y)| signed_speed(heading, x, y)),
            acceleration: along(base.acceleration)
                .map(|(x, y)| x * heading.cos() + y * heading.sin()),
        });
        Some(())
    }

    /// The recording, with its map.
    fn table(self, path: &Path, report: Report) -> Result<Table, ReadError> {
        let (late, lacking) = self.odd;
        if late > 0 {
            let message = format!("{late} messages are not after the one before them; left out");
            report.at("").warn(message);
        }
        if lacking > 0 {
            let message = format!("{lacking} moving objects without an id or a place; left out");
            report.at("").warn(message);
        }
        // Clocks that count from 1970 say nothing of a recording.
        let first = self.times.first().copied().unwrap_or_default();
        let origin = if first.abs() > LARGEST_START {
            first
        } else {
            0
        };
        let seconds = |time: &i64| (*time - origin) as f64 / 1e9;
        let times: Vec<f64> = self.times.iter().map(seconds).collect();
        let steps = Steps::from_times(&times).map_err(|why| report.fail(why))?;
        steps.report_to(&report);
        if origin != 0 {
            report.note(format!(
                "times are from the first message on, at {} s",
                first as f64 / 1e9
            ));
        }
        let mut assumed = Vec::new();
        let mut tracks = Vec::with_capacity(self.objects.len());
        for (id, object) in self.objects {
            let size = (median(object.lengths), median(object.widths));
            let (kind_said, vehicle) = object.kind.unwrap_or_default();
            let kind = kind(kind_said, &vehicle, size);
            let mut states = object.states;
            states
                .iter_mut()
                .for_each(|state| state.step = steps.steps[state.step as usize]);
            states.dedup_by_key(|state| state.step);
            let is_sized = size.0 > 0.0 && size.1 > 0.0;
            if !is_sized {
                assumed.push(kind);
            }
            tracks.push(Track {
                name: id.to_string(),
                scenario: String::new(),
                kind,
                is_ego: self.host == Some(id),
                size: if is_sized { size } else { default_size(kind) },
                states,
            });
        }
        match self.host {
            Some(host) if tracks.iter().any(|track| track.is_ego) => {
                report.note(format!("the ego is the host vehicle, {host}"));
            }
            Some(host) => report.at("").warn(format!(
                "the host vehicle {host} is no moving object; no ego"
            )),
            None => {}
        }
        if !assumed.is_empty() {
            report.note(format!(
                "tracks without a size: {}; assumed by class: {}",
                assumed.len(),
                in_words(assumed)
            ));
        }
        let named = self
            .map_reference
            .map(|name| super::named_file(path, &name));
        let beside = named.filter(|map| map.is_file()).map(MapOfTable::File);
        let recorded = Recorded {
            tracks,
            start: steps.start,
            time_step: steps.time_step,
            plane: None,
            diagnostics: report.into_diagnostics(),
            decided: Decided::default(),
        };
        let about = AboutTable {
            source: "ASAM OSI",
            tags: &[],
            how: String::new(),
            notes: Vec::new(),
        };
        let map = self.map.map(MapOfTable::Inside).or(beside);
        Table::new(recorded, about, map, &[path], self.leftovers)
    }
}

/// Recordings that begin later have a clock of the world, nanoseconds.
const LARGEST_START: i64 = 1_000_000_000_000_000;

/// What an object is, by the numbers of the interface.
fn kind(said: i32, vehicle: &VehicleClassification, size: (f64, f64)) -> ObstacleType {
    let kind = match (said, vehicle.r#type.unwrap_or_default()) {
        (3, _) => return ObstacleType::Pedestrian,
        (2, 2..=6) => ObstacleType::Car,
        (2, 7..=9 | 16 | 19) => ObstacleType::Truck,
        (2, 10) => ObstacleType::Motorcycle,
        (2, 11 | 17 | 18) => ObstacleType::Bicycle,
        (2, 12) => ObstacleType::Bus,
        (2, 13 | 14) => ObstacleType::Train,
        (2, 15) => ObstacleType::Pedestrian,
        (2, _) => kind_by_size(size),
        _ => return ObstacleType::Unknown,
    };
    // Ambulance, fire brigade and police.
    match vehicle.role {
        Some(3..=5) => ObstacleType::PriorityVehicle,
        _ => kind,
    }
}
