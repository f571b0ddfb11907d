//! `nearmiss runs import`: imports runs and batches of another store, or answers recorded by others.

mod lines;
mod recorded;
mod store;

use std::path::{Path, PathBuf};

use schemars::JsonSchema;
use serde::Serialize;

use super::bundle;
use super::filters::store;
use super::{Failure, Outcome, json, output};
use nearmiss_store::MergeCounts;

/// Arguments of `runs import`.
#[derive(Debug, clap::Args)]
pub struct Import {
    /// JSONL files and bundles of `nearmiss runs export`; stores of other machines (runs.sqlite); folders laid out as the
    /// repository of "From Words to Collisions". Bundles of parts of one batch (`--shard`) become one.
    #[arg(required = true)]
    paths: Vec<PathBuf>,
    /// Folder for the experiment file, templates, labels and scenarios of a bundle; of several bundles, for a folder of
    /// each [default: the name of the bundle without its ending].
    #[arg(long, value_name = "FOLDER")]
    into: Option<PathBuf>,
    /// Check bundles and list what is in them; import nothing.
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

impl json::Output for Counts {
    const NAME: &'static str = "runs-import";
    const TITLE: &'static str = "`runs import --format json`: counts";
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
            recorded::import(path, &store, &mut counts)?;
        } else if store::is_one(path) {
            store::import(path, &store, &mut counts)?;
        } else {
            lines::import(path, &store, &mut counts)?;
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
