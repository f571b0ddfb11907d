//! Tables in parts: a folder of Parquet files with one schema, which a run that was killed continues.
//!
//! The layout is `FOLDER/shard=I-of-N/part-00000.parquet`: each machine writes its own folder, and DuckDB, Polars and
//! Spark read all of them as one table. A part has the rows of [`PartsRequest::per_part`] scenarios and is there whole
//! or not at all.

mod writer;

use std::ops::ControlFlow;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use super::interrupt::INTERRUPTED;
use super::many_files::ManyFiles;
use super::output::{self, Format, Row, Table};
use super::parallel::in_order;
use super::progress::Progress;
use super::{Failure, Outcome};
use nearmiss_formats::Entry;
use nearmiss_scene::scenario::ContentHash;
use nearmiss_workflow::journal::input_hash;
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
    /// Everything beside the table that changes the rows.
    pub settings: String,
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
#[derive(Debug, Default)]
pub struct PartsOutcome {
    /// Rows that were measured in this run.
    pub new_rows: u64,
    /// Rows of an earlier run.
    pub kept_rows: u64,
    /// Scenarios in all.
    pub scenarios: usize,
    /// Scenarios without rows.
    pub failed: usize,
    /// Why the last of these has none, as far as this run knows.
    pub last: Option<Failure>,
    /// Whether it was interrupted.
    pub interrupted: bool,
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
    let progress = Progress::new(entries.len(), "scenarios", true);
    let mut done = Ok(());
    let mut next = 0;
    in_order(
        entries.len(),
        stop,
        |i| {
            let input = input(&entries[i]);
            let same = known.has(i, &input);
            (input, (!same).then(|| measure(&entries[i])))
        },
        |(input, measured)| {
            let entry = &entries[next];
            next += 1;
            if let Some(measured) = &measured {
                progress.suspend(|| say(measured, entries.len()));
            }
            done = writer.take(entry, input, measured, &measure);
            progress.step();
            match &done {
                Ok(()) => ControlFlow::Continue(()),
                Err(_) => ControlFlow::Break(()),
            }
        },
    );
    drop(progress);
    done?;
    let interrupted = stop.load(Ordering::Relaxed);
    if !interrupted {
        writer.end()?;
    }
    let scenarios = entries.len();
    Ok(PartsOutcome {
        interrupted,
        scenarios,
        ..writer.outcome
    })
}

fn say(measured: &Measured, scenarios: usize) {
    measured.said.iter().for_each(|words| output::say(words));
    if let (Err(failure), 2..) = (&measured.rows, scenarios) {
        failure.say();
    }
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
        if self.interrupted {
            return Err(Failure {
                message:
                    "interrupted; finished parts are kept; the same command with --resume continues"
                        .into(),
                status: INTERRUPTED,
            });
        }
        match self.failed {
            0 => Ok(()),
            1 if self.scenarios == 1 && self.last.is_some() => {
                Err(self.last.unwrap_or_else(|| Failure::input("no scenario")))
            }
            failed if failed == self.scenarios => {
                Err(Failure::input(format!("no scenario could be {done}")))
            }
            failed => Err(Failure::finding(format!(
                "{failed} of {} scenarios could not be {done}",
                self.scenarios
            ))),
        }
    }
}
