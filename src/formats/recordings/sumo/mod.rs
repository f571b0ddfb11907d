//! SUMO: floating car data (`--fcd-output`) with the net and the vehicle types that lie beside it.

mod fcd;
mod files;
mod geo;
mod net;

use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

use super::assembly::{About, Ids, Map, RecordedTrack, TrackState, assemble};
use super::windows::{LongRecording, WindowRequest};
use super::{Report, report_of, rows, windows};
use crate::commonroad::ReadError;
use crate::dispatch::{Address, Format, Parts};
use fcd::{Recorded, Vehicle, VehicleAtStep};
use files::{Types, VehicleType};
use geo::Placement;
use nearmiss_base::geometry::Point;
use nearmiss_base::system::{self, FileCache};
use nearmiss_scene::scenario::{ContentHash, HashedBeginning, Scenario};

/// The format.
pub struct Sumo;

/// The vehicle that is the ego where none is chosen.
const EGO: &str = "ego";

/// Recordings that are kept for other windows of them, bytes.
const MAX_CACHED: usize = 512 << 20;

static RECORDINGS: FileCache<(Recorded, HashedBeginning)> = FileCache::new(MAX_CACHED);

/// So many vehicles of a file are named in a message.
const MAX_LISTED: usize = 5;

/// Numbers of vehicles that are told.
const MAX_NUMBERS: usize = 12;

impl Format for Sumo {
    fn recognises(&self, path: &Path, head: &[u8]) -> bool {
        fcd::is_xml(head) || fcd::is_csv(head) || fcd::is_parquet(path, head)
    }

    fn parts(&self, path: &Path) -> Result<Parts, ReadError> {
        let (recorded, _) = &*read(path)?;
        if !is_long(recorded) {
            return Ok(Parts::One);
        }
        let report = Report::about(path.display().to_string());
        Ok(Parts::Long(Box::new(long_recording(
            path, recorded, report,
        )?)))
    }

    fn open(&self, address: &Address) -> Result<Scenario, ReadError> {
        let (file, report) = (&address.file, report_of(address));
        let wanted = WindowRequest::of(address, &report)?;
        let (recorded, hashed) = &*read(file)?;
        if wanted.is_none() && is_long(recorded) {
            let first = recorded.vehicles.first();
            let (name, step) = first.map_or(("1", 0), |v| (v.name.as_str(), v.span().0));
            let start = recorded.start() + step as f64 * recorded.time_step();
            return Err(windows::too_long(&report, file, name, start));
        }
        scenario(file, hashed, recorded, report, wanted)
    }
}

/// The data in a file, with the hash of its bytes.
fn read(path: &Path) -> Result<Arc<(Recorded, HashedBeginning)>, ReadError> {
    let file = path.display().to_string();
    RECORDINGS.get(&[path], || {
        let bytes =
            system::read_file(path, system::LARGEST).map_err(|e| ReadError::io(&file, &e))?;
        let recorded = if bytes.starts_with(b"PAR1") {
            fcd::read_parquet(path, &file)?
        } else if fcd::is_csv(&bytes) {
            fcd::read_csv(&bytes, &file)?
        } else {
            fcd::read_xml(&bytes, &file)?
        };
        let size = recorded.size();
        Ok(((recorded, HashedBeginning::new(&bytes)), size))
    })
}

fn is_long(recorded: &Recorded) -> bool {
    let last = recorded.times.last().copied().unwrap_or_default();
    last - recorded.start() > windows::MAX_WHOLE_SECONDS
}

/// Everyone in a long recording, a few times a second.
fn long_recording(
    path: &Path,
    recorded: &Recorded,
    report: Report,
) -> Result<LongRecording, ReadError> {
    let types = Types::read(path, recorded, &report)?;
    // The net is needed only to place what is in degrees.
    let net = match recorded.degrees {
        Some(false) => None,
        _ => files::net(path, recorded, &report)?,
    };
    let (placement, _) = Placement::new(recorded, net.as_ref().map(|n| &n.1.location), &report);
    let every = (1.0 / windows::MOMENTS / recorded.time_step())
        .round()
        .max(1.0) as i64;
    let mut names = HashMap::with_capacity(recorded.vehicles.len());
    let mut ids = OwnIds::new(recorded);
    let tracks = recorded
        .vehicles
        .iter()
        .map(|vehicle| {
            let id = ids.id(vehicle).0;
            names.insert(id, vehicle.name.clone());
            let seen = vehicle.seen.iter().filter(|seen| seen.step % every == 0);
            let states = states(vehicle, seen, (0, every), &report);
            track(id, types.get(&vehicle.kind), states, &placement)
        })
        .collect();
    let about = About::bare(SOURCE, "ZAM_Sumo", recorded.time_step() * every as f64);
    let scenario = assemble(report, about, Map::default(), tracks)?;
    Ok(LongRecording::new(scenario, names, recorded.start()))
}

/// The simulator, as scenarios name their source.
const SOURCE: &str = "SUMO";

/// Ids of vehicles in a scenario: their names where these are numbers.
struct OwnIds(Ids);

impl OwnIds {
    fn new(recorded: &Recorded) -> Self {
        let names = recorded.vehicles.iter().map(|vehicle| &vehicle.name);
        let numbers = names.filter_map(|name| name.parse::<i64>().ok());
        let mut ids = Ids::beyond(numbers.clone());
        numbers.filter(|id| *id > 0).for_each(|id| {
            ids.take(id);
        });
        Self(ids)
    }

    /// The id of a vehicle, and whether it is other than its name.
    fn id(&mut self, vehicle: &Vehicle) -> (i64, bool) {
        match vehicle.name.parse::<i64>() {
            Ok(id) if id > 0 => (id, false),
            _ => (self.0.fresh(), true),
        }
    }
}

/// The states of a vehicle; the first step of the scenario is `first`, and one is so many of the recording's.
fn states<'s>(
    vehicle: &Vehicle,
    seen: impl Iterator<Item = &'s VehicleAtStep>,
    (first, steps): (i64, i64),
    report: &Report,
) -> Vec<VehicleAtStep> {
    let mut seen: Vec<VehicleAtStep> = seen.copied().collect();
    let name = || format!("vehicle `{}`", vehicle.name);
    rows::once(report, name, &mut seen, |s| s.step, |s| s.front);
    for seen in &mut seen {
        seen.step = (seen.step - first) / steps;
    }
    seen
}

fn track(
    id: i64,
    size: &VehicleType,
    seen: Vec<VehicleAtStep>,
    placement: &Placement,
) -> RecordedTrack {
    let states = seen.iter().map(|seen| TrackState {
        step: seen.step,
        position: middle(placement.metres(seen.front), seen.heading, size),
        heading: seen.heading,
        velocity: Some(seen.speed),
        acceleration: seen.acceleration,
    });
    RecordedTrack {
        shape: None,
        is_static: false,
        id,
        kind: size.kind,
        length: size.length,
        width: size.width,
        states: states.collect(),
    }
}

/// The middle of a body: SUMO gives that of its front.
fn middle(front: Point, heading: f64, size: &VehicleType) -> Point {
    let (sin, cos) = heading.sin_cos();
    let half = size.length / 2.0;
    Point::new(front.x - half * cos, front.y - half * sin)
}

fn scenario(
    file: &Path,
    hashed: &HashedBeginning,
    recorded: &Recorded,
    report: Report,
    wanted: Option<WindowRequest>,
) -> Result<Scenario, ReadError> {
    let dt = recorded.time_step();
    let types = Types::read(file, recorded, &report)?;
    let name = wanted.as_ref().map_or(EGO, |w| w.track.as_str());
    let chosen = recorded.vehicles.iter().find(|v| v.name == name);
    if let (Some(wanted), None) = (&wanted, chosen) {
        let known = recorded.vehicles.iter().take(MAX_LISTED);
        let known: Vec<&str> = known.map(|v| v.name.as_str()).collect();
        let more = match recorded.vehicles.len() - known.len() {
            0 => String::new(),
            more => format!(" and {more} more"),
        };
        let message = format!(
            "no vehicle `{}`; it has {}{more}",
            wanted.track,
            known.join(", ")
        );
        return Err(report.fail(message));
    }
    let steps = match (&wanted, chosen) {
        (
            Some(WindowRequest {
                start: Some(start), ..
            }),
            _,
        ) => {
            let first = ((start - recorded.start()) / dt).round() as i64;
            (first, first + (windows::LENGTH / dt).round() as i64)
        }
        (Some(_), Some(vehicle)) => vehicle.span(),
        _ => (0, i64::MAX),
    };
    if let (Some(wanted), Some(vehicle)) = (&wanted, chosen)
        && !vehicle
            .seen
            .iter()
            .any(|s| (steps.0..=steps.1).contains(&s.step))
    {
        let message = format!("vehicle `{}` is not there in that window", wanted.track);
        return Err(report.fail(message));
    }
    recorded.steps.report_to(&report);
    recorded.leftovers.report_to(&report);
    let net = files::net(file, recorded, &report)?;
    let location = net.as_ref().map(|(_, net)| &net.location);
    let (placement, has_lanes) = Placement::new(recorded, location, &report);
    let mut ids = OwnIds::new(recorded);
    let (mut tracks, mut told, mut ego) = (Vec::new(), Vec::new(), None);
    for vehicle in &recorded.vehicles {
        let (id, is_new) = ids.id(vehicle);
        let mut seen = vehicle
            .seen
            .iter()
            .filter(|s| (steps.0..=steps.1).contains(&s.step))
            .peekable();
        if seen.peek().is_none() {
            continue;
        }
        if is_new {
            told.push(format!("`{}` {id}", vehicle.name));
        }
        if chosen.is_some_and(|c| c.name == vehicle.name) {
            ego = Some(id);
        }
        let states = states(vehicle, seen, (steps.0, 1), &report);
        tracks.push(track(id, types.get(&vehicle.kind), states, &placement));
    }
    if !told.is_empty() {
        let more = match told.len().saturating_sub(MAX_NUMBERS) {
            0 => String::new(),
            more => format!(" and {more} more"),
        };
        told.truncate(MAX_NUMBERS);
        report.note(format!("vehicles are numbered: {}{more}", told.join(", ")));
    }
    let (map, map_hash) = match net.filter(|_| has_lanes) {
        Some((_, net)) => {
            let start = recorded.start() + steps.0 as f64 * dt;
            net::to_map(&report, &net, &mut ids.0, (start, dt))
        }
        None => (Map::default(), ContentHash::digest(b"")),
    };
    let window = part_bytes(steps, ego);
    let sizes = types.bytes();
    let about = About {
        source: SOURCE,
        benchmark_id: format!(
            "ZAM_Sumo-1_{}_T-{}",
            ego.unwrap_or(1).max(1),
            steps.0.max(0) + 1
        ),
        time_step_size: dt,
        tags: vec!["simulated".into()],
        ego,
        hash: hashed.with([&map_hash.bytes()[..], &sizes, &window]),
    };
    assemble(report, about, map, tracks)
}

/// The lanes of a net alone, with its lights from a time on in steps of so many seconds.
pub fn map(
    report: &Report,
    path: &Path,
    ids: &mut Ids,
    clock: (f64, f64),
) -> Result<Map, ReadError> {
    Ok(net::to_map(report, &*net::read(path)?, ids, clock).0)
}

/// What tells a window of a file from the others.
fn part_bytes(steps: (i64, i64), ego: Option<i64>) -> Vec<u8> {
    let all = [steps.0, steps.1, ego.unwrap_or(-1)];
    all.into_iter().flat_map(i64::to_le_bytes).collect()
}
