//! `nearmiss export`: writes stored runs to a file.

mod columns;

use std::sync::atomic::Ordering;

use super::filters::{Filters, store_to_read};
use super::interrupt::{INTERRUPTED, interrupted};
use super::output::{self, Encoded, OutputFile, TableWriter, format_of, written};
use super::progress::Progress;
use super::{Failure, Outcome};

/// Arguments of `export`.
#[derive(Debug, clap::Args)]
pub struct Export {
    #[command(flatten)]
    filters: Filters,
    /// Only runs that have all these words in scenario, answer, reasoning, justification or notes.
    #[arg(long, value_name = "WORDS")]
    words: Option<String>,
    /// Format [default: from the file name, else jsonl].
    #[arg(long, value_enum)]
    format: Option<Format>,
    #[command(flatten)]
    output: OutputFile,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Format {
    /// JSON lines: one complete run a line; `nearmiss import` reads it.
    Jsonl,
    /// CSV with a header; control characters become symbols.
    Csv,
    /// Apache Parquet; needs a file.
    Parquet,
}

/// What the endings of names ask for.
const ENDINGS: &[(&str, Format)] = &[
    ("jsonl", Format::Jsonl),
    ("ndjson", Format::Jsonl),
    ("json", Format::Jsonl),
    ("csv", Format::Csv),
    ("parquet", Format::Parquet),
];

/// Runs `export`.
pub fn run(arguments: &Export) -> Outcome {
    let file = arguments.output.file();
    let known = ".jsonl, .ndjson, .json, .csv and .parquet";
    let format = match format_of(arguments.format, file, Format::Jsonl, (ENDINGS, known))? {
        Format::Jsonl => output::Format::Json,
        Format::Csv => output::Format::Csv,
        Format::Parquet => output::Format::Parquet,
    };
    format.check(file)?;
    let store = store_to_read()?;
    let filter = arguments.filters.filter(arguments.words.clone());
    let numbers = store.numbers(&filter).map_err(Failure::input)?;
    // Before the file is begun, so that it never stays behind.
    let stop = interrupted(file.is_some());
    let (target, table) = (arguments.output.begin()?, columns::table());
    let progress = Progress::new(numbers.len(), "runs", file.is_some());
    let Some(mut writer) = written(file, TableWriter::begin(target, format, &table))? else {
        return Ok(());
    };
    for number in &numbers {
        if stop.load(Ordering::Relaxed) {
            return Err(Failure {
                message: "interrupted; no file was written".into(),
                status: INTERRUPTED,
            });
        }
        progress.step();
        let Some(run) = store.run(*number).map_err(Failure::input)? else {
            // It is gone meanwhile.
            continue;
        };
        let row = match format {
            // The record says more than the table.
            output::Format::Json => {
                Encoded::Text(output::json_line(&run.to_record())?.into_bytes())
            }
            _ => table.encode(format, vec![columns::cells(&run)]),
        };
        if written(file, writer.write(row))?.is_none() {
            return Ok(());
        }
    }
    drop(progress);
    if let Some(target) = written(file, writer.finish())? {
        target.finish()?;
    }
    if file.is_some() {
        output::say(&format!("{} runs exported", numbers.len()));
    }
    Ok(())
}
