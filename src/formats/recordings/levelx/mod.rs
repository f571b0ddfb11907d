//! The drone recordings of levelXdata: highD, and inD, rounD, uniD, exiD.
//!
//! `XX_tracks.csv` is the recording; `XX_tracksMeta.csv` and `XX_recordingMeta.csv` lie beside it. A recording takes
//! minutes and is opened in windows around one track.

mod highd;
mod map;
mod meta;
mod rows;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::assembly::{About, RecordedTrack, assemble};
use super::ids::Ids;
use super::report::Report;
use super::sizes;
use super::windows::{self, Looks, Wanted};
use crate::formats::address::Address;
use crate::formats::commonroad::ReadError;
use crate::formats::commonroad::builder::SourceLocation;
use crate::formats::dispatch::Format;
use crate::scenario::{ContentHash, ObstacleType, Scenario};
use meta::{Recording, TrackMeta};
use rows::{Kind, Row};

/// The format.
pub struct LevelX;

/// The end of the names of recordings.
const TRACKS: &str = "_tracks.csv";

/// Moments a second that are looked at for windows.
const LOOKS: f64 = 5.0;

impl Format for LevelX {
    fn recognises(&self, _: &Path, head: &[u8]) -> bool {
        Kind::of(head).is_some()
    }

    fn parts(&self, path: &Path) -> Result<Vec<String>, ReadError> {
        let report = Report::about(path.display().to_string());
        let (recording, tracks) = beside(path, &report)?;
        let mut looks = Looks::default();
        let every = (recording.frame_rate / LOOKS).round().max(1.0) as i64;
        rows::each(path, &report, &mut |row: &Row| {
            if row.frame % every != 0 {
                return Ok(());
            }
            let Some(track) = tracks.get(&row.track) else {
                return Ok(());
            };
            looks.add(row.frame, row.look(track, recording.frame_rate), &report)
        })?;
        let (from, to) = looks.span();
        if to - from <= windows::SHORT {
            return Ok(Vec::new());
        }
        Ok(looks.windows(|track| track.to_string()))
    }

    fn open(&self, address: &Address) -> Result<Scenario, ReadError> {
        let Address { file, part } = address;
        let shown = part.as_ref().map_or_else(String::new, |p| format!("#{p}"));
        let report = Report::about(format!("{}{shown}", file.display()));
        let wanted = part
            .as_ref()
            .map(|p| Wanted::parse(p, &report))
            .transpose()?;
        if wanted.is_none() {
            let windows = self.parts(file)?;
            if let Some(first) = windows.first() {
                return Err(report.fail(format!(
                    "longer than {} s; open a window of it, such as {}#{first} (`nearmiss inspect` of its folder lists {})",
                    windows::SHORT,
                    file.display(),
                    windows.len()
                )));
            }
        }
        scenario(file, report, wanted)
    }
}

/// The file of the same recording whose name ends differently.
fn sibling(path: &Path, end: &str) -> Option<PathBuf> {
    let name = path.file_name()?.to_str()?;
    let prefix = name.strip_suffix(TRACKS)?;
    Some(path.with_file_name(format!("{prefix}{end}")))
}

/// What the files beside a recording tell.
fn beside(
    path: &Path,
    report: &Report,
) -> Result<(Recording, BTreeMap<i64, TrackMeta>), ReadError> {
    let find = |end: &str| {
        sibling(path, end).filter(|file| file.is_file()).ok_or_else(|| {
            report.fail(format!(
                "its `{end}` is not beside it; recordings of levelXdata are XX{TRACKS}, XX_tracksMeta.csv and XX_recordingMeta.csv"
            ))
        })
    };
    let recording = meta::recording(&find("_recordingMeta.csv")?)?;
    let tracks = meta::tracks(&find("_tracksMeta.csv")?, &recording)?;
    Ok((recording, tracks))
}

fn scenario(file: &Path, report: Report, wanted: Option<Wanted>) -> Result<Scenario, ReadError> {
    let (recording, tracks) = beside(file, &report)?;
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
    let mut found: BTreeMap<i64, Vec<Row>> = BTreeMap::new();
    let mut hash = Vec::new();
    let mut extent: Option<(f64, f64)> = None;
    rows::each(file, &report, &mut |row: &Row| {
        let (low, high) = extent.unwrap_or((row.x, row.x));
        extent = Some((low.min(row.x), high.max(row.x)));
        if (frames.0..=frames.1).contains(&row.frame) {
            hash.extend(row.bytes());
            found.entry(row.track).or_default().push(*row);
        }
        Ok(())
    })?;
    let first = match frames.0 {
        i64::MIN => found.values().flatten().map(|r| r.frame).min().unwrap_or(0),
        first => first,
    };
    if let Some(ego) = ego
        && !found.contains_key(&ego)
    {
        return Err(report.fail(format!("track {ego} is not there in that window")));
    }
    let mut ids = Ids::beyond(tracks.keys().copied());
    tracks.keys().for_each(|id| {
        ids.take(*id);
    });
    // Some data sets count from 0, and ids of CommonRoad from 1.
    let first_id = ids.fresh();
    let own = |id: i64| if id == 0 { first_id } else { id };
    if found.contains_key(&0) {
        report.note(format!("track 0 is numbered {first_id}"));
    }
    let mut recorded = Vec::with_capacity(found.len());
    let mut assumed = Vec::new();
    for (id, rows) in found {
        let Some(track) = tracks.get(&id) else {
            report
                .at(format!("track {id}"))
                .warn("not in its _tracksMeta.csv; left out");
            continue;
        };
        recorded.push(self::track(own(id), track, &rows, first, &mut assumed));
    }
    if !assumed.is_empty() {
        report.note(format!(
            "tracks without a size: {}; assumed by class: {}",
            assumed.len(),
            sizes::in_words(assumed)
        ));
    }
    let map = match recording.kind {
        Kind::HighD => highd::map(&report, &recording, extent, &mut ids)?,
        Kind::InD => map::beside(&report, file, &recording, &mut ids)?,
    };
    let number = recording.id.max(0);
    // Windows of several egos may have the same rows, and sizes and lanes are in other files.
    let around = format!(
        "{ego:?} {frames:?} {recording:?} {tracks:?} {:?}",
        map.lanelets
    );
    let ego = ego.map(own);
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
    assemble(report, about, map, recorded)
}

fn track(
    id: i64,
    meta: &TrackMeta,
    rows: &[Row],
    first: i64,
    assumed: &mut Vec<ObstacleType>,
) -> RecordedTrack {
    let (mut length, mut width) = meta.size;
    if length <= 0.0 || width <= 0.0 {
        (length, width) = sizes::usual(meta.kind);
        assumed.push(meta.kind);
    }
    let mut states: Vec<_> = rows.iter().map(|row| row.state(meta, first)).collect();
    states.sort_by_key(|s| s.step);
    states.dedup_by_key(|s| s.step);
    RecordedTrack {
        id,
        kind: meta.kind,
        length,
        width,
        states,
    }
}
