//! `nearmiss runs import`: imports runs and batches of another store or file, or answers recorded by others.

use std::io::{self, BufRead, BufReader, Read};
use std::path::{Path, PathBuf};

use nearmiss_base::system;
use nearmiss_store::{MergeCounts, Record, RecordIntake, Store};
use nearmiss_study::evaluation::Loss;
use nearmiss_study::paper;
use schemars::JsonSchema;
use serde::Serialize;

use super::filters::store;
use super::{Failure, Outcome, bundle, output};

/// Arguments of `runs import`.
#[derive(Debug, clap::Args)]
pub struct Import {
    /// Files to import
    ///
    /// JSONL files and bundles from `nearmiss runs export`, stores of other machines (runs.sqlite), or folders laid out
    /// as the repository of "From Words to Collisions". Bundles of shards (`--shard`) of one batch are merged.
    #[arg(required = true)]
    paths: Vec<PathBuf>,
    /// Folder for the experiment file, templates, labels and scenarios of a bundle; several bundles get a subfolder
    /// each [default: the bundle's name without its ending].
    #[arg(long, value_name = "FOLDER")]
    into: Option<PathBuf>,
    /// Check bundles and list their contents; import nothing.
    #[arg(long, conflicts_with = "into")]
    dry_run: bool,
    #[command(flatten)]
    format: output::FormatOption,
}

/// Counts of imported runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, JsonSchema)]
pub struct Counts {
    /// Runs imported.
    imported: usize,
    /// Runs that the store already has.
    already_there: usize,
    /// Answers that the folder lacks.
    absent: usize,
    /// Runs that could not be read.
    unreadable: usize,
}

/// Runs `runs import`.
pub fn run(arguments: &Import) -> Outcome {
    for path in &arguments.paths {
        let ending = path.extension().map(|e| e.to_ascii_lowercase());
        if path.is_file() && ending.is_some_and(|e| e == "csv" || e == "parquet") {
            return Err(Failure::input(format!(
                "{}: only JSONL can be imported; `nearmiss runs export -o runs.jsonl` writes it",
                path.display()
            )));
        }
    }
    let (bundles, others): (Vec<&Path>, Vec<&Path>) =
        { arguments.paths.iter().map(PathBuf::as_path) }.partition(|path| bundle::is_one(path));
    if arguments.dry_run {
        return match others.first() {
            None => { bundles.iter() }.try_for_each(|file| bundle::show(file, arguments.format)),
            Some(other) => Err(Failure::input(format!(
                "{}: --dry-run lists bundles, FILE.nearmiss",
                other.display()
            ))),
        };
    }
    if arguments.into.is_some() && bundles.is_empty() {
        return Err(Failure::input("--into needs a bundle, FILE.nearmiss"));
    }
    let store = store()?;
    let mut counts = Counts::default();
    for unpacked in bundle::unpack(&bundles, arguments.into.as_deref(), &store)? {
        counts.imported += unpacked.runs;
        counts.already_there += unpacked.already_there;
    }
    for path in others {
        if path.is_dir() {
            import_recorded(path, &store, &mut counts)?;
        } else if is_store(path) {
            import_store(path, &store, &mut counts)?;
        } else {
            import_lines(path, &store, &mut counts)?;
        }
    }
    if arguments.format.is_json() {
        output::document(&counts)?;
    } else {
        output::text(&format!(
            "{} imported, {} already in the store, {}{} unreadable\n",
            counts.imported,
            counts.already_there,
            match counts.absent {
                0 => String::new(),
                absent => format!("{absent} absent, "),
            },
            counts.unreadable
        ))?;
    }
    match counts.unreadable {
        0 => Ok(()),
        n => Err(Failure::finding(format!("{n} could not be read"))),
    }
}

/// Counts what was taken in from a file, and says which batches.
fn count_merged(path: &Path, merged: MergeCounts, counts: &mut Counts) {
    counts.imported += merged.runs;
    counts.already_there += merged.already_there;
    if merged.batches + merged.united > 0 {
        output::say(&format!(
            "nearmiss: {}: {} new {}, {} merged; `nearmiss evaluate list` lists them",
            path.display(),
            merged.batches,
            if merged.batches == 1 {
                "batch"
            } else {
                "batches"
            },
            merged.united
        ));
    }
}

/// Bytes of the longest line that is read; an answer has some ten thousand.
const LONGEST_LINE: u64 = 64 << 20;

/// Lines that are complained about one by one.
const MAX_ERRORS_LISTED: usize = 3;

/// Adds the runs and batches of a file that are not in the store yet.
fn import_lines(path: &Path, store: &Store, counts: &mut Counts) -> Result<(), Failure> {
    let shown = path.display();
    let wrong = |error: io::Error| Failure::system(shown.to_string(), &error);
    let mut reader = BufReader::new(system::open_file(path).map_err(wrong)?);
    let mut unreadable = 0;
    let mut complain = |number: usize, column: Option<usize>, why: &str| {
        let column = column.map_or_else(String::new, |column| format!(":{column}"));
        unreadable += 1;
        match unreadable {
            n if n <= MAX_ERRORS_LISTED => {
                output::say(&format!("nearmiss: {shown}:{number}{column}: {why}"))
            }
            n if n == MAX_ERRORS_LISTED + 1 => {
                output::say(&format!(
                    "nearmiss: {shown}: further errors are only counted"
                ));
            }
            _ => {}
        }
    };
    let mut intake = RecordIntake::new(store);
    let mut line = Vec::new();
    for number in 1.. {
        line.clear();
        let read = (&mut reader)
            .take(LONGEST_LINE)
            .read_until(b'\n', &mut line);
        if read.map_err(wrong)? == 0 {
            break;
        }
        if line.len() as u64 == LONGEST_LINE && line.last() != Some(&b'\n') {
            complain(number, None, "the line is longer than any run");
            reader.skip_until(b'\n').map_err(wrong)?;
            continue;
        }
        let Ok(text) = std::str::from_utf8(&line) else {
            complain(number, None, "not UTF-8");
            continue;
        };
        // Some editors begin a file with byte order marks.
        let text = if number == 1 {
            text.trim_start_matches('\u{feff}')
        } else {
            text
        };
        if text.trim().is_empty() {
            continue;
        }
        match Record::from_line(text.trim_end()) {
            Ok(record) => intake.take(record, line.len()).map_err(Failure::input)?,
            Err(error) => complain(number, error.column(), &error.to_string()),
        }
    }
    let intake = intake.finish().map_err(Failure::input)?;
    counts.unreadable += unreadable;
    count_merged(path, intake.counts(), counts);
    Ok(())
}

/// Runs that are added in one transaction.
const RUNS_AT_ONCE: usize = 500;

/// Problems that are named one by one.
const MAX_PROBLEMS_LISTED: usize = 20;

/// Adds the recorded answers below a folder that are not in the store yet.
fn import_recorded(root: &Path, store: &Store, counts: &mut Counts) -> Result<(), Failure> {
    let (runs, problems) = paper::runs(root, nearmiss_store::now_ms());
    // What is lost comes first.
    let (lost, others): (Vec<_>, Vec<_>) = problems.iter().partition(|p| p.loss == Loss::Unread);
    for problem in lost.into_iter().chain(others).take(MAX_PROBLEMS_LISTED) {
        output::say(&format!("nearmiss: {problem}"));
    }
    if problems.len() > MAX_PROBLEMS_LISTED {
        let more = problems.len() - MAX_PROBLEMS_LISTED;
        output::say(&format!(
            "nearmiss: {}: {more} more like this",
            root.display()
        ));
    }
    for runs in runs.chunks(RUNS_AT_ONCE) {
        let added = store.add(runs).map_err(Failure::input)?;
        counts.imported += added;
        counts.already_there += runs.len() - added;
    }
    let lost = |loss| problems.iter().filter(|p| p.loss == loss).count();
    counts.absent += lost(Loss::Absent);
    counts.unreadable += lost(Loss::Unread);
    let without = |run: &&nearmiss_store::Run| run.question.scenario_hash.is_none();
    let loose = runs.iter().filter(without).count();
    if loose > 0 {
        output::say(&format!(
            "nearmiss: {} linked to scenarios by name only: no such files below {}",
            output::counted(loose, "answer"),
            root.display()
        ));
    }
    Ok(())
}

/// How every SQLite file begins.
const SQLITE_HEADER: &[u8] = b"SQLite format 3\0";

/// Whether a file is a store.
fn is_store(path: &Path) -> bool {
    let mut begun = [0; SQLITE_HEADER.len()];
    let read = system::open_file(path).and_then(|mut file| file.read_exact(&mut begun));
    read.is_ok() && begun == SQLITE_HEADER
}

/// Adds the runs and batches of a store that are not in this one yet.
fn import_store(path: &Path, store: &Store, counts: &mut Counts) -> Result<(), Failure> {
    let other = Store::open_to_read(path).map_err(Failure::input)?;
    let merged = store
        .merge(&other)
        .map_err(|e| Failure::input(format!("{}: {e}", path.display())))?;
    if merged.running > 0 {
        output::say(&format!(
            "nearmiss: {}: skipped {} still streaming there; import it again when complete",
            path.display(),
            output::counted(merged.running, "answer")
        ));
    }
    count_merged(path, merged, counts);
    Ok(())
}
