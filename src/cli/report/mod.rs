//! `nearmiss report`: how often stored or recorded answers are right, as a table for papers.

mod of_batch;
mod truth;

use std::io::Write;
use std::path::{Path, PathBuf};

use super::filters::{Filters, store};
use super::metrics::{Target, file_of, no_format};
use super::progress::Progress;
use super::{Failure, Outcome, output};
use crate::evaluation::recorded::{Loss, Problem};
use crate::evaluation::report::{self, Document, Paper, Report, Stored};
use crate::store::{Filter, Outcome as Run, Store};
use crate::verdict;

/// Arguments of `report`.
#[derive(Debug, clap::Args)]
pub struct ReportArguments {
    /// A folder laid out as the repository of "From Words to Collisions": its recorded answers, instead of the runs of
    /// the store.
    #[arg(conflicts_with = "paper")]
    folder: Option<PathBuf>,
    /// The recorded answers in such a folder, beside Tables I to IV of the paper and beside the built-in judge.
    #[arg(long, value_name = "FOLDER")]
    paper: Option<PathBuf>,
    #[command(flatten)]
    filters: Filters,
    /// What is true: CSV files with the columns `scenario` and `label` or `obstacle_id`; folders with scenarios and
    /// their recorded egos, or with annotations; `auto` for the exact geometry of bundled scenarios and the built-in
    /// judge's stored verdicts on collisions. Separated by commas: CSV files count first, then folders and `auto` in
    /// their order.
    /// [default: auto]
    #[arg(
        long,
        value_delimiter = ',',
        value_name = "CSV|auto|FOLDER",
        conflicts_with_all = ["folder", "paper"]
    )]
    truth: Vec<PathBuf>,
    /// Read the stored answers again, with the parser of this version.
    #[arg(long, conflicts_with_all = ["folder", "paper"])]
    reread: bool,
    /// How the report is written [default: as the ending of FILE says, else md].
    #[arg(long, value_enum)]
    format: Option<Format>,
    /// The same as --format json.
    #[arg(long, conflicts_with = "format")]
    json: bool,
    /// A file to write to, instead of standard output, which is - too.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Replace the file if it is there already.
    #[arg(long, requires = "output")]
    overwrite: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Format {
    /// Markdown tables.
    Md,
    /// LaTeX tables with the rules of booktabs.
    Latex,
    /// One line a cell, nothing rounded.
    Csv,
    /// Every number, as one line of JSON.
    Json,
    /// One file with tables and figures that needs nothing else.
    Html,
}

impl Format {
    fn of_name(path: &Path) -> Option<Self> {
        match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "md" | "markdown" => Some(Self::Md),
            "tex" => Some(Self::Latex),
            "csv" => Some(Self::Csv),
            "json" => Some(Self::Json),
            "html" | "htm" => Some(Self::Html),
            _ => None,
        }
    }

    fn chosen(arguments: &ReportArguments, file: Option<&Path>) -> Result<Self, Failure> {
        match (arguments.json, arguments.format, file) {
            (true, ..) => Ok(Self::Json),
            (_, Some(format), _) => Ok(format),
            (.., None) => Ok(Self::Md),
            (.., Some(file)) => match Self::of_name(file) {
                Some(format) => Ok(format),
                // That is said where the file is begun.
                None if file.is_dir() => Ok(Self::Md),
                None => Err(no_format(file, ".md, .tex, .csv, .json and .html")),
            },
        }
    }
}

/// A report, of the one kind or the other.
enum Made {
    Report(Report, Vec<String>),
    Paper(Paper, Vec<String>),
}

/// Runs `report`.
pub fn run(arguments: &ReportArguments) -> Outcome {
    let file = file_of(arguments.output.as_deref());
    let format = Format::chosen(arguments, file)?;
    let of_folder = arguments.paper.is_some() || arguments.folder.is_some();
    if of_folder && arguments.filters.filter(None) != Filter::default() {
        return Err(Failure::input(
            "filters choose among the runs of the store; the recorded answers in a folder are reported as they are \
             (`nearmiss import FOLDER` puts them into the store)",
        ));
    }
    let (made, lost) = match (&arguments.paper, &arguments.folder) {
        (Some(folder), _) => {
            let (scored, note, lost) = recorded(folder)?;
            let paper = Paper::of(&scored).map_err(Failure::input)?;
            (Made::Paper(paper, vec![note]), lost)
        }
        (None, Some(folder)) => {
            let (scored, note, lost) = recorded(folder)?;
            (Made::Report(Report::of(&scored), vec![note]), lost)
        }
        (None, None) => (of_store(arguments)?, 0),
    };
    let text = made.text(format)?;
    let mut target = Target::begin(file, arguments.overwrite)?;
    match target
        .write_all(text.as_bytes())
        .and_then(|()| target.flush())
    {
        Err(error) if file.is_none() && error.kind() == std::io::ErrorKind::BrokenPipe => {}
        Err(error) => {
            let name = file.map_or_else(|| "standard output".into(), |f| f.display().to_string());
            return Err(Failure::system(name, &error));
        }
        Ok(()) => target.finish()?,
    }
    match lost {
        0 => Ok(()),
        1 => Err(finding(
            "1 file could not be read, and is not in the report".into(),
        )),
        n => Err(finding(format!(
            "{n} files could not be read, and are not in the report"
        ))),
    }
}

fn finding(message: String) -> Failure {
    Failure { message, status: 1 }
}

impl Made {
    fn text(&self, format: Format) -> Result<String, Failure> {
        Ok(match format {
            Format::Md => self.document().markdown(),
            Format::Latex => self.document().latex(),
            Format::Html => self.document().html(),
            Format::Csv => match self {
                Self::Report(report, _) => report.csv(),
                Self::Paper(paper, _) => paper.csv(),
            }
            .map_err(Failure::input)?,
            Format::Json => {
                let json = match self {
                    Self::Report(report, _) => report.json(),
                    Self::Paper(paper, _) => paper.json(),
                };
                output::escaped(&json.to_string()) + "\n"
            }
        })
    }

    fn document(&self) -> Document {
        match self {
            Self::Report(report, notes) => report.document("How often answers are right", notes),
            Self::Paper(paper, notes) => paper.document(notes),
        }
    }
}

/// Problems that are named one by one.
const NAMED: usize = 20;

/// Recorded answers, what they are in words, and how many files could not be read.
fn recorded(folder: &Path) -> Result<(Vec<crate::evaluation::Scored>, String, usize), Failure> {
    let (scored, problems) = report::recorded(folder);
    let lost: Vec<&Problem> = problems.iter().filter(|p| p.loss == Loss::Unread).collect();
    lost.iter()
        .take(NAMED)
        .for_each(|p| output::say(&format!("nearmiss: {p}")));
    let answers = scored.iter().filter(|s| s.way.frame.is_some()).count();
    if answers == 0 {
        return Err(Failure::input(format!(
            "{}: no recorded answers to the collision or safety task",
            folder.display()
        )));
    }
    let judged = scored.iter().any(|s| s.way.frame.is_none());
    let mut unlabelled: Vec<&str> = scored
        .iter()
        .filter(|s| s.truth.is_none())
        .map(|s| s.scenario.as_str())
        .collect();
    unlabelled.sort_unstable();
    unlabelled.dedup();
    let without = match unlabelled.is_empty() {
        true => String::new(),
        false => format!(
            " Without an annotation, so that answers about them are neither right nor wrong: {}.",
            unlabelled.join(", ")
        ),
    };
    let note = format!(
        "{answers} recorded answers, beside the annotations{}. Models are those that the paper's scripts ask; nobody was \
         asked now.",
        match judged {
            true =>
                " and the built-in judge (reference/geometry), which saw the scenarios themselves",
            false => "; the scenarios are not there, so the built-in judge could not be asked",
        }
    ) + &without;
    Ok((scored, note, lost.len()))
}

fn of_store(arguments: &ReportArguments) -> Result<Made, Failure> {
    let sources = match arguments.truth.is_empty() {
        true => vec![PathBuf::from(truth::AUTO)],
        false => arguments.truth.clone(),
    };
    let filter = arguments.filters.filter(None);
    let last = match filter.batch.as_deref() {
        Some("last") => store()?.last_batch().map_err(Failure::input)?,
        _ => None,
    };
    let named = filter.batch.as_deref().and_then(|id| id.parse().ok());
    if let Some(id) = last.map(|batch| batch.id).or(named) {
        let alone = Filter {
            batch: filter.batch.clone(),
            ..Filter::default()
        };
        if filter != alone || !arguments.truth.is_empty() || arguments.reread {
            return Err(Failure::input(
                "--batch: a batch is reported as a whole, beside its own truth, and its answers are \
                 always read anew; `nearmiss evaluate --resume ID --truth …` gives it another truth",
            ));
        }
        let store = store()?;
        return of_batch::made(&store, id);
    }
    let truth = truth::truth(&sources)?;
    let store = store()?;
    let mut runs = store.outcomes(&filter).map_err(Failure::input)?;
    if runs.is_empty() {
        return Err(finding(
            "no run fits; `nearmiss runs` lists those that there are, `nearmiss report FOLDER` reports recorded answers"
                .into(),
        ));
    }
    if arguments.reread {
        reread(&store, &mut runs)?;
    }
    let stored = report::stored(&runs, &truth);
    let notices = notices(&stored);
    for notice in &notices {
        output::say(&format!("nearmiss: {notice}"));
    }
    if stored.scored.is_empty() {
        return Err(finding("none of the runs can be counted".into()));
    }
    let mut notes = vec![format!(
        "{} runs of the store. Truth: {}.",
        stored.scored.len(),
        truth::words(&sources)
    )];
    notes.extend(notices);
    Ok(Made::Report(Report::of(&stored.scored), notes))
}

/// What is not in the report, or without a truth, in words.
fn notices(stored: &Stored) -> Vec<String> {
    let left_out = [
        (stored.unfinished, "running, cancelled or interrupted"),
        (
            stored.asked_again,
            "in whose place another answer to the same question counts",
        ),
        (stored.other_tasks, "of tasks without a yes or no"),
        (
            stored.unknown_ways,
            "asked with a frame or techniques that this version does not know",
        ),
    ];
    let left_out = left_out.into_iter().filter(|(count, _)| *count > 0);
    let mut notices: Vec<String> = left_out
        .map(|(count, what)| format!("left out: {count} {what}"))
        .collect();
    if !stored.unlabelled.is_empty() {
        let some: Vec<&str> = stored
            .unlabelled
            .iter()
            .take(3)
            .map(String::as_str)
            .collect();
        let more = match stored.unlabelled.len() > some.len() {
            true => ", …",
            false => "",
        };
        notices.push(format!(
            "of {} scenarios nobody says what is true ({}{more}); --truth names labels or a folder with the scenarios",
            stored.unlabelled.len(),
            some.join(", ")
        ));
    }
    notices
}

/// Reads the answers again, as this version reads them.
fn reread(store: &Store, runs: &mut [Run]) -> Result<(), Failure> {
    let progress = Progress::new(runs.len(), "answers", true);
    for run in runs.iter_mut() {
        progress.step();
        let Some((answer, reasoning)) = store.texts(run.run).map_err(Failure::input)? else {
            continue;
        };
        // A model that puts everything into its reasoning has still answered.
        let whole = if answer.trim().is_empty() {
            reasoning
        } else {
            answer
        };
        if whole.trim().is_empty() {
            continue;
        }
        match verdict::read(run.task, &whole) {
            Ok(reading) => {
                let json = serde_json::to_string(&reading.said).map_err(Failure::input)?;
                run.verdict = Some(json);
            }
            Err(why) => {
                run.verdict = None;
                run.reading = Some(why.to_string());
            }
        }
    }
    Ok(())
}
