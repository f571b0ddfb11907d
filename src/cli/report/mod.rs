//! `nearmiss report`: accuracy of stored or recorded answers, as tables for papers.

mod of_batch;
mod of_folder;
mod of_store;
mod truth;

use std::path::PathBuf;

use super::filters::Filters;
use super::output::{self, Target, file_of};
use super::{Failure, Outcome};
use crate::evaluation::report::{Document, Report};
use crate::paper::Paper;
use crate::store::Filter;

/// Arguments of `report`.
#[derive(Debug, clap::Args)]
pub struct ReportArguments {
    /// Folder with recorded answers, laid out as the repository of "From Words to Collisions"; replaces the runs of the
    /// store.
    #[arg(conflicts_with = "paper")]
    folder: Option<PathBuf>,
    /// Compare the recorded answers in such a folder with Tables I to IV of the paper and with the built-in judge.
    #[arg(long, value_name = "FOLDER")]
    paper: Option<PathBuf>,
    #[command(flatten)]
    filters: Filters,
    /// Ground truth, separated by commas: CSV files with the columns `scenario` and `label` or `obstacle_id`; `batch`
    /// for the truth of each batch; folders with scenarios and recorded egos, or with annotations; `auto` for the exact
    /// geometry of bundled scenarios and the stored verdicts of the built-in judge on collisions. CSV files count
    /// first, then `batch`, then folders and `auto` in their order. [default: batch,auto]
    #[arg(
        long,
        value_delimiter = ',',
        value_name = "CSV|batch|auto|FOLDER",
        conflicts_with_all = ["folder", "paper"]
    )]
    truth: Vec<PathBuf>,
    /// Parse the stored answers again with this version.
    #[arg(long, conflicts_with_all = ["folder", "paper"])]
    reread: bool,
    /// Format of the report [default: from the file name, else md].
    #[arg(long, value_enum)]
    format: Option<Format>,
    /// The same as --format json.
    #[arg(long, conflicts_with = "format")]
    json: bool,
    /// File to write; - is standard output, which is the default.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// CSV file for McNemar's test between pairs of prompt configurations, one row a pair; other formats have them in
    /// the report.
    #[arg(long, value_name = "FILE")]
    pairs: Option<PathBuf>,
    /// Replace existing files.
    #[arg(long)]
    overwrite: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Format {
    /// Markdown tables.
    Md,
    /// LaTeX tables with the rules of booktabs.
    Latex,
    /// CSV: one row a cell, unrounded; --pairs has McNemar's test.
    Csv,
    /// One JSON object with every number.
    Json,
    /// One self-contained file with tables and figures.
    Html,
}

/// What the endings of names ask for.
const ENDINGS: &[(&str, Format)] = &[
    ("md", Format::Md),
    ("markdown", Format::Md),
    ("tex", Format::Latex),
    ("csv", Format::Csv),
    ("json", Format::Json),
    ("html", Format::Html),
    ("htm", Format::Html),
];

/// A report, of the one kind or the other.
enum AnyReport {
    Report(Report),
    Paper(Paper),
}

/// Runs `report`.
pub fn run(arguments: &ReportArguments) -> Outcome {
    let file = file_of(arguments.output.as_deref());
    let asked = arguments.format.or(arguments.json.then_some(Format::Json));
    let known = ".md, .tex, .csv, .json and .html";
    let format = output::format_of(asked, file, Format::Md, (ENDINGS, known))?;
    let of_folder = arguments.paper.is_some() || arguments.folder.is_some();
    if of_folder && arguments.filters.filter(None) != Filter::default() {
        return Err(Failure::input(
            "filters choose among the runs of the store; the recorded answers in a folder are reported as they are \
             (`nearmiss import FOLDER` puts them into the store)",
        ));
    }
    let to_files = arguments.output.is_some() || arguments.pairs.is_some();
    if arguments.overwrite && !to_files {
        return Err(Failure::input("--overwrite needs -o FILE or --pairs FILE"));
    }
    if (arguments.pairs.as_deref()).is_some_and(|pairs| file_of(Some(pairs)) == file) {
        return Err(Failure::input(
            "--pairs: the report itself goes there; name another file",
        ));
    }
    let (made, lost) = match (&arguments.paper, &arguments.folder) {
        (Some(folder), _) => of_folder::paper(folder)?,
        (None, Some(folder)) => of_folder::made(folder)?,
        (None, None) => (of_store::made(arguments)?, 0),
    };
    let text = made.text(format)?;
    let target = Target::begin(file, arguments.overwrite)?;
    // Both can be begun, or neither is written.
    let pairs = arguments
        .pairs
        .as_deref()
        .map(|name| Target::begin(file_of(Some(name)), arguments.overwrite));
    let pairs = pairs.transpose()?;
    target.save(text.as_bytes())?;
    if format == Format::Csv && !made.report().varied.is_empty() {
        output::say("nearmiss: CSV has no tables of transforms and leads; the other formats do");
    }
    match pairs {
        None => made.hint_at_pairs(format),
        Some(target) => target.save(
            made.report()
                .pairs_csv()
                .map_err(Failure::input)?
                .as_bytes(),
        )?,
    }
    match lost {
        0 => Ok(()),
        1 => Err(finding(
            "1 file could not be read and is missing from the report".into(),
        )),
        n => Err(finding(format!(
            "{n} files could not be read and are missing from the report"
        ))),
    }
}

fn finding(message: String) -> Failure {
    Failure { message, status: 1 }
}

impl AnyReport {
    fn report(&self) -> &Report {
        match self {
            Self::Report(report) => report,
            Self::Paper(paper) => &paper.report,
        }
    }

    /// A table of cells has no place for pairs.
    fn hint_at_pairs(&self, format: Format) {
        let pairs = self.report().pairs.len();
        if format == Format::Csv && pairs > 0 {
            output::say(&format!(
                "nearmiss: McNemar's test between pairs of ways ({pairs}) is not in this table; --pairs FILE writes it \
                 as CSV, too"
            ));
        }
    }

    fn text(&self, format: Format) -> Result<String, Failure> {
        Ok(match format {
            Format::Md => self.document().markdown(),
            Format::Latex => self.document().latex(),
            Format::Html => self.document().html(),
            Format::Csv => match self {
                Self::Report(report) => report.csv(),
                Self::Paper(paper) => paper.csv(),
            }
            .map_err(Failure::input)?,
            Format::Json => {
                let json = match self {
                    Self::Report(report) => report.json(),
                    Self::Paper(paper) => paper.json(),
                };
                output::json_line(&json)?
            }
        })
    }

    fn document(&self) -> Document {
        match self {
            Self::Report(report) => report.document("Accuracy of answers"),
            Self::Paper(paper) => paper.document(),
        }
    }
}
