//! `nearmiss import`: imports runs and batches of another store, or answers recorded by others.

mod lines;
mod recorded;
mod store;

use std::path::{Path, PathBuf};

use schemars::JsonSchema;
use serde::Serialize;

use super::filters::store;
use super::{Failure, Outcome, json, output};
use nearmiss_store::MergeCounts;

/// Arguments of `import`.
#[derive(Debug, clap::Args)]
pub struct Import {
    /// JSONL files of `nearmiss export`; stores of other machines (runs.sqlite); folders laid out as the repository of
    /// "From Words to Collisions".
    #[arg(required = true)]
    paths: Vec<PathBuf>,
    /// Print the counts as one JSON object.
    #[arg(long)]
    json: bool,
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

impl json::Output for Counts {
    const NAME: &'static str = "import";
    const TITLE: &'static str = "`import --json`: counts";
}

/// Runs `import`.
pub fn run(arguments: &Import) -> Outcome {
    for path in &arguments.paths {
        let ending = path.extension().map(|e| e.to_ascii_lowercase());
        if path.is_file() && ending.is_some_and(|e| e == "csv" || e == "parquet") {
            return Err(Failure::input(format!(
                "{}: only JSONL can be imported; `nearmiss export -o runs.jsonl` writes it",
                path.display()
            )));
        }
    }
    let store = store()?;
    let mut counts = Counts::default();
    for path in &arguments.paths {
        if path.is_dir() {
            recorded::import(path, &store, &mut counts)?;
        } else if store::is_one(path) {
            store::import(path, &store, &mut counts)?;
        } else {
            lines::import(path, &store, &mut counts)?;
        }
    }
    if arguments.json {
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
fn merged(path: &Path, merged: MergeCounts, counts: &mut Counts) {
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
