//! `nearmiss corpus index`: measures every window of every pair of road users, a row each in Parquet parts.

pub use super::corpus::{Show, ShowDocument, show};

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use nearmiss_formats::Entry;
use nearmiss_scene::corpus::IndexOptions;
use nearmiss_scene::metrics::{Measure, Thresholds, measures, own_formulas};
use nearmiss_settings::Folders;
use nearmiss_workflow::INDEX_RADIUS;
use nearmiss_workflow::journal::RunSettings;
use nearmiss_workflow::tables::{
    INDEX_MEASURES, default_index_options, in_order, index_table, window_rows,
};
use serde::Serialize;

use super::ending::interrupted;
use super::many_files::ManyFiles;
use super::open::{found, named_measure, user_thresholds};
use super::output::{self, Format, Row, Target};
use super::parts::{Measured, PartsOutcome, PartsRequest, write};
use super::stream::TableStream;
use super::{Failure, Outcome};

/// Arguments of `corpus index`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
The index is a folder of Parquet files with one row per window. `nearmiss corpus show FOLDER` counts the windows, \
`nearmiss corpus sample FOLDER` draws a sample.")]
pub struct Index {
    /// Scenario files, folders or names of bundled scenarios.
    #[arg(required = true)]
    paths: Vec<PathBuf>,
    /// Index folder; created if missing. With - the windows are printed as an Arrow IPC stream.
    #[arg(short, long, value_name = "FOLDER")]
    output: PathBuf,
    /// Start over in a folder with an earlier run.
    #[arg(long)]
    overwrite: bool,
    #[command(flatten)]
    many: ManyFiles,
    /// Window length in seconds.
    #[arg(long, value_name = "S", default_value_t = default_index_options().length, value_parser = positive)]
    length: f64,
    /// Time between the starts of consecutive windows in seconds.
    #[arg(long, value_name = "S", default_value_t = default_index_options().stride, value_parser = positive)]
    stride: f64,
    /// Leave out pairs whose centres stay farther apart than this throughout a window, in metres.
    #[arg(long, value_name = "M", default_value_t = INDEX_RADIUS, value_parser = positive)]
    radius: f64,
    /// Measures of each window, separated by commas, or `all`; `nearmiss metrics --list` lists them. The risk score is
    /// always included.
    #[arg(
        long,
        value_name = "MEASURE",
        value_delimiter = ',',
        default_value = INDEX_MEASURES,
        value_parser = named
    )]
    measure: Vec<Named>,
}

/// A measure, or all of them.
#[derive(Debug, Clone, Copy)]
enum Named {
    One(&'static Measure),
    All,
}

/// Scenarios in a part. One of them may have thousands of windows.
const PER_PART: usize = 16;

fn named(word: &str) -> Result<Named, String> {
    match word {
        "all" => Ok(Named::All),
        _ => named_measure(word).map(Named::One),
    }
}

fn positive(word: &str) -> Result<f64, String> {
    let number = word.parse::<f64>().ok();
    number
        .filter(|n| n.is_finite() && *n > 0.0)
        .ok_or_else(|| "expected a positive number".into())
}

impl Index {
    /// The measures, each once, in the order of columns.
    fn measures(&self) -> Vec<&'static Measure> {
        if self.measure.iter().any(|named| matches!(named, Named::All)) {
            return measures().collect();
        }
        let ids = self.measure.iter().filter_map(|named| match named {
            Named::One(one) => Some(one.id),
            Named::All => None,
        });
        in_order(&ids.collect::<Vec<_>>())
    }
}

/// Everything that changes the windows, apart from the scenarios.
#[derive(Serialize)]
struct IndexSettings<'a> {
    length: f64,
    stride: f64,
    radius: f64,
    measures: Vec<&'a str>,
    /// What the user's measures are, where some are among them.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    own_measures: Vec<String>,
    /// What the user's file changes.
    thresholds: Vec<String>,
    /// That parts have events: those of earlier ones have none.
    events: bool,
}

/// The index of a folder.
pub fn request<'a>(
    folder: &'a Path,
    many: ManyFiles,
    overwrite: bool,
    options: &IndexOptions,
    thresholds: &Thresholds,
) -> Result<PartsRequest<'a>, Failure> {
    let has_own = options.measures.iter().any(|m| m.formula().is_some());
    let settings = IndexSettings {
        length: options.length,
        stride: options.stride,
        radius: options.radius,
        measures: options.measures.iter().map(|measure| measure.id).collect(),
        own_measures: if has_own { own_formulas() } else { Vec::new() },
        thresholds: thresholds.change_words(),
        events: true,
    };
    Ok(PartsRequest {
        command: "index",
        folder,
        many,
        overwrite,
        table: index_table(options, thresholds),
        settings: RunSettings::new(&settings).map_err(Failure::input)?,
        per_part: PER_PART,
        notes: Some("driven"),
    })
}

/// The windows of a scenario.
pub fn measured(entry: &Entry, options: &IndexOptions, thresholds: &Thresholds) -> Measured {
    let scenario = match entry.read() {
        Ok(scenario) => scenario,
        Err(error) => {
            return Measured {
                said: Vec::new(),
                rows: Err(Failure::input(error)),
                note: None,
            };
        }
    };
    let mut said = Vec::new();
    // The pairs of obstacles are worth measuring without it.
    let recorded = entry.recorded_ego(&scenario).unwrap_or_else(|error| {
        said.push(format!("nearmiss: {error}; indexed without this ego"));
        None
    });
    let (rows, driven) = window_rows(entry, &scenario, recorded, options, thresholds);
    let (rows, note) = match serde_json::to_value(driven) {
        Ok(note) => (Ok(rows), Some(note)),
        Err(error) => (Err(Failure::input(error)), None),
    };
    Measured { said, rows, note }
}

/// Runs `corpus index`.
pub fn run(arguments: &Index) -> Outcome {
    let thresholds = match Folders::find() {
        Ok(folders) => user_thresholds(&folders)?,
        Err(_) => Thresholds::shipped().clone(),
    };
    let entries = arguments.many.part.of(found(&arguments.paths)?);
    let options = IndexOptions {
        length: arguments.length,
        stride: arguments.stride,
        radius: arguments.radius,
        measures: arguments.measures(),
    };
    let Some(folder) = output::file_of(Some(&arguments.output)) else {
        return printed(arguments, &entries, &options, &thresholds);
    };
    let stop = interrupted(true);
    let request = request(
        folder,
        arguments.many,
        arguments.overwrite,
        &options,
        &thresholds,
    )?;
    let (pairs, throughput) = (AtomicU64::new(0), Throughput::begin());
    let done = write(request, &entries, &stop, |entry| {
        let measured = measured(entry, &options, &thresholds);
        if let Ok(rows) = &measured.rows {
            pairs.fetch_add(count_pairs(rows), Ordering::Relaxed);
        }
        measured
    })?;
    throughput.say(&done, pairs.into_inner());
    done.end("indexed")
}

/// Writes the windows to standard output, as a stream of Arrow.
fn printed(
    arguments: &Index,
    entries: &[Entry],
    options: &IndexOptions,
    thresholds: &Thresholds,
) -> Outcome {
    if arguments.many.resume || arguments.overwrite {
        return Err(Failure::input(
            "--resume and --overwrite need a folder: -o FOLDER",
        ));
    }
    output::check_format(Format::Arrow, None)?;
    let stream = TableStream {
        table: &index_table(options, thresholds),
        format: Format::Arrow,
        file: None,
        done: "indexed",
    };
    let (target, stop) = (Target::begin(None, false)?, interrupted(false));
    stream.write(
        target,
        entries,
        &stop,
        |entry| measured(entry, options, thresholds),
        || {},
    )
}

/// How many pairs the rows are of; those of a pair stand together.
fn count_pairs(rows: &[Row]) -> u64 {
    let pair = |row: &Row| (row[3].clone(), row[4].clone(), row[5].clone());
    let mut last = None;
    let mut count = 0;
    for row in rows {
        let this = Some(pair(row));
        count += u64::from(this != last);
        last = this;
    }
    count
}

/// The time since the beginning.
struct Throughput {
    begun: Instant,
}

impl Throughput {
    /// Begins to count.
    fn begin() -> Self {
        Self {
            begun: Instant::now(),
        }
    }

    /// Says what was done in which time.
    fn say(&self, done: &PartsOutcome, pairs: u64) {
        let seconds = self.begun.elapsed().as_secs_f64();
        let rate = done.new_rows as f64 / seconds.max(1e-3);
        let kept = match done.kept_rows {
            0 => String::new(),
            kept => format!("; {kept} windows of an earlier run kept"),
        };
        output::say(&format!(
            "nearmiss: {} windows of {pairs} pairs in {seconds:.1} s: {rate:.0} windows a second{kept}",
            done.new_rows
        ));
    }
}
