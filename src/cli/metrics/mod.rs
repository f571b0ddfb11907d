//! `nearmiss metrics`: every safety measure of every obstacle at every step, as CSV, JSON, Parquet or Arrow.

pub(crate) mod list;
mod paper;
mod parts;

pub use list::ListDocument;

use std::path::{Path, PathBuf};

use nearmiss_formats::{EgoSelection, Entry};
use nearmiss_scene::metrics::{Context, Thresholds, measures};
use nearmiss_scene::scenario::Scene;
use nearmiss_settings::Folders;
use nearmiss_workflow::tables::{
    RowFile, exact_columns, exact_rows, measure_table, provenance, scene_columns, scene_rows,
};
use serde::Serialize;

use super::ending::interrupted;
use super::files::Inputs;
use super::many_files::ManyFiles;
use super::open::{EgoChoice, found, scene_and_doubts, thresholds_of, user_thresholds};
use super::output::{self, Column, OutputFile, Row, Table, TableFormat};
use super::parts::{Measured, is_folder};
use super::stream::TableStream;
use super::{Failure, Outcome};

/// Arguments of `metrics`.
#[derive(Debug, clap::Args, Serialize)]
pub struct Metrics {
    /// Scenario files, folders or names of bundled scenarios.
    #[arg(required_unless_present = "list")]
    #[serde(skip)]
    paths: Vec<PathBuf>,
    /// List the measures of pairs, or with --scene of whole scenes: id, unit, dangerous direction, thresholds, name and
    /// source.
    #[arg(long, conflicts_with_all = ["paths", "output", "radius", "reasons", "ego"])]
    #[serde(skip)]
    list: bool,
    #[command(flatten)]
    #[serde(flatten)]
    ego: EgoChoice,
    /// Definition of the measures.
    #[arg(long, value_enum, default_value = "exact")]
    convention: Convention,
    /// Measure the ego against all obstacles together: one row per time step.
    #[arg(long, conflicts_with = "radius")]
    scene: bool,
    /// TOML file with risk levels and limits
    ///
    /// Replaces `thresholds.toml` of the configuration folder and overrides the built-in values. The paper convention
    /// ignores it.
    #[arg(long, value_name = "FILE")]
    #[serde(skip)]
    thresholds: Option<PathBuf>,
    /// Leave out obstacles whose centre is farther from the ego's than this, in metres (30 in the paper) [default: no
    /// limit].
    #[arg(long, value_name = "M", allow_negative_numbers = true, value_parser = radius)]
    radius: Option<f64>,
    /// Add a column MEASURE_reason for each measure: why a value is missing.
    #[arg(long)]
    reasons: bool,
    /// Output format [default: from the file name, else csv].
    #[arg(long, value_enum)]
    #[serde(skip)]
    format: Option<TableFormat>,
    #[command(flatten)]
    #[serde(skip)]
    spreadsheet: output::ForSpreadsheet,
    #[command(flatten)]
    #[serde(skip)]
    output: OutputFile,
    #[command(flatten)]
    #[serde(skip)]
    many: ManyFiles,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum, strum::IntoStaticStr, Serialize)]
#[serde(rename_all = "lowercase")]
#[strum(serialize_all = "lowercase")]
enum Convention {
    /// Actual body shapes, exact geometry, every measure.
    Exact,
    /// The paper's published tables with their known errors: boxes of one size that never turn, zero headings at
    /// standstill, accelerations along the map axes.
    Paper,
}

/// Contents of the rows.
#[derive(Debug, Clone, Copy)]
enum Rows {
    Exact,
    Scene,
    Paper,
}

impl Rows {
    fn columns(self) -> Vec<Column> {
        match self {
            Self::Exact => exact_columns(&Vec::from_iter(measures())),
            Self::Scene => scene_columns(),
            Self::Paper => paper::columns(),
        }
    }

    /// The thresholds, where they count: those of the paper are fixed.
    fn thresholds(self, thresholds: &Thresholds) -> Option<&Thresholds> {
        (!matches!(self, Self::Paper)).then_some(thresholds)
    }
}

/// Settings of the measurement, the same for every scenario.
struct Plan<'a> {
    arguments: &'a Metrics,
    ego: EgoSelection,
    rows: Rows,
    thresholds: Thresholds,
    table: Table,
}

impl Plan<'_> {
    fn rows(&self, file: &RowFile, scene: &Scene) -> Result<Vec<Row>, String> {
        let radius = self.arguments.radius;
        match self.rows {
            Rows::Exact => {
                let (context, measures) = (
                    Context::under(scene, &self.thresholds),
                    Vec::from_iter(measures()),
                );
                Ok(exact_rows(file, &context, radius, &measures))
            }
            Rows::Scene => Ok(scene_rows(file, scene, &self.thresholds)),
            Rows::Paper => paper::rows(file, scene, radius),
        }
    }

    /// The rows of one scenario, and warnings about its ego.
    fn measured(&self, entry: &Entry) -> Measured {
        let (scene, said) = match scene_and_doubts(entry, &self.ego) {
            Ok(opened) => opened,
            Err(failure) => {
                return Measured {
                    said: Vec::new(),
                    rows: Err(failure),
                    note: None,
                };
            }
        };
        let rows = self.rows(&RowFile::new(entry, &scene), &scene);
        Measured {
            said,
            rows: rows.map_err(|why| Failure::input(format!("{}: {why}", entry.display()))),
            note: None,
        }
    }

    fn say_thresholds(&self) {
        if let Some(said) = self.thresholds.file() {
            output::say(&format!("nearmiss: thresholds from {said}"));
        }
    }
}

/// The kind of rows, and the thresholds for computing them.
fn measured(arguments: &Metrics) -> Result<(Rows, Thresholds), Failure> {
    if arguments.convention == Convention::Paper {
        if arguments.scene {
            return Err(Failure::input(
                "--scene and --convention paper exclude each other: the paper has no measures of whole scenes",
            ));
        }
        if arguments.thresholds.is_some() {
            return Err(Failure::input(
                "--thresholds and --convention paper exclude each other: the paper's thresholds are fixed",
            ));
        }
        return Ok((Rows::Paper, Thresholds::shipped().clone()));
    }
    let thresholds = match (&arguments.thresholds, Folders::find()) {
        (Some(path), _) => thresholds_of(path)?,
        (None, Ok(folders)) => user_thresholds(&folders)?,
        // Without a home folder there are no thresholds of the user.
        (None, Err(_)) => Thresholds::shipped().clone(),
    };
    let rows = if arguments.scene {
        Rows::Scene
    } else {
        Rows::Exact
    };
    Ok((rows, thresholds))
}

fn radius(word: &str) -> Result<f64, String> {
    let metres = word.parse::<f64>().ok();
    metres
        .filter(|m| m.is_finite() && *m > 0.0)
        .ok_or_else(|| "expected a positive number of metres".into())
}

/// The table, with the meaning of its columns.
fn table(arguments: &Metrics, rows: Rows, thresholds: &Thresholds) -> Table {
    let convention = <&str>::from(arguments.convention);
    let has_own = matches!(rows, Rows::Exact);
    let mut table = measure_table(
        rows.columns(),
        convention,
        rows.thresholds(thresholds),
        has_own,
    );
    table.for_spreadsheet = arguments.spreadsheet.is_asked();
    if arguments.reasons {
        table.with_reasons()
    } else {
        table
    }
}

impl Metrics {
    /// The folder for Parquet parts.
    pub fn folder(&self) -> Option<&Path> {
        let asked = self.format.map(output::Format::from);
        let file = self.output.file();
        file.filter(|file| is_folder(file, asked, self.many))
    }
}

/// Runs `metrics`.
pub fn run(arguments: &Metrics) -> Outcome {
    let file = arguments.output.file();
    let asked = arguments.format;
    if let Some(folder) = arguments.folder() {
        arguments.spreadsheet.check(false)?;
        return parts::run(arguments, folder);
    }
    let endings = (TableFormat::ENDINGS, TableFormat::KNOWN);
    let format = output::format_of(asked, file, TableFormat::Csv, endings)?;
    if arguments.list {
        return list::run(arguments, asked);
    }
    if arguments.many.resume {
        return Err(Failure::input(
            "--resume needs a folder for Parquet parts: --format parquet -o FOLDER",
        ));
    }
    let format = format.into();
    output::check_format(format, file)?;
    arguments.spreadsheet.check(format == output::Format::Csv)?;
    let (rows, thresholds) = measured(arguments)?;
    let entries = arguments.many.part.of(found(&arguments.paths)?);
    if entries.is_empty() {
        return Ok(());
    }
    Inputs::of(&entries).spare(file)?;
    // Before the file is begun, so that it never stays behind.
    let stop = interrupted(file.is_some());
    let plan = Plan {
        arguments,
        ego: arguments.ego.wanted(&entries)?,
        rows,
        table: table(arguments, rows, &thresholds),
        thresholds,
    };
    plan.say_thresholds();
    let stream = TableStream {
        table: &plan.table,
        format,
        file,
        done: "measured",
    };
    let target = arguments.output.begin()?;
    stream.write(
        target,
        &entries,
        &stop,
        |entry| plan.measured(entry),
        || {
            if format == output::Format::Csv {
                let provenance = provenance(rows.thresholds(&plan.thresholds));
                output::say(&format!("nearmiss: {}", provenance.summary()));
            }
        },
    )
}
