//! `nearmiss runs list`: stored questions and answers.

mod list;
mod picture;

use std::path::PathBuf;

use super::batches::{self, Batches};
use super::export::{self, Export};
use super::filters::{Filters, store};
use super::import::{self, Import};
use super::locked::Unlock;
use super::ratings::{self, Ratings};
use super::{Failure, Outcome, output};
use nearmiss_store::{Run, RunId, Store, StoreError};
use nearmiss_study::evaluation::{run_summary, tool_rounds};

/// Subcommands of `runs`.
#[derive(Debug, clap::Subcommand)]
pub enum Runs {
    /// List runs, newest first, or those that words and filters find.
    List(List),
    /// Show one run, or write the picture that the model was shown.
    Show(Show),
    /// Delete runs: they are neither listed nor reused; `restore` undoes it.
    Delete(Ids),
    /// Restore deleted runs.
    Restore(Ids),
    /// Pin runs, which protects them from deletion.
    Pin(Ids),
    /// Unpin runs.
    Unpin(Ids),
    /// Set the note of a run; filters find its words.
    Note {
        /// Number of the run.
        id: i64,
        /// Text that replaces the note; '' removes it.
        words: String,
    },
    /// Write stored runs to a file, or a batch with all its answers as a bundle.
    Export(Box<Export>),
    /// Import runs, bundles, stores, or answers recorded by others.
    Import(Import),
    /// Summarise ratings of answers compared side by side.
    Ratings(Ratings),
    /// List, collect and cancel provider batches (those of `evaluate`: `evaluate list`).
    Batches(Batches),
}

/// Arguments of `runs list`.
#[derive(Debug, clap::Args)]
pub struct List {
    #[command(flatten)]
    filters: Filters,
    /// Maximum number of runs.
    #[arg(short, long, value_name = "N", default_value_t = 100)]
    number: usize,
    #[command(flatten)]
    format: output::FormatOption,
    #[command(flatten)]
    unlock: Unlock,
}

/// Arguments of `runs show`.
#[derive(Debug, clap::Args)]
pub struct Show {
    /// Number of the run.
    id: i64,
    #[command(flatten)]
    format: output::FormatOption,
    /// PNG file for the picture that the model was shown, byte for byte as it was sent.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Replace an existing file.
    #[arg(long, requires = "output")]
    overwrite: bool,
    #[command(flatten)]
    unlock: Unlock,
}

/// Arguments of commands that change runs.
#[derive(Debug, clap::Args)]
pub struct Ids {
    /// Numbers of the runs.
    #[arg(required = true)]
    ids: Vec<i64>,
}

/// Runs `runs`.
pub fn run(command: &Runs) -> Outcome {
    match command {
        Runs::List(wanted) => list(wanted),
        Runs::Show(wanted) => show(wanted),
        Runs::Delete(ids) => each(ids, Change::Delete),
        Runs::Restore(ids) => each(ids, Change::Restore),
        Runs::Pin(ids) => each(ids, Change::Pin),
        Runs::Unpin(ids) => each(ids, Change::Unpin),
        Runs::Note { id, words } => note(RunId(*id), words),
        Runs::Export(arguments) => export::run(arguments),
        Runs::Import(arguments) => import::run(arguments),
        Runs::Ratings(arguments) => ratings::run(arguments),
        Runs::Batches(arguments) => batches::run(arguments),
    }
}

/// What is done to runs.
#[derive(Clone, Copy)]
enum Change {
    Delete,
    Restore,
    Pin,
    Unpin,
}

impl Change {
    fn make(self, store: &Store, run: RunId) -> Result<(), StoreError> {
        match self {
            Self::Delete => store.delete(run, true),
            Self::Restore => store.delete(run, false),
            Self::Pin => store.pin(run, true),
            Self::Unpin => store.pin(run, false),
        }
    }

    /// Whether a run is so already.
    fn is_made(self, run: &Run) -> bool {
        match self {
            Self::Delete => run.deleted_ms.is_some(),
            Self::Restore => run.deleted_ms.is_none(),
            Self::Pin => run.pinned,
            Self::Unpin => !run.pinned,
        }
    }

    /// Messages for a changed run, and for one already in that state.
    fn words(self) -> (&'static str, &'static str) {
        match self {
            Self::Delete => (
                "deleted; `nearmiss runs restore` undoes it",
                "already deleted",
            ),
            Self::Restore => ("restored", "was not deleted"),
            Self::Pin => ("pinned", "already pinned"),
            Self::Unpin => ("no longer pinned", "was not pinned"),
        }
    }
}

fn each(ids: &Ids, change: Change) -> Outcome {
    let store = store()?;
    for id in ids.ids.iter().copied().map(RunId) {
        let run = known(&store, id)?;
        let (done, before) = change.words();
        if change.is_made(&run) {
            output::say(&format!("run {id}: {before}; nothing changed"));
            continue;
        }
        change.make(&store, id).map_err(Failure::input)?;
        output::say(&format!("run {id}: {done}"));
    }
    Ok(())
}

fn note(id: RunId, words: &str) -> Outcome {
    let store = store()?;
    let run = known(&store, id)?;
    if run.notes == words {
        output::say(&format!("run {id}: the note is the same; nothing changed"));
        return Ok(());
    }
    store.note(id, words).map_err(Failure::input)?;
    output::say(&match (run.notes.is_empty(), words.is_empty()) {
        (_, true) => format!("run {id}: note removed"),
        (true, false) => format!("run {id}: noted"),
        (false, false) => format!("run {id}: note replaced; it was: {}", run.notes),
    });
    Ok(())
}

/// The run with a number.
fn known(store: &Store, id: RunId) -> Result<Run, Failure> {
    let found = store.run(id).map_err(Failure::input)?;
    found.ok_or_else(|| Failure::input(StoreError::NoRun(id)))
}

fn list(wanted: &List) -> Outcome {
    let store = wanted.unlock.store()?;
    let filter = wanted.filters.in_store(&store)?;
    let numbers = store.numbers(&filter).map_err(Failure::input)?;
    let locked = wanted.unlock.locked(&store, numbers)?;
    // So many more that enough are left.
    let most = wanted.number.saturating_add(locked.count());
    let mut found = store.list(&filter, most).map_err(Failure::input)?;
    found.retain(|run| !locked.has(RunId(run.run)));
    found.truncate(wanted.number);
    locked.say("lists");
    if wanted.format.is_json() {
        return found.iter().try_for_each(output::json);
    }
    output::text(&list::table(&found))?;
    output::say(&match found.len() {
        0 => "no matching runs".into(),
        _ => list::sum(&found),
    });
    if found.len() == wanted.number && wanted.number > 0 {
        output::say(&format!(
            "showing the newest {}; -n N shows more",
            wanted.number
        ));
    }
    Ok(())
}

fn show(wanted: &Show) -> Outcome {
    let store = wanted.unlock.store()?;
    let id = RunId(wanted.id);
    let run = known(&store, id)?;
    refuse_locked(&store, id, wanted.unlock)?;
    if let Some(file) = &wanted.output {
        return picture::write(&store, &run, file, wanted.overwrite);
    }
    if wanted.format.is_json() {
        let superseded = store.superseded().map_err(Failure::input)?;
        return output::json(&run.to_record(superseded.contains(&id)));
    }
    let most = store.bound_of(id).map_err(Failure::input)?;
    output::text(&output::visible(&words(&run, most)))
}

/// Refuses a run of a test split that is not complete.
fn refuse_locked(store: &Store, id: RunId, unlock: Unlock) -> Outcome {
    if unlock.locked(store, [id])?.has(id) {
        Err(Failure::input(format!(
            "run {id} is of a test split that is not complete; --unlock shows it and records the look"
        )))
    } else {
        Ok(())
    }
}

/// Everything of a run that people want to see; `most` is what it can have cost, US dollars.
fn words(run: &Run, most: Option<f64>) -> String {
    let mut rows = vec![("run", run.id.to_string())];
    let verdict = run.ending.verdict.as_ref().and_then(|said| said.verdict());
    rows.extend(verdict.map(|verdict| ("verdict", verdict.word().into())));
    rows.extend(run_summary(run, most));
    let messages: Vec<serde_json::Value> =
        serde_json::from_str(&run.question.messages).unwrap_or_default();
    if !messages.is_empty() {
        let words = format!("{}; --format json shows them", messages.len());
        rows.push(("messages", words));
    }
    let pictures = run.question.image_hashes();
    if !pictures.is_empty() {
        rows.push(("pictures", pictures.join(", ")));
    }
    let rows = rows.iter();
    let mut text: String = rows.map(|(name, v)| format!("{name:<13} {v}\n")).collect();
    let rounds = tool_rounds::stored(run.tool_rounds.as_deref());
    let calls: Vec<String> = rounds.iter().flat_map(tool_rounds::lines).collect();
    for (name, part) in [
        ("tool calls", &calls.join("\n")),
        ("reasoning", &run.reasoning),
        ("answer", &run.answer),
    ] {
        if !part.is_empty() {
            text.push_str(&format!("\n── {name} ──\n{}\n", part.trim_end()));
        }
    }
    text
}
