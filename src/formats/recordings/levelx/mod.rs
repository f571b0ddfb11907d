//! The drone recordings of levelXdata: highD, and inD, rounD, uniD, exiD.
//!
//! `XX_tracks.csv` is the recording; `XX_tracksMeta.csv` and `XX_recordingMeta.csv` lie beside it. A recording takes
//! minutes and is opened in windows around one track.

mod map;
mod tables;

use std::collections::{BTreeMap, HashMap};
use std::mem::size_of;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use nearmiss_base::system::FileCache;
use nearmiss_scene::scenario::{ContentHash, ObstacleType, Scenario};

use super::assembly::{self, About, Ids, Map, RecordedTrack, assemble};
use super::windows::{LongRecording, WindowRequest};
use super::{Report, report_of, windows};
use crate::commonroad::ReadError;
use crate::commonroad::builder::SourceLocation;
use crate::dispatch::{Address, Format, Parts};
use crate::recordings::Leftovers;
use tables::{Kind, Recording, Row, TrackMeta};

pub use tables::missing_columns;

/// The format.
pub struct LevelX;

/// The end of the names of recordings.
const TRACKS: &str = "_tracks.csv";

impl Format for LevelX {
    fn recognises(&self, _: &Path, head: &[u8]) -> bool {
        Kind::detect(head).is_some()
    }

    fn parts(&self, path: &Path) -> Result<Parts, ReadError> {
        let recorded = cached_recording(path)?;
        if !recorded.is_long() {
            return Ok(Parts::One);
        }
        let report = Report::about(path.display().to_string());
        Ok(Parts::Long(Box::new(long_recording(&recorded, report)?)))
    }

    fn open(&self, address: &Address) -> Result<Scenario, ReadError> {
        let (file, report) = (&address.file, report_of(address));
        let wanted = WindowRequest::of(address, &report)?;
        let recorded = cached_recording(file)?;
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
fn long_recording(recorded: &Recorded, report: Report) -> Result<LongRecording, ReadError> {
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
    let own = OwnIds::new(recorded);
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
    let about = About::bare(
        recorded.recording.kind.source(),
        recorded.recording.kind.prefix(),
        every as f64 / rate,
    );
    let scenario = assemble(report, about, Map::default(), tracks)?;
    Ok(LongRecording::new(scenario, names, first as f64 / rate))
}

/// Ids of tracks in a scenario: some data sets count from 0, and ids of CommonRoad from 1.
struct OwnIds {
    ids: Ids,
    zero: i64,
}

impl OwnIds {
    fn new(recorded: &Recorded) -> Self {
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
    wanted: Option<WindowRequest>,
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
    recorded.leftovers.report_to(&report);
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
    let mut own = OwnIds::new(recorded);
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
            assembly::in_words(assumed)
        ));
    }
    let map = match recording.kind {
        Kind::HighD => map::map(&report, recording, recorded.extent, &mut own.ids)?,
        Kind::InD => map::read_map(&report, file, recording, &mut own.ids)?,
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
        (length, width) = assembly::default_size(meta.kind);
        assumed.push(meta.kind);
    }
    let mut states: Vec<_> = rows.iter().map(|row| row.state(meta, steps)).collect();
    let name = || format!("track {id}");
    super::rows::once(report, name, &mut states, |s| s.step, |s| s.position);
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

/// Rows of recordings that are kept, bytes: a recording of a quarter of an hour has about 50 MB.
const MAX_CACHED: usize = 512 << 20;

/// No recording has more rows.
const MOST_ROWS: usize = 10_000_000;

/// Rows whose frames are known together.
const CHUNK: usize = 1024;

static RECORDINGS: FileCache<Recorded> = FileCache::new(MAX_CACHED);

/// What the three files of a recording tell.
#[derive(Debug)]
struct Recorded {
    pub recording: Recording,
    pub tracks: BTreeMap<i64, TrackMeta>,
    /// The tracks, spelled out for hashes.
    pub tracks_in_words: String,
    /// In the order of the file.
    rows: Vec<Row>,
    /// First and last frame of every [`CHUNK`] of them.
    chunks: Vec<(i64, i64)>,
    /// From where to where there is traffic, metres.
    pub extent: Option<(f64, f64)>,
    /// Numbers of the rows with a decimal comma.
    pub commas: usize,
    /// What stands in the tables and is not used.
    pub leftovers: Leftovers,
}

/// A recording, with the files beside it.
///
/// # Errors
/// One of the files is missing or damaged: with its row and column.
fn cached_recording(path: &Path) -> Result<Arc<Recorded>, ReadError> {
    let report = Report::about(path.display().to_string());
    let find = |end: &str| {
        sibling(path, end).filter(|file| file.is_file()).ok_or_else(|| {
            report.fail(format!(
                "its `{end}` is not beside it; recordings of levelXdata are XX{TRACKS}, XX_tracksMeta.csv and XX_recordingMeta.csv"
            ))
        })
    };
    let (about, tracks) = (find("_recordingMeta.csv")?, find("_tracksMeta.csv")?);
    RECORDINGS.get(&[path, &about, &tracks], || {
        let mut leftovers = Leftovers::default();
        let recording = tables::recording(&about, &mut leftovers)?;
        let tracks = tables::tracks(&tracks, &recording, &mut leftovers)?;
        let recorded = Recorded::read(path, &report, recording, tracks, leftovers)?;
        let size = recorded.size();
        Ok((recorded, size))
    })
}

/// The file of the same recording whose name ends differently.
fn sibling(path: &Path, end: &str) -> Option<PathBuf> {
    let name = path.file_name()?.to_str()?;
    let prefix = name.strip_suffix(TRACKS)?;
    Some(path.with_file_name(format!("{prefix}{end}")))
}

impl Recorded {
    fn read(
        path: &Path,
        report: &Report,
        recording: Recording,
        tracks: BTreeMap<i64, TrackMeta>,
        mut leftovers: Leftovers,
    ) -> Result<Self, ReadError> {
        let mut rows = Vec::new();
        let mut extent: Option<(f64, f64)> = None;
        let commas = tables::each(path, report, &mut leftovers, &mut |row: &Row| {
            if rows.len() == MOST_ROWS {
                return Err(report.fail(format!("more than {MOST_ROWS} rows")));
            }
            let (low, high) = extent.unwrap_or((row.x, row.x));
            extent = Some((low.min(row.x), high.max(row.x)));
            rows.push(*row);
            Ok(())
        })?;
        rows.shrink_to_fit();
        let chunks = rows.chunks(CHUNK).map(|chunk| {
            let frames = chunk.iter().map(|row| row.frame());
            frames.fold((i64::MAX, i64::MIN), |(a, b), f| (a.min(f), b.max(f)))
        });
        Ok(Self {
            chunks: chunks.collect(),
            tracks_in_words: format!("{tracks:?}"),
            recording,
            tracks,
            rows,
            extent,
            commas,
            leftovers,
        })
    }

    /// Bytes.
    fn size(&self) -> usize {
        self.rows.len() * size_of::<Row>() + self.tracks_in_words.len() * 2
    }

    /// The rows from one frame to another, in the order of the file.
    pub fn rows(&self, frames: (i64, i64)) -> impl Iterator<Item = &Row> {
        let chunks = self.rows.chunks(CHUNK).zip(&self.chunks);
        let here = chunks.filter(move |(_, (first, last))| *first <= frames.1 && *last >= frames.0);
        let rows = here.flat_map(|(rows, _)| rows);
        rows.filter(move |row| (frames.0..=frames.1).contains(&row.frame()))
    }

    /// The first and last frame; nothing where there are no rows.
    pub fn frames(&self) -> Option<(i64, i64)> {
        let all = self.chunks.iter().copied();
        all.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
    }

    /// Whether it is listed as windows.
    pub fn is_long(&self) -> bool {
        self.frames().is_some_and(|(first, last)| {
            (last - first) as f64 / self.recording.frame_rate > windows::MAX_WHOLE_SECONDS
        })
    }
}
