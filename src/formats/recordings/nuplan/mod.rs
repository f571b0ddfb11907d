//! nuPlan: logs in SQLite files (`*.db`), which part of a log is meant, and their maps in GeoPackages (`map.gpkg`).
//!
//! A log takes minutes and is opened in windows, of which only the rows are read. Its ego is the vehicle that recorded it.

mod geopackage;
mod junctions;
mod lanes;
mod layers;
mod log;
mod motion;
mod sqlite;

use std::collections::HashMap;
use std::path::Path;

use nearmiss_base::geometry::{Bounds, Vector};
use nearmiss_scene::scenario::{ContentHash, Scenario};

use super::assembly::{About, Ids, Map, RecordedTrack, assemble};
use super::windows::{LongRecording, WindowRequest};
use super::{Leftovers, Report, report_of, windows};
use crate::commonroad::ReadError;
use crate::commonroad::builder::SourceLocation;
use crate::dispatch::{Address, Format, Parts};
use junctions::{Lights, Signs};
use lanes::LaneSection;
use log::{Clock, EGO, Evidence, Log, id_of};
use sqlite::{Database, MAGIC, Token};

/// The format.
pub struct NuPlan;

const SOURCE: &str = "nuPlan";

/// So far around the traffic the map is cut out, metres.
const MAP_MARGIN: f64 = 50.0;

impl Format for NuPlan {
    fn recognises(&self, path: &Path, head: &[u8]) -> bool {
        log::is_named_or_begins_so(path, head)
    }

    fn is_found(&self, path: &Path, head: &[u8]) -> bool {
        head.starts_with(MAGIC)
            && matches!(
                log::database_kind(path),
                Evidence::Log | Evidence::Damaged(_)
            )
    }

    fn parts(&self, path: &Path) -> Result<Parts, ReadError> {
        log::check(path)?;
        let log = log::open_log(path)?;
        if log.duration() <= windows::MAX_WHOLE_SECONDS {
            return Ok(Parts::One);
        }
        let report = Report::about(path.display().to_string());
        Ok(Parts::Long(Box::new(long_recording(path, &log, report)?)))
    }

    fn open(&self, address: &Address) -> Result<Scenario, ReadError> {
        let Address { file, part } = address;
        log::check(file)?;
        let report = report_of(address);
        let log = log::open_log(file)?;
        let database = Database::open(file)?;
        let part = match part {
            Some(part) => find_part(part, &log, &database, &report)?,
            None if log.duration() > windows::MAX_WHOLE_SECONDS => {
                return Err(windows::too_long(&report, file, RECORDER, 0.0));
            }
            None => Part {
                sweeps: (0..log.sweeps.len()).collect(),
                ego: EGO,
            },
        };
        scenario(file, report, &log, &database, &part)
    }
}

/// Everyone in a long log, a few times a second; the vehicle that records in stretches as long as windows.
fn long_recording(path: &Path, log: &Log, report: Report) -> Result<LongRecording, ReadError> {
    let database = Database::open(path)?;
    let every = (1.0 / windows::MOMENTS / log.time_step).round().max(1.0);
    let time_step = log.time_step * every;
    let sweeps: Vec<usize> = (0..log.sweeps.len()).step_by(every as usize).collect();
    let clock = Clock::new(log, &sweeps, time_step);
    let mut tracks = motion::others(&database, &clock, &report)?;
    let whole = motion::recorder(&database, &clock)?;
    let mut free = Ids::beyond(tracks.iter().map(|track| track.id));
    let steps = (windows::LENGTH / time_step).round().max(1.0) as i64;
    let mut stretches: HashMap<i64, RecordedTrack> = HashMap::new();
    let mut names = HashMap::new();
    for state in whole.states {
        let stretch = stretches.entry(state.step / steps).or_insert_with(|| {
            let id = free.fresh();
            names.insert(id, RECORDER.to_string());
            RecordedTrack {
                id,
                states: Vec::new(),
                shape: None,
                ..whole
            }
        });
        stretch.states.push(state);
    }
    tracks.extend(stretches.into_values());
    tracks.sort_by_key(|track| track.id);
    let about = About::bare(SOURCE, "ZAM_Nuplan", time_step);
    let steps = 0..clock.last() + 1;
    let scenario = assemble(report, about, Map::default(), tracks)?;
    Ok(LongRecording::of_recorder(scenario, names, 0.0, steps))
}

fn scenario(
    path: &Path,
    report: Report,
    log: &Log,
    database: &Database,
    part: &Part,
) -> Result<Scenario, ReadError> {
    let clock = Clock::new(log, &part.sweeps, log.time_step);
    clock.report_to(&report);
    let mut tracks = vec![motion::recorder(database, &clock)?];
    tracks.extend(motion::others(database, &clock, &report)?);
    // In the order in which CommonRoad has them, so that they are the same when written and read again.
    tracks.sort_by_key(|track| (!track.is_static, track.id));
    match tracks.iter().find(|track| track.id == part.ego) {
        Some(ego) if ego.is_static => {
            let message = format!("track {} stands, and is no ego: a {}", ego.id, ego.kind);
            return Err(report.fail(message));
        }
        Some(_) => {}
        None => {
            let message = format!("track {} is not there in that window", part.ego);
            return Err(report.fail(message));
        }
    }
    report_log(&report, path, log);
    let lights = junctions::read(database, &clock)?;
    let mut leftovers = Leftovers::default();
    database.count_unused(&log.asked, &mut leftovers);
    leftovers.report_to(&report);
    let mut ids = Ids::beyond([]);
    (EGO..log::id_of(log.tracks.len())).for_each(|id| {
        ids.take(id);
    });
    let map = match layers::find(path, log) {
        Some(file) => {
            report.note(format!("map {}", file.display()));
            map(&report, &file, log, &lights, &tracks, &mut ids)?
        }
        None => {
            report.at("").warn(layers::nowhere(log));
            Map::default()
        }
    };
    let first = part.sweeps.first().copied().unwrap_or(0);
    let about = About {
        source: SOURCE,
        benchmark_id: benchmark_id(log, part.ego, first),
        time_step_size: log.time_step,
        tags: vec!["urban".into()],
        ego: Some(part.ego),
        hash: hash(log, part, &tracks, &map),
    };
    assemble(report, about, map, tracks)
}

/// Says what holds of the whole log.
fn report_log(report: &Report, path: &Path, log: &Log) {
    let mut beside = path.as_os_str().to_os_string();
    beside.push("-wal");
    let beside = Path::new(&beside);
    if beside.metadata().is_ok_and(|found| found.len() > 0) {
        report.at("").warn(format!(
            "{} holds newer rows, which are not read; open the log with SQLite once, to write them into it",
            beside.display()
        ));
    }
    report.note(format!(
        "steps are the sweeps of the lidar, {} s; the ego is the vehicle that recorded, a Chrysler Pacifica of 5.176 m × 2.297 m, 1.461 m ahead of its rear axle, which the log tells the places of",
        log.time_step
    ));
    report.note(format!(
        "tracks are numbered from {} by the rows of table track; the ego is {EGO}",
        EGO + 1
    ));
    let zone = log
        .system
        .and_then(geopackage::zone)
        .map_or_else(String::new, |(zone, south)| {
            format!(" in UTM zone {zone}{}", if south { "S" } else { "N" })
        });
    let (east, north) = log.origin;
    report.note(format!(
        "coordinates are relative to east {east}, north {north}{zone}"
    ));
}

/// The map around the traffic.
fn map(
    report: &Report,
    file: &Path,
    log: &Log,
    lights: &Lights,
    tracks: &[RecordedTrack],
    ids: &mut Ids,
) -> Result<Map, ReadError> {
    let layers = layers::cached_map(file)?;
    layers.leftovers.report_to(report);
    if let Some(zone) = log.system.and_then(geopackage::zone)
        && zone != layers.zone
    {
        let message = format!(
            "the log is in UTM zone {}, its map {} in zone {}; is it the map of another place?",
            zone.0,
            file.display(),
            layers.zone.0
        );
        return Err(report.fail(message));
    }
    let states = tracks.iter().flat_map(|track| &track.states);
    let Some(mut around) = Bounds::from_points(states.map(|state| &state.position)) else {
        return Ok(Map::default());
    };
    let room = Vector::new(MAP_MARGIN, MAP_MARGIN);
    (around.min, around.max) = (around.min - room, around.max + room);
    let mut cut = LaneSection::around(report, &layers, &around, log.origin, ids);
    if cut.all.is_empty() {
        report.at("").warn(format!(
            "no lane of the map {} is within {MAP_MARGIN} m of the traffic; is it the map of another place?",
            file.display()
        ));
    }
    let country = Signs::for_map(&log.map);
    let mut map = Map {
        signs: junctions::speed_limits(&mut cut, &country, ids),
        ..Map::default()
    };
    let stops = junctions::stop_signs(report, &mut cut, &country, ids);
    map.signs.extend(stops);
    map.lights = junctions::lights(report, &mut cut, lights, ids);
    map.intersections = junctions::intersections(&mut cut, ids);
    let crossings = cut.crossings(report, &around, ids);
    let lanes = cut.all.into_iter().map(|placed| placed.lanelet);
    map.lanelets = lanes.chain(crossings).collect();
    Ok(map)
}

/// A name such as `USA_NuplanLasVegas1633000000-1_1_T-681`: place, log, ego, and the first sweep.
fn benchmark_id(log: &Log, ego: i64, first: usize) -> String {
    let mut words = log.map.split(|c: char| !c.is_ascii_alphanumeric());
    let country = match words.next() {
        Some("us") => "USA",
        Some("sg") => "SGP",
        _ => "ZAM",
    };
    // `us-nv-…` begins with the state.
    let skipped = usize::from(country == "USA");
    let place = words.skip(skipped).map(|word| {
        let (first, rest) = word.split_at(word.len().min(1));
        first.to_uppercase() + rest
    });
    let place: String = place.collect::<String>().chars().take(32).collect();
    let began = log.sweeps[0].time / 1_000_000;
    format!(
        "{country}_Nuplan{place}{}-1_{ego}_T-{}",
        began.max(0),
        first + 1
    )
}

/// Of everything that is read.
fn hash(log: &Log, part: &Part, tracks: &[RecordedTrack], map: &Map) -> ContentHash {
    let mut bytes = Vec::new();
    let mut add = |values: &[f64]| bytes.extend(values.iter().flat_map(|v| v.to_le_bytes()));
    for track in tracks {
        add(&[track.id as f64, track.length, track.width]);
        for state in &track.states {
            let velocity = state.velocity.unwrap_or(f64::NAN);
            let (x, y) = (state.position.x, state.position.y);
            add(&[state.step as f64, x, y, state.heading, velocity]);
        }
    }
    let kinds: Vec<_> = tracks.iter().map(|track| track.kind).collect();
    let around = format!(
        "{} {} {} {:?} {kinds:?} {:?} {:?} {:?} {:?}",
        log.map,
        log.time_step,
        part.ego,
        part.sweeps.first(),
        map.lanelets,
        map.signs,
        map.lights,
        map.intersections
    );
    ContentHash::of_parts([&bytes[..], around.as_bytes()])
}

/// The vehicle that records, as a track.
const RECORDER: &str = "ego";

/// So much before the moment of a token belongs to it, seconds.
const BEFORE: f64 = 3.0;

/// So many scenes of a log are named in a message.
const MAX_LISTED: usize = 5;

/// A part of a log.
#[derive(Debug)]
struct Part {
    /// The sweeps, in order.
    sweeps: Vec<usize>,
    /// The id of the ego.
    ego: i64,
}

/// The part that an address names.
///
/// # Errors
/// It names none, or one that is not there.
fn find_part(
    said: &str,
    log: &Log,
    database: &Database,
    report: &Report,
) -> Result<Part, ReadError> {
    if let Some(scene) = said.strip_prefix("scene=") {
        return self::scene(scene, log, report);
    }
    if let Some(token) = token(said) {
        return around(token, said, log, database, report);
    }
    let wanted = WindowRequest::parse(said, report).map_err(|_| {
        report.fail(format!(
            "`{said}` is no part of a log; name ten seconds around a track as `track=ego@34.0s`, a whole track as `track=12`, a scene as `scene=NAME`, or the token of a sweep, a scene or a scenario tag"
        ))
    })?;
    let ego = track(&wanted.track, log, report)?;
    let sweeps = match wanted.start {
        Some(start) => log.between(start, start + windows::LENGTH),
        None if ego == EGO => (0..log.sweeps.len()).collect(),
        None => there(ego, log, database)?,
    };
    if sweeps.is_empty() {
        let message = format!(
            "no sweep in that window; the log takes {:.1} s",
            log.duration()
        );
        return Err(report.fail(message));
    }
    Ok(Part { sweeps, ego })
}

/// A token, as the data set writes them.
fn token(said: &str) -> Option<Token> {
    let is_token = said.len() == 16 && said.bytes().all(|b| b.is_ascii_hexdigit());
    is_token.then(|| Token::from_str_radix(said, 16).ok())?
}

/// The id of a track: by its number or its token.
fn track(said: &str, log: &Log, report: &Report) -> Result<i64, ReadError> {
    let last = id_of(log.tracks.len()) - 1;
    let number = said
        .parse::<i64>()
        .ok()
        .filter(|id| (EGO..=last).contains(id));
    let named = token(said).and_then(|token| log.by_track.get(&token));
    match (said, number, named) {
        (RECORDER, ..) => Ok(EGO),
        (_, Some(id), _) => Ok(id),
        (_, _, Some(place)) => Ok(id_of(*place)),
        _ => Err(report.fail(format!(
            "no track `{said}`; it has {RECORDER}, and tracks {} to {last}",
            EGO + 1
        ))),
    }
}

/// The sweeps from the first to the last one with a track.
fn there(id: i64, log: &Log, database: &Database) -> Result<Vec<usize>, ReadError> {
    let place = usize::try_from(id - EGO - 1).unwrap_or(usize::MAX);
    let Some(track) = log.tracks.get(place) else {
        return Ok(Vec::new());
    };
    let (mut first, mut last) = (usize::MAX, 0);
    let columns = &["token", "lidar_pc_token", "track_token"];
    database.with_token(
        "lidar_box",
        columns,
        "track_token",
        track.token,
        &mut |row| {
            if let Some(sweep) = log.by_sweep.get(&row.token(1)?) {
                (first, last) = (first.min(*sweep), last.max(*sweep));
            }
            Ok(())
        },
    )?;
    Ok((first..=last).collect())
}

fn scene(said: &str, log: &Log, report: &Report) -> Result<Part, ReadError> {
    let found = log
        .scenes
        .iter()
        .find(|(id, name)| name == said || token(said) == Some(*id));
    let Some((id, _)) = found else {
        let names = log
            .scenes
            .iter()
            .take(MAX_LISTED)
            .map(|(_, name)| name.as_str());
        let names: Vec<&str> = names.collect();
        let more = match log.scenes.len() - names.len() {
            0 => String::new(),
            more => format!(" and {more} more"),
        };
        let message = if names.is_empty() {
            format!("no scene `{said}`; it has none")
        } else {
            format!("no scene `{said}`; it has {}{more}", names.join(", "))
        };
        return Err(report.fail(message));
    };
    of_scene(*id, log)
        .ok_or_else(|| report.fail(format!("scene `{said}` has no sweep in table lidar_pc")))
}

fn of_scene(id: Token, log: &Log) -> Option<Part> {
    let sweeps = log
        .sweeps
        .iter()
        .zip(0..)
        .filter_map(|(sweep, place)| (sweep.scene == Some(id)).then_some(place));
    let sweeps: Vec<usize> = sweeps.collect();
    (!sweeps.is_empty()).then_some(Part { sweeps, ego: EGO })
}

/// What is around a sweep or a tag of one; or a scene.
fn around(
    id: Token,
    said: &str,
    log: &Log,
    database: &Database,
    report: &Report,
) -> Result<Part, ReadError> {
    if let Some(scene) = of_scene(id, log) {
        return Ok(scene);
    }
    let mut sweep = log.by_sweep.get(&id).copied();
    if sweep.is_none() && database.has("scenario_tag") {
        let columns = &["token", "lidar_pc_token"];
        database.with_token("scenario_tag", columns, "token", id, &mut |row| {
            sweep = log.by_sweep.get(&row.token(1)?).copied();
            Ok(())
        })?;
    }
    let Some(sweep) = sweep else {
        let message =
            format!("no sweep, scene or scenario tag with a sweep has the token `{said}`");
        return Err(report.fail(message));
    };
    let start = (log.seconds(sweep) - BEFORE)
        .min(log.duration() - windows::LENGTH)
        .max(0.0);
    Ok(Part {
        sweeps: log.between(start, start + windows::LENGTH),
        ego: EGO,
    })
}
