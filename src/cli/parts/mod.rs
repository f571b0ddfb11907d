//! Tables in parts: a folder of Parquet files with one schema, which a run that was killed continues.
//!
//! The layout is `FOLDER/shard=I-of-N/part-00000.parquet`: each machine writes its own folder, and DuckDB, Polars and
//! Spark read all of them as one table. A part has the rows of [`PartsRequest::per_part`] scenarios and is there whole
//! or not at all.

mod writer;

use std::path::Path;
use std::sync::atomic::AtomicBool;

use super::many_files::{Done, Failed, Job, ManyFiles, NEXT};
use super::output::{self, Format, Row, Table};
use super::{Failure, Outcome};
use nearmiss_formats::Entry;
use nearmiss_scene::scenario::ContentHash;
use nearmiss_workflow::journal::{RunSettings, input_hash};
use writer::PartWriter;

/// Rows that are kept in memory before they are written.
const ROW_GROUP: usize = 16_384;

/// What is written where.
pub struct PartsRequest<'a> {
    /// The command.
    pub command: &'static str,
    /// The folder of -o; it is created.
    pub folder: &'a Path,
    /// The part of the scenarios, and whether a run is continued.
    pub many: ManyFiles,
    /// Start again in a folder with an earlier run.
    pub overwrite: bool,
    /// The table.
    pub table: Table,
    /// Everything that changes the rows, apart from the scenarios.
    pub settings: RunSettings,
    /// Scenarios in a part.
    pub per_part: usize,
}

/// The rows of a scenario.
pub struct Measured {
    /// What is said about it.
    pub said: Vec<String>,
    /// Its rows, or why there are none.
    pub rows: Result<Vec<Row>, Failure>,
}

/// What was done.
#[derive(Debug)]
pub struct PartsOutcome {
    /// Rows that were measured in this run.
    pub new_rows: u64,
    /// Rows of an earlier run.
    pub kept_rows: u64,
    /// Scenarios without rows.
    pub failed: Failed,
    /// How far it came.
    pub done: Done,
}

/// Whether -o names a folder for parts, not a file.
pub fn is_folder(output: &Path, format: Option<Format>, many: ManyFiles) -> bool {
    let ends_so = output.to_string_lossy().ends_with(std::path::is_separator);
    let is_named_so = output.is_dir() || ends_so || output.extension().is_none();
    let wanted = match format {
        Some(format) => format == Format::Parquet,
        None => many.resume || many.part.shard.is_some() || ends_so,
    };
    wanted && is_named_so && output != Path::new("-")
}

/// Measures scenarios in parallel, and writes their rows in parts.
///
/// # Errors
/// The folder belongs to another run, or a part cannot be written.
pub fn write(
    mut request: PartsRequest<'_>,
    entries: &[Entry],
    stop: &AtomicBool,
    measure: impl Fn(&Entry) -> Measured + Sync,
) -> Result<PartsOutcome, Failure> {
    request.table.group = ROW_GROUP;
    let (mut writer, known) = PartWriter::begin(&request, entries)?;
    let places: Vec<(usize, &Entry)> = entries.iter().enumerate().collect();
    let done = Job::new("scenarios", stop).run(
        &places,
        |(place, entry)| {
            let input = input(entry);
            let same = known.has(*place, &input);
            Some((input, (!same).then(|| measure(entry))))
        },
        |(_, entry), (input, measured)| {
            for words in measured.iter().flat_map(|measured| &measured.said) {
                output::say(words);
            }
            writer.take(entry, input, measured, &measure)?;
            NEXT
        },
    );
    writer.end(done)
}

/// The hash of a scenario's input; of one that cannot be read, that of its place.
fn input(entry: &Entry) -> String {
    let content = entry.content_hash();
    input_hash(
        &entry.display(),
        &content.unwrap_or(ContentHash::digest(b"")),
    )
}

impl PartsOutcome {
    /// How the command ends; `done` says what is done with scenarios: measured.
    pub fn end(self, done: &str) -> Outcome {
        self.done
            .end("finished parts are kept; the same command with --resume continues")?;
        self.failed.end(done)
    }
}
