//! `nearmiss import`: imports runs of another store, or answers recorded by others.

mod lines;
mod recorded;
mod store;

use std::path::PathBuf;

use serde_json::json;

use super::filters::store;
use super::{Failure, Outcome, output};

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
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
struct Counts {
    imported: usize,
    already_there: usize,
    absent: usize,
    unreadable: usize,
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
        output::json(&json!({
            "imported": counts.imported,
            "already_there": counts.already_there,
            "absent": counts.absent,
            "unreadable": counts.unreadable,
        }))?;
    } else {
        output::text(&format!(
            "{} imported, {} already there, {}{} unreadable\n",
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
        n => Err(Failure {
            message: format!("{n} could not be read"),
            status: 1,
        }),
    }
}
