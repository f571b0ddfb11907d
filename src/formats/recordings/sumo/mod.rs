//! SUMO: floating car data (`--fcd-output`) with the net and the vehicle types that lie beside it.

mod fcd;
mod files;
mod lights;
mod net;
mod types;

use std::path::Path;

use super::assembly::{About, Map, RecordedTrack, TrackState, assemble};
use super::ids::Ids;
use super::report::Report;
use super::windows::{self, Look, Looks, Wanted};
use crate::formats::address::Address;
use crate::formats::commonroad::ReadError;
use crate::formats::commonroad::builder::SourceLocation;
use crate::formats::dispatch::Format;
use crate::geometry::{Point, Vector};
use crate::scenario::{ContentHash, Scenario};
use crate::system;
use fcd::{Recorded, Seen};
use types::{Types, VehicleType};

/// The format.
pub struct Sumo;

/// The vehicle that is the ego where none is chosen.
const EGO: &str = "ego";

/// Moments a second that are looked at for windows.
const LOOKS: f64 = 5.0;

/// Numbers of vehicles that are told.
const TOLD: usize = 12;

impl Format for Sumo {
    fn recognises(&self, _: &Path, head: &[u8]) -> bool {
        fcd::begins(head)
    }

    fn parts(&self, path: &Path) -> Result<Vec<String>, ReadError> {
        let report = Report::about(path.display().to_string());
        let bytes = system::read_file(path, system::LARGEST);
        let bytes = bytes.map_err(|e| ReadError::io(report.file(), &e))?;
        windows_of(path, &fcd::read(&bytes, report.file())?, &report)
    }

    fn open(&self, address: &Address) -> Result<Scenario, ReadError> {
        let Address { file, part } = address;
        let shown = part.as_ref().map_or_else(String::new, |p| format!("#{p}"));
        let report = Report::about(format!("{}{shown}", file.display()));
        let wanted = part
            .as_ref()
            .map(|p| Wanted::parse(p, &report))
            .transpose()?;
        let bytes = system::read_file(file, system::LARGEST);
        let bytes = bytes.map_err(|e| ReadError::io(report.file(), &e))?;
        let recorded = fcd::read(&bytes, &file.display().to_string())?;
        if wanted.is_none() {
            let windows = windows_of(file, &recorded, &report)?;
            if let Some(first) = windows.first() {
                return Err(report.fail(format!(
                    "longer than {} s; open a window of it, such as {}#{first} (`nearmiss inspect` of its folder lists {})",
                    windows::SHORT,
                    file.display(),
                    windows.len()
                )));
            }
        }
        scenario(file, &bytes, recorded, report, wanted)
    }
}

fn windows_of(path: &Path, recorded: &Recorded, report: &Report) -> Result<Vec<String>, ReadError> {
    let last = recorded.times.len().saturating_sub(1) as f64 * recorded.time_step;
    if last <= windows::SHORT {
        return Ok(Vec::new());
    }
    let types = Types::beside(path, recorded, report)?;
    let every = (1.0 / LOOKS / recorded.time_step).round().max(1.0) as i64;
    let mut looks = Looks::default();
    for (place, vehicle) in recorded.vehicles.iter().enumerate() {
        let size = types.of(&vehicle.kind);
        for seen in vehicle.seen.iter().filter(|s| s.step % every == 0) {
            let heading = seen.heading;
            let look = Look {
                track: u32::try_from(place).unwrap_or(u32::MAX),
                time: recorded.start + seen.step as f64 * recorded.time_step,
                position: middle(seen, size),
                velocity: Vector::new(heading.cos(), heading.sin()) * seen.speed,
                heading,
                half: (size.length / 2.0, size.width / 2.0),
            };
            looks.add(seen.step, look, report)?;
        }
    }
    let name = |place: u32| {
        let vehicle = recorded.vehicles.get(place as usize);
        vehicle.map_or_else(String::new, |v| v.name.clone())
    };
    Ok(looks.windows(name))
}

/// The middle of a body: SUMO gives that of its front.
fn middle(seen: &Seen, size: &VehicleType) -> Point {
    let (sin, cos) = seen.heading.sin_cos();
    let half = size.length / 2.0;
    Point::new(seen.front.x - half * cos, seen.front.y - half * sin)
}

fn scenario(
    file: &Path,
    bytes: &[u8],
    recorded: Recorded,
    report: Report,
    wanted: Option<Wanted>,
) -> Result<Scenario, ReadError> {
    let dt = recorded.time_step;
    let types = Types::beside(file, &recorded, &report)?;
    let net = files::net(file, &recorded.comment);
    let name = wanted.as_ref().map_or(EGO, |w| w.track.as_str());
    let chosen = recorded.vehicles.iter().find(|v| v.name == name);
    if let (Some(wanted), None) = (&wanted, chosen) {
        let known: Vec<&str> = recorded
            .vehicles
            .iter()
            .take(5)
            .map(|v| v.name.as_str())
            .collect();
        let message = format!(
            "no vehicle `{}`; it has {}, …",
            wanted.track,
            known.join(", ")
        );
        return Err(report.fail(message));
    }
    let steps = match (&wanted, chosen) {
        (
            Some(Wanted {
                start: Some(start), ..
            }),
            _,
        ) => {
            let first = ((start - recorded.start) / dt).round() as i64;
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
    let numbers = recorded
        .vehicles
        .iter()
        .filter_map(|v| v.name.parse::<i64>().ok());
    let mut ids = Ids::beyond(numbers.clone());
    numbers.filter(|id| *id > 0).for_each(|id| {
        ids.take(id);
    });
    let (mut tracks, mut told, mut ego) = (Vec::new(), Vec::new(), None);
    for vehicle in &recorded.vehicles {
        let id = match vehicle.name.parse::<i64>() {
            Ok(id) if id > 0 => id,
            _ => {
                let id = ids.fresh();
                told.push(format!("`{}` {id}", vehicle.name));
                id
            }
        };
        let size = types.of(&vehicle.kind);
        let seen = vehicle
            .seen
            .iter()
            .filter(|s| (steps.0..=steps.1).contains(&s.step));
        let states = seen.map(|seen| TrackState {
            step: seen.step - steps.0,
            position: middle(seen, size),
            heading: seen.heading,
            velocity: Some(seen.speed),
            acceleration: seen.acceleration,
        });
        let states: Vec<TrackState> = states.collect();
        if states.is_empty() {
            continue;
        }
        if chosen.is_some_and(|c| c.name == vehicle.name) {
            ego = Some(id);
        }
        tracks.push(RecordedTrack {
            id,
            kind: size.kind,
            length: size.length,
            width: size.width,
            states,
        });
    }
    if !told.is_empty() {
        let more = match told.len().saturating_sub(TOLD) {
            0 => String::new(),
            more => format!(" and {more} more"),
        };
        told.truncate(TOLD);
        report.note(format!("vehicles are numbered: {}{more}", told.join(", ")));
    }
    let (map, map_hash) = match net {
        Some(net) => {
            let start = recorded.start + steps.0 as f64 * dt;
            net::read(&report, &net, &mut ids, (start, dt))?
        }
        None => {
            let message = "no net: no .net.xml beside it; the scenario has no lanes";
            report.at("").warn(message);
            (Map::default(), ContentHash::digest(b""))
        }
    };
    let window = part_bytes(steps, ego);
    let sizes = types.bytes();
    let about = About {
        source: "SUMO",
        benchmark_id: format!(
            "ZAM_Sumo-1_{}_T-{}",
            ego.unwrap_or(1).max(1),
            steps.0.max(0) + 1
        ),
        time_step_size: dt,
        tags: vec!["simulated".into()],
        ego,
        hash: ContentHash::of_parts([bytes, &map_hash.bytes()[..], &sizes, &window]),
    };
    assemble(report, about, map, tracks)
}

/// What tells a window of a file from the others.
fn part_bytes(steps: (i64, i64), ego: Option<i64>) -> Vec<u8> {
    let all = [steps.0, steps.1, ego.unwrap_or(-1)];
    all.into_iter().flat_map(i64::to_le_bytes).collect()
}
