//! The drone recordings of levelXdata: highD, and inD, rounD, uniD, exiD.
//!
//! `XX_tracks.csv` is the recording; `XX_tracksMeta.csv` and `XX_recordingMeta.csv` lie beside it. A recording takes
//! minutes and is opened in windows around one track.

mod highd;
mod map;
mod meta;
mod recorded;
mod rows;

use std::collections::{BTreeMap, HashMap};
use std::path::Path;

use super::assembly::{About, Map, RecordedTrack, assemble};
use super::ids::Ids;
use super::report::Report;
use super::windows::{self, LongRecording, Wanted};
use super::{repeated, sizes};
use crate::address::Address;
use crate::commonroad::ReadError;
use crate::commonroad::builder::SourceLocation;
use crate::dispatch::{Format, Parts};
use meta::TrackMeta;
use nearmiss_scene::scenario::{ContentHash, ObstacleType, Scenario};
use recorded::Recorded;
pub use rows::missing_columns;
use rows::{Kind, Row};

/// The format.
pub struct LevelX;

/// The end of the names of recordings.
const TRACKS: &str = "_tracks.csv";

impl Format for LevelX {
    fn recognises(&self, _: &Path, head: &[u8]) -> bool {
        Kind::of(head).is_some()
    }

    fn parts(&self, path: &Path) -> Result<Parts, ReadError> {
        let recorded = recorded::of(path)?;
        if !recorded.is_long() {
            return Ok(Parts::One);
        }
        let report = Report::about(path.display().to_string());
        Ok(Parts::Long(Box::new(whole(&recorded, report)?)))
    }

    fn open(&self, address: &Address) -> Result<Scenario, ReadError> {
        let Address { file, part } = address;
        let shown = part.as_ref().map_or_else(String::new, |p| format!("#{p}"));
        let report = Report::about(format!("{}{shown}", file.display()));
        let wanted = part
            .as_ref()
            .map(|p| Wanted::parse(p, &report))
            .transpose()?;
        let recorded = recorded::of(file)?;
        if wanted.is_none() && recorded.is_long() {
            let first = recorded.tracks.first_key_value();
            let (track, start) = first.map_or((1, 0.0), |(id, track)| {
                (*id, track.frames.0 as f64 / recorded.recording.frame_rate)
            });
            return Err(windows::too_long(&report, file, &track.to_string(), start));
        }
        scenario(file, report, &recorded, wanted)
    }
}

/// Everyone in a long recording, a few times a second.
fn whole(recorded: &Recorded, report: Report) -> Result<LongRecording, ReadError> {
    let rate = recorded.recording.frame_rate;
    let every = (rate / windows::MOMENTS).round().max(1.0) as i64;
    // Frames that are looked at are multiples, whichever is there first.
    let first = recorded.frames().map_or(0, |(first, _)| first) / every * every;
    let mut found: BTreeMap<i64, Vec<&Row>> = BTreeMap::new();
    for row in recorded.rows((i64::MIN, i64::MAX)) {
        if row.frame() % every == 0 {
            found.entry(row.track()).or_default().push(row);
        }
    }
    let own = OwnIds::of(recorded);
    let mut names = HashMap::with_capacity(found.len());
    let mut tracks = Vec::with_capacity(found.len());
    for (id, rows) in found {
        let Some(meta) = recorded.tracks.get(&id) else {
            continue;
        };
        names.insert(own.id(id), id.to_string());
        tracks.push(track(
            &report,
            own.id(id),
            meta,
            &rows,
            (first, every),
            &mut Vec::new(),
        ));
    }
    let about = About {
        source: recorded.recording.kind.source(),
        benchmark_id: recorded.recording.kind.prefix().to_string(),
        time_step_size: every as f64 / rate,
        tags: Vec::new(),
        ego: None,
        hash: ContentHash::digest(b""),
    };
    let scenario = assemble(report, about, Map::default(), tracks)?;
    Ok(LongRecording::new(scenario, names, first as f64 / rate))
}

/// Ids of tracks in a scenario: some data sets count from 0, and ids of CommonRoad from 1.
struct OwnIds {
    ids: Ids,
    zero: i64,
}

impl OwnIds {
    fn of(recorded: &Recorded) -> Self {
        let mut ids = Ids::beyond(recorded.tracks.keys().copied());
        recorded.tracks.keys().for_each(|id| {
            ids.take(*id);
        });
        let zero = ids.fresh();
        Self { ids, zero }
    }

    fn id(&self, of: i64) -> i64 {
        if of == 0 { self.zero } else { of }
    }
}

fn scenario(
    file: &Path,
    report: Report,
    recorded: &Recorded,
    wanted: Option<Wanted>,
) -> Result<Scenario, ReadError> {
    let Recorded {
        recording, tracks, ..
    } = recorded;
    let rate = recording.frame_rate;
    let mut frames = (i64::MIN, i64::MAX);
    let mut ego = None;
    if let Some(wanted) = &wanted {
        let found = wanted
            .track
            .parse::<i64>()
            .ok()
            .and_then(|id| Some((id, tracks.get(&id)?)));
        let Some((id, track)) = found else {
            let ids: Vec<i64> = tracks.keys().copied().collect();
            let range = match ids[..] {
                [first, .., last] => format!("it has tracks {first} to {last}"),
                _ => "it has no tracks".into(),
            };
            return Err(report.fail(format!("no track `{}`; {range}", wanted.track)));
        };
        ego = Some(id);
        frames = match wanted.start {
            Some(start) => {
                let first = (start * rate).round() as i64;
                (first, first + (windows::LENGTH * rate).round() as i64)
            }
            None => (track.frames.0, track.frames.1),
        };
    }
    recorded.leftovers.tell(&report);
    report.note_count(recorded.commas, |n| {
        format!("numbers with a decimal comma in the recording: {n}; read as with a point")
    });
    let mut found: BTreeMap<i64, Vec<&Row>> = BTreeMap::new();
    let mut hash = Vec::new();
    for row in recorded.rows(frames) {
        hash.extend(row.bytes());
        found.entry(row.track()).or_default().push(row);
    }
    let first = match frames.0 {
        i64::MIN => found
            .values()
            .flatten()
            .map(|r| r.frame())
            .min()
            .unwrap_or(0),
        first => first,
    };
    if let Some(ego) = ego
        && !found.contains_key(&ego)
    {
        return Err(report.fail(format!("track {ego} is not there in that window")));
    }
    let mut own = OwnIds::of(recorded);
    if found.contains_key(&0) {
        report.note(format!("track 0 is numbered {}", own.zero));
    }
    let here = |track: &TrackMeta| track.frames.0 <= frames.1 && track.frames.1 >= frames.0;
    let absent = tracks
        .iter()
        .filter(|(id, track)| here(track) && !found.contains_key(*id));
    let absent: Vec<String> = absent.map(|(id, _)| id.to_string()).collect();
    if !absent.is_empty() {
        report.at("").warn(format!(
            "{} tracks of its _tracksMeta.csv have no row in their frames, such as {}",
            absent.len(),
            absent[0]
        ));
    }
    let mut moving = Vec::with_capacity(found.len());
    let mut assumed = Vec::new();
    for (id, rows) in found {
        let Some(track) = tracks.get(&id) else {
            report
                .at(format!("track {id}"))
                .warn("not in its _tracksMeta.csv; left out");
            continue;
        };
        moving.push(self::track(
            &report,
            own.id(id),
            track,
            &rows,
            (first, 1),
            &mut assumed,
        ));
    }
    if !assumed.is_empty() {
        report.note(format!(
            "tracks without a size: {}; assumed by class: {}",
            assumed.len(),
            sizes::in_words(assumed)
        ));
    }
    let map = match recording.kind {
        Kind::HighD => highd::map(&report, recording, recorded.extent, &mut own.ids)?,
        Kind::InD => map::beside(&report, file, recording, &mut own.ids)?,
    };
    let number = recording.id.max(0);
    // Windows of several egos may have the same rows, and sizes and lanes are in other files.
    let around = format!(
        "{ego:?} {frames:?} {recording:?} {} {:?}",
        recorded.tracks_in_words, map.lanelets
    );
    let ego = ego.map(|id| own.id(id));
    let configuration = ego.unwrap_or(1);
    let about = About {
        source: recording.kind.source(),
        benchmark_id: format!(
            "{}{number}-1_{configuration}_T-{}",
            recording.kind.prefix(),
            first.max(0) + 1
        ),
        time_step_size: 1.0 / rate,
        tags: match recording.kind {
            Kind::HighD => vec!["highway".into(), "multi_lane".into()],
            Kind::InD => vec!["urban".into()],
        },
        ego,
        hash: ContentHash::of_parts([&hash[..], around.as_bytes()]),
    };
    assemble(report, about, map, moving)
}

fn track(
    report: &Report,
    id: i64,
    meta: &TrackMeta,
    rows: &[&Row],
    steps: (i64, i64),
    assumed: &mut Vec<ObstacleType>,
) -> RecordedTrack {
    let (mut length, mut width) = meta.size;
    if length <= 0.0 || width <= 0.0 {
        (length, width) = sizes::usual(meta.kind);
        assumed.push(meta.kind);
    }
    let mut states: Vec<_> = rows.iter().map(|row| row.state(meta, steps)).collect();
    let name = || format!("track {id}");
    repeated::once(report, name, &mut states, |s| s.step, |s| s.position);
    RecordedTrack {
        shape: None,
        is_static: false,
        id,
        kind: meta.kind,
        length,
        width,
        states,
    }
}
