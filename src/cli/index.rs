//! `nearmiss corpus index`: measures every window of every pair of road users, a row each in Parquet parts.

pub use super::corpus::{Show, ShowDocument, show};

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use nearmiss_formats::Entry;
use nearmiss_scene::corpus::{IndexOptions, IndexedWindow, WindowEgo, for_each_window};
use nearmiss_scene::metrics::{
    Measure, SEVERITY_NAMES, Thresholds, measure, measures, own_formulas,
};
use nearmiss_scene::scenario::Scenario;
use nearmiss_settings::Folders;
use nearmiss_workflow::INDEX_RADIUS;
use nearmiss_workflow::journal::RunSettings;
use serde::Serialize;
use serde_json::{Value, json};

use super::ending::interrupted;
use super::many_files::ManyFiles;
use super::metrics::rounded;
use super::open::{found, named_measure, user_thresholds};
use super::output::{self, Cell, Column, Kind, Row, Table};
use super::parts::{Measured, PartsOutcome, PartsRequest, write};
use super::{Failure, Outcome};

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
        default_value = DEFAULT_MEASURES,
        value_parser = named
    )]
    measure: Vec<Named>,
}

/// Length of a window and of the stride to the next, seconds, unless others are said.
const LENGTH: f64 = 2.0;

const STRIDE: f64 = 1.0;

/// The measures of a window unless others are named.
const DEFAULT_MEASURES: &str = "distance,risk,ttc,ttc_lane,drac,time_gap,btn,stn,pet,rss_margin";

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
    /// The measures, each once, in the order of the registry.
    fn measures(&self) -> Vec<&'static Measure> {
        let wanted = |m: &&Measure| {
            self.measure.iter().any(|named| match named {
                Named::One(one) => one.id == m.id,
                Named::All => true,
            })
        };
        measures().filter(wanted).collect()
    }
}

/// What a window is measured by unless something else is said.
pub fn default_options() -> IndexOptions {
    IndexOptions {
        length: LENGTH,
        stride: STRIDE,
        radius: INDEX_RADIUS,
        measures: DEFAULT_MEASURES.split(',').filter_map(measure).collect(),
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
    };
    Ok(PartsRequest {
        command: "index",
        folder,
        many,
        overwrite,
        table: index_table(options, thresholds),
        settings: RunSettings::new(&settings).map_err(Failure::input)?,
        per_part: PER_PART,
    })
}

/// The windows of a scenario.
pub fn measured(entry: &Entry, options: &IndexOptions, thresholds: &Thresholds) -> Measured {
    let (said, rows) = window_rows(entry, options, thresholds);
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
            pairs.fetch_add(count_pairs(rows), Ordering::Relaxed);
        }
        measured
    })?;
    throughput.say(&done, pairs.into_inner());
    done.end("indexed")
}

/// The columns before those of measures.
fn fixed_columns() -> Vec<Column> {
    let text = |name, source| Column::new(name, Kind::Text, "", source);
    let integer = |name, source| Column::new(name, Kind::Integer, "", source);
    let seconds = |name, source| Column::new(name, Kind::Number, "s", source);
    vec![
        text("scenario", "the file's name without its ending"),
        text("file", "path as it was found"),
        text("sha256", "hash of the file"),
        text(
            "ego_source",
            "recorded: the ego beside the scenario; obstacle: one of its obstacles",
        ),
        integer("ego_id", "id of the ego"),
        integer("obstacle_id", "id in the scenario"),
        text("obstacle_type", "type in the scenario"),
        integer("first_step", "first step with both"),
        integer("last_step", "last step with both"),
        seconds("start", "time of the first step"),
        seconds("end", "time of the last step"),
        text("manoeuvre", "what the obstacle does to the ego"),
        text("road", "kind of road under the ego at the last step"),
        integer(
            "severity",
            "severity of the most severe step, 0 (contact) to 5 (none)",
        ),
        text("severity_name", "name of that number"),
        integer("worst_step", "that step"),
    ]
}

/// The table.
fn index_table(options: &IndexOptions, thresholds: &Thresholds) -> Table {
    let measures = options
        .measures
        .iter()
        .map(|m| Column::new(m.id, Kind::Number, m.unit, m.source).optional());
    let mut table = Table::new(
        "windows",
        fixed_columns().into_iter().chain(measures).collect(),
    );
    let columns = table
        .columns
        .iter()
        .map(|c| json!({ "name": c.name, "unit": c.unit, "source": c.source }));
    let changes = json!(thresholds.change_words());
    table.metadata = vec![
        ("version", env!("CARGO_PKG_VERSION").into()),
        ("columns", columns.collect::<Value>().to_string()),
        ("severities", SEVERITY_NAMES.join(",")),
        ("window", options.length.to_string()),
        ("stride", options.stride.to_string()),
        ("radius", options.radius.to_string()),
        ("thresholds_changed", changes.to_string()),
    ];
    table
}

/// The rows of a scenario, and what is doubtful about its ego.
fn window_rows(
    entry: &Entry,
    options: &IndexOptions,
    thresholds: &Thresholds,
) -> (Vec<String>, Result<Vec<Row>, Failure>) {
    let scenario = match entry.read() {
        Ok(scenario) => scenario,
        Err(error) => return (Vec::new(), Err(Failure::input(error))),
    };
    let mut said = Vec::new();
    // The pairs of obstacles are worth measuring without it.
    let recorded = entry.recorded_ego(&scenario).unwrap_or_else(|error| {
        said.push(format!("nearmiss: {error}; indexed without this ego"));
        None
    });
    let recorded_id = recorded.as_ref().map_or(0, |ego| ego.id);
    let mut rows = Vec::new();
    let head: [Cell; 3] = [
        output::visible(&entry.name).into(),
        output::visible(&entry.display()).into(),
        scenario.hash.to_string().into(),
    ];
    let mut take = |window: IndexedWindow| {
        rows.push(window_row(&head, &scenario, &window, recorded_id));
    };
    for_each_window(&scenario, recorded, options, thresholds, &mut take);
    (said, Ok(rows))
}

fn window_row(head: &[Cell; 3], scenario: &Scenario, window: &IndexedWindow, recorded: i64) -> Row {
    let (source, ego) = match window.ego {
        WindowEgo::Recorded => ("recorded", recorded),
        WindowEgo::Obstacle(id) => ("obstacle", id),
    };
    let (first, last) = window.steps;
    let time = |step: i64| Cell::finite(rounded(step as f64 * scenario.dt()));
    let known = [
        source.into(),
        Cell::Integer(ego),
        Cell::Integer(window.obstacle),
        window.kind.into(),
        Cell::Integer(first),
        Cell::Integer(last),
        time(first),
        time(last),
        window.manoeuvre.name().into(),
        window.road.name().into(),
        Cell::Integer(window.severity.into()),
        SEVERITY_NAMES[usize::from(window.severity)].into(),
        Cell::Integer(window.worst_step),
    ];
    let values = window
        .values
        .iter()
        .map(|value| value.map_or(Cell::None(""), |v| Cell::finite(rounded(v))));
    head.iter().cloned().chain(known).chain(values).collect()
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
