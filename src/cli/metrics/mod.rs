//! `nearmiss metrics`: every safety measure of every obstacle at every step, as table, CSV, JSON or Parquet.

mod list;
mod paper;
mod parts;

pub use list::ListDocument;

use std::io;
use std::ops::ControlFlow;
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
use super::many_files::{Failed, Job, ManyFiles};
use super::open::{EgoChoice, found, scene_and_doubts, thresholds_of, user_thresholds};
use super::output::{self, Column, Encoded, OutputFile, Row, Table, TableWriter, Target};
use super::parts::is_folder;
use super::{Failure, Outcome};

/// Arguments of `metrics`.
#[derive(Debug, clap::Args, Serialize)]
pub struct Metrics {
    /// Scenario files, folders or names of bundled scenarios.
    #[arg(required_unless_present = "list")]
    #[serde(skip)]
    paths: Vec<PathBuf>,
    /// List the measures instead: id, unit, dangerous direction, thresholds, name and source. With --scene, list the
    /// measures of whole scenes.
    #[arg(long, conflicts_with_all = ["paths", "output", "radius", "reasons", "ego"])]
    #[serde(skip)]
    list: bool,
    #[command(flatten)]
    #[serde(flatten)]
    ego: EgoChoice,
    /// Definition of the measures.
    #[arg(long, value_enum, default_value = "exact")]
    convention: Convention,
    /// Measure the whole scene: the ego against all obstacles together, one row a step.
    #[arg(long, conflicts_with = "radius")]
    scene: bool,
    /// TOML file of risk levels and limits. It replaces `thresholds.toml` in the configuration folder and overrides the
    /// shipped values. The paper convention ignores it.
    #[arg(long, value_name = "FILE")]
    #[serde(skip)]
    thresholds: Option<PathBuf>,
    /// Leave out obstacles whose centre is farther than this from that of the ego, metres (30 in the paper).
    #[arg(long, value_name = "M", allow_negative_numbers = true, value_parser = radius)]
    radius: Option<f64>,
    /// Add a column MEASURE_reason for each measure: why a value is missing.
    #[arg(long)]
    reasons: bool,
    /// Format of the table [default: from the file name, else csv].
    #[arg(long, value_enum)]
    #[serde(skip)]
    format: Option<Format>,
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
    /// Real bodies, exact geometry, every measure.
    Exact,
    /// The published tables of the paper with their defects: boxes of one size that never turn, headings of 0 at
    /// standstill, accelerations along the axes of the map.
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
    format: output::Format,
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
    /// The format that is named.
    fn asked(&self) -> Option<Format> {
        self.format
    }

    /// The folder for Parquet parts.
    pub fn folder(&self) -> Option<&Path> {
        let asked = self.asked().map(Format::of_table);
        let file = self.output.file();
        file.filter(|file| is_folder(file, asked, self.many))
    }
}

/// Runs `metrics`.
pub fn run(arguments: &Metrics) -> Outcome {
    let file = arguments.output.file();
    let asked = arguments.asked();
    if let Some(folder) = arguments.folder() {
        arguments.spreadsheet.check(false)?;
        return parts::run(arguments, folder);
    }
    let format = Format::chosen(asked, file)?;
    if arguments.list {
        return list::run(arguments, asked);
    }
    if arguments.many.resume {
        return Err(Failure::input(
            "--resume needs a folder for Parquet parts: --format parquet -o FOLDER",
        ));
    }
    let format = format.of_table();
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
        format,
    };
    let mut measures = Measures {
        plan: &plan,
        target: Some(arguments.output.begin()?),
        writer: None,
        failed: Failed::of(entries.len()),
    };
    plan.say_thresholds();
    let mut written = Ok(());
    let done = Job::new("scenarios", &stop)
        .writing_file(file.is_some())
        .run(
            &entries,
            |entry| Some(measure(entry, &plan)),
            |_, (doubts, rows)| {
                doubts.iter().for_each(|doubt| output::say(doubt));
                written = measures.take(rows);
                Ok(match &written {
                    Ok(()) => ControlFlow::Continue(()),
                    Err(_) => ControlFlow::Break(()),
                })
            },
        );
    done.end("no file was written")?;
    let is_empty = measures.failed.all();
    if format == output::Format::Csv && !is_empty {
        let provenance = provenance(rows.thresholds(&plan.thresholds));
        output::say(&format!("nearmiss: {}", provenance.summary()));
    }
    let done = output::written(file, written.and_then(|()| measures.finish()))?;
    // A file without a single scenario in it is not kept.
    if let Some(target) = done.flatten().filter(|_| !is_empty) {
        target.finish()?;
    }
    measures.failed.end("measured")
}

/// Warnings about the ego, and the rows of one scenario.
fn measure(entry: &Entry, plan: &Plan<'_>) -> (Vec<String>, Result<Encoded, Failure>) {
    let (doubts, rows) = measured_rows(entry, plan);
    (
        doubts,
        rows.map(|rows| plan.table.encode(plan.format, rows)),
    )
}

/// The same before the rows are encoded.
fn measured_rows(entry: &Entry, plan: &Plan<'_>) -> (Vec<String>, Result<Vec<Row>, Failure>) {
    let (scene, doubts) = match scene_and_doubts(entry, &plan.ego) {
        Ok(opened) => opened,
        Err(failure) => return (Vec::new(), Err(failure)),
    };
    let rows = plan
        .rows(&RowFile::new(entry, &scene), &scene)
        .map_err(|why| Failure::input(format!("{}: {why}", entry.display())));
    (doubts, rows)
}

/// The table in the making.
struct Measures<'a> {
    plan: &'a Plan<'a>,
    /// Until the first scenario is measured, so that a table of nothing has no header either.
    target: Option<Target>,
    writer: Option<TableWriter>,
    failed: Failed,
}

impl Measures<'_> {
    fn take(&mut self, rows: Result<Encoded, Failure>) -> io::Result<()> {
        let rows = match rows {
            Ok(rows) => rows,
            Err(failure) => {
                self.failed.add(failure);
                return Ok(());
            }
        };
        if let Some(target) = self.target.take() {
            let Plan { format, table, .. } = self.plan;
            self.writer = Some(TableWriter::begin(target, *format, table)?);
        }
        match &mut self.writer {
            Some(writer) => writer.write(rows),
            None => Ok(()),
        }
    }

    /// Everything written, but not yet in its place.
    fn finish(&mut self) -> io::Result<Option<Target>> {
        self.writer.take().map(TableWriter::finish).transpose()
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Format {
    /// CSV with a header.
    Csv,
    /// JSON lines: one object per row.
    #[value(alias = "jsonl")]
    Json,
    /// Apache Parquet with units and sources as metadata; needs a file.
    Parquet,
}

/// What the endings of names ask for.
const ENDINGS: &[(&str, Format)] = &[
    ("csv", Format::Csv),
    ("json", Format::Json),
    ("jsonl", Format::Json),
    ("ndjson", Format::Json),
    ("parquet", Format::Parquet),
];

impl Format {
    /// The format that was asked for, or that the file's name asks for; both must agree.
    fn chosen(asked: Option<Self>, file: Option<&Path>) -> Result<Self, Failure> {
        let known = ".csv, .json, .jsonl, .ndjson and .parquet";
        output::format_of(asked, file, Self::Csv, (ENDINGS, known))
    }

    fn of_table(self) -> output::Format {
        match self {
            Self::Csv => output::Format::Csv,
            Self::Json => output::Format::Json,
            Self::Parquet => output::Format::Parquet,
        }
    }
}
