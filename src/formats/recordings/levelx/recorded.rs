//! A recording in memory: read once for all windows of it.

use std::collections::BTreeMap;
use std::mem::size_of;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::TRACKS;
use super::meta::{self, Recording, TrackMeta};
use super::rows::{self, Row};
use crate::commonroad::ReadError;
use crate::recordings::leftovers::Leftovers;
use crate::recordings::report::Report;
use crate::recordings::windows;
use nearmiss_base::system::FileCache;

/// Rows of recordings that are kept, bytes: a recording of a quarter of an hour has about 50 MB.
const KEPT: usize = 512 << 20;

/// No recording has more rows.
const MOST_ROWS: usize = 10_000_000;

/// Rows whose frames are known together.
const CHUNK: usize = 1024;

static RECORDINGS: FileCache<Recorded> = FileCache::new(KEPT);

/// What the three files of a recording tell.
#[derive(Debug)]
pub struct Recorded {
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
pub fn of(path: &Path) -> Result<Arc<Recorded>, ReadError> {
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
        let recording = meta::recording(&about, &mut leftovers)?;
        let tracks = meta::tracks(&tracks, &recording, &mut leftovers)?;
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
        let commas = rows::each(path, report, &mut leftovers, &mut |row: &Row| {
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
            (last - first) as f64 / self.recording.frame_rate > windows::SHORT
        })
    }
}
