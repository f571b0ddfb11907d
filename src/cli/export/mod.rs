//! `nearmiss export`: writes stored runs to a file.

mod columns;
mod parquet;

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;

use super::filters::{Filters, store_to_read};
use super::interrupt::{INTERRUPTED, interrupted};
use super::metrics::{Target, file_of, no_format};
use super::output::of_csv;
use super::progress::Progress;
use super::{Failure, Outcome, output};
use crate::store::{Run, RunId, Store};

/// Arguments of `export`.
#[derive(Debug, clap::Args)]
pub struct Export {
    #[command(flatten)]
    filters: Filters,
    /// Runs with all these words in scenario, answer, reasoning, justification or notes.
    #[arg(long, value_name = "WORDS")]
    words: Option<String>,
    /// How the runs are written [default: as the ending of FILE says, else jsonl].
    #[arg(long, value_enum)]
    format: Option<Format>,
    /// A file to write to, instead of standard output, which is - too.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Replace the file if it is there already.
    #[arg(long, requires = "output")]
    overwrite: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Format {
    /// One JSON object a line: complete, `nearmiss import` reads it.
    Jsonl,
    /// Comma-separated, with a header; control characters are shown as symbols.
    Csv,
    /// Apache Parquet; into a file only.
    Parquet,
}

impl Format {
    fn of_name(path: &Path) -> Option<Self> {
        match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "jsonl" | "ndjson" | "json" => Some(Self::Jsonl),
            "csv" => Some(Self::Csv),
            "parquet" => Some(Self::Parquet),
            _ => None,
        }
    }
}

/// Runs `export`.
pub fn run(arguments: &Export) -> Outcome {
    let file = file_of(arguments.output.as_deref());
    let format = match (arguments.format, file) {
        (Some(format), _) => format,
        (None, None) => Format::Jsonl,
        (None, Some(file)) => match Format::of_name(file) {
            Some(format) => format,
            // That is said where the file is begun.
            None if file.is_dir() => Format::Jsonl,
            None => return Err(no_format(file, ".jsonl, .ndjson, .json, .csv and .parquet")),
        },
    };
    if format == Format::Parquet && file.is_none() {
        return Err(Failure::input(
            "Parquet is not for terminals and pipes: name a file with -o FILE",
        ));
    }
    let store = store_to_read()?;
    let filter = arguments.filters.filter(arguments.words.clone());
    let numbers = store.numbers(&filter).map_err(Failure::input)?;
    // Before the file is begun, so that it never stays behind.
    let stop = interrupted(file.is_some());
    let target = Target::begin(file, arguments.overwrite)?;
    let progress = Progress::new(numbers.len(), "runs", file.is_some());
    let runs = numbers.iter().map(|number| {
        if stop.load(Ordering::Relaxed) {
            return Err(Failure {
                message: "interrupted; no file was written".into(),
                status: INTERRUPTED,
            });
        }
        progress.step();
        read(&store, *number)
    });
    let written = match format {
        Format::Jsonl => lines(target, runs),
        Format::Csv => table(target, runs),
        Format::Parquet => parquet::write(target, runs),
    };
    drop(progress);
    match (written, file) {
        (Ok(target), _) => target.finish()?,
        // The reader of the pipe has seen enough.
        (Err(Stopped::Writing(error)), None) if error.kind() == io::ErrorKind::BrokenPipe => {}
        (Err(Stopped::Writing(error)), None) => {
            return Err(Failure::system("standard output", &error));
        }
        (Err(Stopped::Writing(error)), Some(path)) => {
            return Err(Failure::system(path.display(), &error));
        }
        (Err(Stopped::Reading(failure)), _) => return Err(failure),
    }
    if file.is_some() {
        output::say(&format!("{} runs exported", numbers.len()));
    }
    Ok(())
}

/// Why an export is not whole.
enum Stopped {
    Reading(Failure),
    Writing(io::Error),
}

impl From<io::Error> for Stopped {
    fn from(error: io::Error) -> Self {
        Self::Writing(error)
    }
}

fn read(store: &Store, number: RunId) -> Result<Option<Run>, Failure> {
    store.run(number).map_err(Failure::input)
}

/// A run; `None` if it is gone meanwhile.
type Item = Result<Option<Run>, Failure>;

/// The runs, one after the other.
type Runs<'a> = &'a mut dyn Iterator<Item = Item>;

fn lines(mut target: Target, mut runs: impl Iterator<Item = Item>) -> Result<Target, Stopped> {
    each(&mut runs, |run| {
        let line = output::escaped(&run.to_record().to_string());
        target.write_all(line.as_bytes())?;
        target.write_all(b"\n")
    })?;
    target.flush()?;
    Ok(target)
}

fn table(target: Target, mut runs: impl Iterator<Item = Item>) -> Result<Target, Stopped> {
    let mut writer = csv::Writer::from_writer(target);
    let header = columns::COLUMNS.iter().map(|column| column.name);
    writer.write_record(header).map_err(of_csv)?;
    each(&mut runs, |run| {
        let cells = columns::cells(&run).map(|cell| output::visible(&cell.text()));
        writer.write_record(cells).map_err(of_csv)
    })?;
    writer.flush()?;
    writer
        .into_inner()
        .map_err(|error| Stopped::Writing(error.into_error()))
}

fn each(runs: Runs<'_>, mut write: impl FnMut(Run) -> io::Result<()>) -> Result<(), Stopped> {
    for run in runs {
        if let Some(run) = run.map_err(Stopped::Reading)? {
            write(run)?;
        }
    }
    Ok(())
}
