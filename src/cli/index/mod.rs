//! `nearmiss corpus index`: measures every window of every pair of road users, in Parquet parts.

mod rows;
mod show;
mod throughput;

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use serde::Serialize;

use super::interrupt::interrupted;
use super::many_files::ManyFiles;
use super::open::{found, user_thresholds};
use super::parts::{Measured, PartsRequest, write};
use super::{Failure, Outcome, output};
use nearmiss_base::system::unknown;
use nearmiss_formats::Entry;
use nearmiss_scene::corpus::IndexOptions;
use nearmiss_scene::metrics::{MEASURES, Measure, Thresholds, measure};
use nearmiss_settings::Folders;
use nearmiss_workflow::INDEX_RADIUS;
use nearmiss_workflow::journal::RunSettings;
pub use show::{Show, ShowDocument, run as show};
use throughput::Throughput;

/// Arguments of `corpus index`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
The index is a folder of Parquet parts with a row for each window; `nearmiss corpus show FOLDER` prints its table, \
`nearmiss corpus sample FOLDER` draws from it.")]
pub struct Index {
    /// Scenario files, folders or names of bundled scenarios.
    #[arg(required = true)]
    paths: Vec<PathBuf>,
    /// Folder of the index; created if missing.
    #[arg(short, long, value_name = "FOLDER")]
    output: PathBuf,
    /// Start again in a folder with an earlier run.
    #[arg(long)]
    overwrite: bool,
    #[command(flatten)]
    many: ManyFiles,
    /// Length of a window, seconds.
    #[arg(long, value_name = "S", default_value_t = LENGTH, value_parser = positive)]
    length: f64,
    /// Seconds from the start of a window to that of the next.
    #[arg(long, value_name = "S", default_value_t = STRIDE, value_parser = positive)]
    stride: f64,
    /// Leave out pairs whose centres are farther apart throughout a window, metres.
    #[arg(long, value_name = "M", default_value_t = INDEX_RADIUS, value_parser = positive)]
    radius: f64,
    /// Measures of each window, separated by commas, or `all`; `nearmiss metrics --list` lists them. The risk score is
    /// always measured.
    #[arg(
        long,
        value_name = "MEASURE",
        value_delimiter = ',',
        default_value = USUAL,
        value_parser = named
    )]
    measure: Vec<Named>,
}

/// Length of a window and of the stride to the next, seconds, unless others are said.
const LENGTH: f64 = 2.0;
const STRIDE: f64 = 1.0;

/// The measures of a window unless others are named.
const USUAL: &str = "distance,risk,ttc,ttc_lane,drac,time_gap,btn,stn,pet,rss_margin";

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
        _ => measure(word).map(Named::One).ok_or_else(|| {
            let unknown = unknown("measure", word, MEASURES.iter().map(|m| m.id));
            format!("{unknown}\n`nearmiss metrics --list` lists all")
        }),
    }
}

fn positive(word: &str) -> Result<f64, String> {
    let number = word.parse::<f64>().ok();
    number
        .filter(|n| n.is_finite() && *n > 0.0)
        .ok_or_else(|| "expected a positive number".into())
}

impl Index {
    /// The measures, each once, in the order of the registry.
    fn measures(&self) -> Vec<&'static Measure> {
        let wanted = |m: &&Measure| {
            self.measure.iter().any(|named| match named {
                Named::One(one) => one.id == m.id,
                Named::All => true,
            })
        };
        MEASURES.iter().filter(wanted).collect()
    }
}

/// What a window is measured by unless something else is said.
pub fn usual() -> IndexOptions {
    IndexOptions {
        length: LENGTH,
        stride: STRIDE,
        radius: INDEX_RADIUS,
        measures: USUAL.split(',').filter_map(measure).collect(),
    }
}

/// Everything that changes the windows, apart from the scenarios.
#[derive(Serialize)]
struct IndexSettings<'a> {
    length: f64,
    stride: f64,
    radius: f64,
    measures: Vec<&'a str>,
    /// What the user's file changes.
    thresholds: Vec<String>,
}

/// The index of a folder.
pub fn request<'a>(
    folder: &'a Path,
    many: ManyFiles,
    overwrite: bool,
    options: &IndexOptions,
    thresholds: &Thresholds,
) -> Result<PartsRequest<'a>, Failure> {
    let settings = IndexSettings {
        length: options.length,
        stride: options.stride,
        radius: options.radius,
        measures: options.measures.iter().map(|measure| measure.id).collect(),
        thresholds: thresholds.change_words(),
    };
    Ok(PartsRequest {
        command: "index",
        folder,
        many,
        overwrite,
        table: rows::table(options, thresholds),
        settings: RunSettings::new(&settings).map_err(Failure::input)?,
        per_part: PER_PART,
    })
}

/// The windows of a scenario.
pub fn measured(entry: &Entry, options: &IndexOptions, thresholds: &Thresholds) -> Measured {
    let (said, rows) = rows::measure(entry, options, thresholds);
    Measured { said, rows }
}

/// Runs `corpus index`.
pub fn run(arguments: &Index) -> Outcome {
    let folder = output::file_of(Some(&arguments.output))
        .ok_or_else(|| Failure::input("-o needs a folder"))?;
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
            pairs.fetch_add(rows::pairs(rows), Ordering::Relaxed);
        }
        measured
    })?;
    throughput.say(&done, pairs.into_inner());
    done.end("indexed")
}
