//! `nearmiss report`: accuracy of stored or recorded answers, as tables and figures for papers.

mod of_batch;
mod of_store;
pub mod truth;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use nearmiss_render::{Format as PictureFormat, Palette};
use nearmiss_store::{Filter, SplitPart};
use nearmiss_study::evaluation::report::{
    self, AxesDocument, Comparison, Document, FlatRows, Pivot, Report, ReportFigure, SplitReport,
};
use nearmiss_study::evaluation::{AnswerPage, Cluster, PromptConfig, Provenance, Scored};
use nearmiss_study::paper::Paper;

use super::filters::{FilterOption, LAST, last_batch, store_to_read};
use super::gate::{Declared, Gate, both};
use super::output::{self, Format, TableWriter, Target, file_of};
use super::{Failure, Outcome};
use of_batch::PivotOptions;

/// Arguments of `report`.
#[derive(Debug, clap::Args)]
pub struct ReportArguments {
    /// Folder of recorded answers, laid out as the repository of "From Words to Collisions"; replaces the stored runs.
    #[arg(conflicts_with = "paper")]
    folder: Option<PathBuf>,
    /// Compare the recorded answers of such a folder with Tables I to IV of the paper and with the built-in judge.
    #[arg(long, value_name = "FOLDER")]
    paper: Option<PathBuf>,
    #[command(flatten)]
    filters: FilterOption,
    /// Ground truth, separated by commas [default: batch,auto]
    ///
    /// CSV files have the columns `scenario` and `label` or `obstacle_id`. `batch`: the truth of each batch. FOLDER:
    /// scenarios with recorded egos, or annotations. `auto`: the exact geometry of bundled scenarios, and the judge's
    /// stored verdicts on whole recordings. CSV files take precedence, then `batch`, then folders and `auto` in the
    /// given order. `score` or `score:paper`, alone or with folders: the risk score of TTC and MDC, critical up to 1.
    #[arg(
        long,
        value_delimiter = ',',
        value_name = "CSV|batch|auto|score|FOLDER",
        conflicts_with_all = ["folder", "paper"]
    )]
    truth: Vec<PathBuf>,
    /// Parse the stored answers again with this version of nearmiss.
    #[arg(long, conflicts_with_all = ["folder", "paper"])]
    reread: bool,
    /// Show the figures of an incomplete test split; later reports state that it was unlocked.
    #[arg(long, conflicts_with_all = ["folder", "paper"])]
    unlock: bool,
    /// Report only one part of a batch's split: dev or test. Tables over axes and figures need one part.
    #[arg(long, value_name = "PART", conflicts_with_all = ["folder", "paper"])]
    split: Option<SplitPart>,
    /// Clustering unit of intervals and comparisons: scenario, or map with all scenarios of one recording [default: map
    /// for batches with a split, else scenario].
    #[arg(long, value_name = "UNIT", conflicts_with = "paper")]
    cluster: Option<Cluster>,
    /// Also show the figures at this share of dangerous questions, such as 0.01; batches ask about equally many
    /// dangerous and safe windows.
    #[arg(long, value_name = "SHARE", value_parser = share, conflicts_with_all = ["paper", "figure"])]
    prevalence: Option<f64>,
    #[command(flatten)]
    declared: Declared,
    #[command(flatten)]
    pivot: PivotOptions,
    /// Write a figure (.svg or .png) instead of tables: bars, leads, reliability or cost
    ///
    /// bars shows --measure with intervals, with --rows one bar per table cell. cost shows the share of correct answers
    /// against the cost per question.
    #[arg(
        long,
        value_name = "FIGURE",
        conflicts_with_all = ["paper", "against", "format", "pairs"]
    )]
    figure: Option<ReportFigure>,
    #[command(flatten)]
    gate: Gate,
    /// Output format [default: from the file name, else md].
    #[arg(long, value_enum)]
    format: Option<ReportFormat>,
    #[command(flatten)]
    spreadsheet: output::ForSpreadsheet,
    /// File to write; - is standard output [default: standard output].
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// CSV file for the pairwise comparisons of prompt configurations, one per row; other formats include them in the
    /// report.
    #[arg(long, value_name = "FILE")]
    pairs: Option<PathBuf>,
    /// Replace existing files.
    #[arg(long)]
    overwrite: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum ReportFormat {
    /// Markdown tables.
    Md,
    /// LaTeX tables with booktabs rules.
    #[value(alias = "tex")]
    Latex,
    /// CSV: one row per cell, unrounded; --pairs has the comparisons.
    Csv,
    /// Apache Parquet: the rows of CSV, with provenance as metadata.
    Parquet,
    /// Apache Arrow IPC stream, with the same rows and metadata.
    Arrow,
    /// One JSON object with every number.
    #[value(alias = "jsonl")]
    Json,
    /// A self-contained page with tables and figures.
    Html,
}

/// What the endings of names ask for.
const ENDINGS: &[(&str, ReportFormat)] = &[
    ("md", ReportFormat::Md),
    ("markdown", ReportFormat::Md),
    ("tex", ReportFormat::Latex),
    ("csv", ReportFormat::Csv),
    ("parquet", ReportFormat::Parquet),
    ("arrow", ReportFormat::Arrow),
    ("arrows", ReportFormat::Arrow),
    ("json", ReportFormat::Json),
    ("jsonl", ReportFormat::Json),
    ("html", ReportFormat::Html),
    ("htm", ReportFormat::Html),
];

impl ReportFormat {
    /// The format of tables by columns that it is, if any.
    fn by_columns(self) -> Option<Format> {
        match self {
            Self::Parquet => Some(Format::Parquet),
            Self::Arrow => Some(Format::Arrow),
            _ => None,
        }
    }
}

/// A report, of the one kind or the other.
enum AnyReport {
    Report(Box<Report>),
    Split(Box<SplitReport>),
    Paper(Box<Paper>),
    Pivot(Box<Pivot>),
}

/// Runs `report`.
pub fn run(arguments: &ReportArguments) -> Outcome {
    let file = file_of(arguments.output.as_deref());
    let of_folder = arguments.paper.is_some() || arguments.folder.is_some();
    if of_folder && arguments.filters.filter()? != Filter::default() {
        return Err(Failure::input(
            "filters apply to the runs of the store, not to a folder of recorded answers; `nearmiss runs import FOLDER` puts these into the store",
        ));
    }
    if arguments.paper.is_some() && arguments.declared.any() {
        return Err(Failure::input(
            "--baseline and --compare: the tables of the paper have no comparisons of ways; \
             `nearmiss report FOLDER --baseline NAME` compares the recorded answers",
        ));
    }
    arguments.pivot.check(arguments)?;
    let to_files = arguments.output.is_some() || arguments.pairs.is_some();
    if arguments.overwrite && !to_files {
        return Err(Failure::input("--overwrite needs -o FILE or --pairs FILE"));
    }
    let spreadsheet = arguments.spreadsheet;
    if let Some(figure) = arguments.figure {
        spreadsheet.check(false)?;
        return write_figure(arguments, figure, file);
    }
    let known = ".md, .tex, .csv, .parquet, .arrow, .json and .html";
    let format = output::format_of(arguments.format, file, ReportFormat::Md, (ENDINGS, known))?;
    let by_columns = format.by_columns();
    if let Some(format) = by_columns {
        output::check_format(format, file)?;
    }
    spreadsheet.check(format == ReportFormat::Csv || arguments.pairs.is_some())?;
    if (arguments.pairs.as_deref()).is_some_and(|pairs| file_of(Some(pairs)) == file) {
        return Err(Failure::input(
            "--pairs: the report itself is written there; name another file",
        ));
    }
    let (made, lost) = match (&arguments.paper, &arguments.folder) {
        (Some(folder), _) => of_store::paper_report(folder)?,
        (None, Some(folder)) => of_store::folder_report(arguments, folder, format)?,
        (None, None) => (of_store::store_report(arguments, format)?, 0),
    };
    let target = Target::begin(file, arguments.overwrite)?;
    // Both can be begun, or neither is written.
    let pairs = arguments
        .pairs
        .as_deref()
        .map(|name| Target::begin(file_of(Some(name)), arguments.overwrite))
        .transpose()?;
    let provenance = made.provenance();
    match (by_columns, format) {
        (Some(by_columns), _) => {
            write_columns((file, target), by_columns, made.rows(), provenance)?;
        }
        (None, ReportFormat::Csv) => {
            target.save(&spreadsheet.applied(made.text(format)?.into_bytes()))?
        }
        (None, _) => target.save(made.text(format)?.as_bytes())?,
    }
    if let (ReportFormat::Csv, Some(provenance)) = (format, provenance) {
        output::say(&format!("nearmiss: {}", provenance.summary()));
    }
    if is_flat(format) && made.reports().any(|report| !report.varied.is_empty()) {
        output::say(
            "nearmiss: CSV, Parquet and Arrow leave out the tables of transforms and leads; the other formats have them",
        );
    }
    match pairs {
        None => made.hint_at_pairs(format),
        Some(target) => target.save(&spreadsheet.applied(made.pairs_csv().into_bytes()))?,
    }
    let required = arguments.required(&made.reports().collect::<Vec<_>>());
    let whole = match lost {
        0 => Ok(()),
        1 => Err(Failure::finding(
            "1 file could not be read and is missing from the report",
        )),
        n => Err(Failure::finding(format!(
            "{n} files could not be read and are missing from the report"
        ))),
    };
    both(whole, required)
}

impl ReportArguments {
    /// Holds what is required against the report.
    fn required(&self, reports: &[&Report]) -> Outcome {
        let batch = self.filters.filter()?.batch;
        if !self.gate.any() || batch.is_none() && !self.gate.needs_batch() {
            return self.gate.check(reports, None);
        }
        let store = store_to_read()?;
        let id = match batch.as_deref() {
            Some(LAST) => Some(last_batch(&store)?),
            named => named.and_then(|name| name.parse().ok()),
        };
        self.gate.check(reports, id.map(|id| (&*store, id)))
    }

    /// The report of answers, with the comparisons that the options declare, else those `usual` ones.
    fn compared(&self, scored: &[Scored], usual: &Comparison) -> Result<Report, Failure> {
        let prevalence = { self.prevalence.iter() }
            .flat_map(|share| report::at_prevalence(scored, *share))
            .collect();
        if !self.declared.any() {
            return Ok(Report::compared(scored, usual).prevalence(prevalence));
        }
        let ways: BTreeSet<&PromptConfig> = scored.iter().map(|one| &one.configuration).collect();
        let ways: Vec<&PromptConfig> = ways.into_iter().collect();
        let comparison = self.declared.comparison(&ways)?;
        Ok(Report::compared(scored, &comparison).prevalence(prevalence))
    }
}

/// A share, above 0 and below 1.
fn share(word: &str) -> Result<f64, String> {
    let share = word
        .parse()
        .ok()
        .filter(|share| (0.0..1.0).contains(share) && *share > 0.0);
    share.ok_or_else(|| "expected a share above 0 and below 1, such as 0.01".into())
}

/// Whether a format has one row a cell, and nothing else.
fn is_flat(format: ReportFormat) -> bool {
    format == ReportFormat::Csv || format.by_columns().is_some()
}

impl AnyReport {
    fn provenance(&self) -> Option<&Provenance> {
        let about = match self {
            Self::Split(split) => return split.provenance.as_ref(),
            Self::Pivot(pivot) => Some(&pivot.about),
            _ => self.reports().next().map(|report| &report.about),
        };
        about.and_then(|about| about.provenance.as_ref())
    }

    /// The rows of formats that are flat.
    fn rows(&self) -> FlatRows {
        match self {
            Self::Report(report) => report.rows(),
            Self::Split(split) => split.rows(),
            Self::Paper(paper) => paper.rows(),
            Self::Pivot(pivot) => pivot.rows(),
        }
    }

    fn reports(&self) -> impl Iterator<Item = &Report> {
        let (one, parts) = match self {
            Self::Report(report) => (Some(&**report), &[][..]),
            Self::Paper(paper) => (Some(&paper.report), &[][..]),
            Self::Split(split) => (None, &split.parts[..]),
            Self::Pivot(_) => (None, &[][..]),
        };
        one.into_iter()
            .chain(parts.iter().map(|(_, report)| report))
    }

    fn pairs_csv(&self) -> String {
        match self {
            Self::Report(report) => report.pair_rows().csv(),
            Self::Split(split) => split.pair_rows().csv(),
            Self::Paper(paper) => paper.report.pair_rows().csv(),
            // Refused before anything is read.
            Self::Pivot(_) => String::new(),
        }
    }

    /// A table of cells has no place for pairs.
    fn hint_at_pairs(&self, format: ReportFormat) {
        let pairs: usize = self.reports().map(|report| report.pairs.len()).sum();
        if is_flat(format) && pairs > 0 {
            output::say(&format!(
                "nearmiss: the comparisons of configurations ({pairs}) are not in this table; --pairs FILE writes them as CSV"
            ));
        }
    }

    fn text(&self, format: ReportFormat) -> Result<String, Failure> {
        Ok(match format {
            ReportFormat::Md => self.document().markdown(),
            ReportFormat::Latex => self.document().latex(),
            ReportFormat::Html => {
                let none = AnswerPage::default();
                self.document().html(match self {
                    Self::Report(report) => &report.answers,
                    Self::Split(split) => &split.answers,
                    Self::Paper(paper) => &paper.report.answers,
                    Self::Pivot(_) => &none,
                })
            }
            ReportFormat::Csv | ReportFormat::Parquet | ReportFormat::Arrow => self.rows().csv(),
            ReportFormat::Json => match self {
                Self::Report(report) => output::document_line(&report.json())?,
                Self::Split(split) => output::document_line(&split.json())?,
                Self::Paper(paper) => output::document_line(&paper.json())?,
                Self::Pivot(pivot) => output::document_line(&AxesDocument::from(&**pivot))?,
            },
        })
    }

    fn document(&self) -> Document {
        match self {
            Self::Report(report) => report.document("Accuracy of answers"),
            Self::Split(split) => split.document("Accuracy of answers"),
            Self::Paper(paper) => paper.document(),
            Self::Pivot(pivot) => pivot.document(),
        }
    }
}

/// Writes the rows of a report.
fn write_columns(
    (file, target): (Option<&Path>, Target),
    format: Format,
    rows: FlatRows,
    provenance: Option<&Provenance>,
) -> Outcome {
    let FlatRows { mut table, rows } = rows;
    table
        .metadata
        .push(("version", env!("CARGO_PKG_VERSION").into()));
    if let Some(provenance) = provenance {
        let provenance = serde_json::to_string(provenance).map_err(Failure::input)?;
        table.metadata.push(("provenance", provenance));
    }
    let rows = table.encode(format, rows);
    let written = TableWriter::begin(target, format, &table).and_then(|mut writer| {
        writer.write(rows)?;
        writer.finish()
    });
    match output::written(file, written)? {
        Some(target) => target.finish(),
        None => Ok(()),
    }
}

/// What the endings of names ask for.
const FIGURE_ENDINGS: &[(&str, PictureFormat)] =
    &[("svg", PictureFormat::Svg), ("png", PictureFormat::Png)];

/// Writes a figure of the answers that the arguments choose.
fn write_figure(arguments: &ReportArguments, figure: ReportFigure, file: Option<&Path>) -> Outcome {
    let format = output::format_of(
        None,
        file,
        PictureFormat::Svg,
        (FIGURE_ENDINGS, ".svg and .png"),
    )?;
    // Its notes go into the file.
    let made = match &arguments.folder {
        Some(folder) => of_store::folder_report(arguments, folder, ReportFormat::Md)?.0,
        None => of_store::store_report(arguments, ReportFormat::Md)?,
    };
    let palette = Palette::paper();
    let picture = match (&made, made.reports().next()) {
        (AnyReport::Pivot(pivot), _) => pivot.bars(palette),
        (_, Some(report)) => report.figure(figure, arguments.pivot.measure(), palette),
        (_, None) => return Err(Failure::input("--figure: nothing to draw")),
    };
    let named = |why: String| Failure::input(format!("--figure {}: {why}", figure.name()));
    let picture = picture.map_err(named)?;
    let bytes = format
        .encode(&picture, format.usual_dpi())
        .map_err(|error| named(error.to_string()))?;
    Target::begin(file, arguments.overwrite)?.save(&bytes)
}
