//! `nearmiss runs`: lists stored questions and answers.

mod list;
mod picture;

use super::filters::{Filters, store, store_to_read};
use super::locked::Unlock;
use super::{Failure, Outcome, output};
use nearmiss_store::{Run, RunId, Store, StoreError};
use nearmiss_study::evaluation::{run_words, tool_rounds};

/// Arguments of `runs`.
#[derive(Debug, clap::Args)]
#[command(args_conflicts_with_subcommands = true)]
pub struct Runs {
    #[command(subcommand)]
    what: Option<RunsCommand>,
    #[command(flatten)]
    list: List,
}

#[derive(Debug, clap::Subcommand)]
enum RunsCommand {
    /// List runs, newest first; the default.
    List(List),
    /// Show one run; with --json also its messages.
    Show {
        /// Number of the run.
        id: i64,
        /// Print one JSON object, as in an export.
        #[arg(long)]
        json: bool,
        #[command(flatten)]
        unlock: Unlock,
    },
    /// Write the picture that the model was shown.
    Picture(picture::PictureOfRun),
    /// Find runs that have all these words in model, scenario, answer, reasoning, justification or notes.
    Search {
        /// Words or their beginnings.
        #[arg(required = true)]
        words: Vec<String>,
        #[command(flatten)]
        list: List,
    },
    /// Delete runs: they are neither listed nor reused; `restore` undoes it.
    Delete(Ids),
    /// Restore deleted runs.
    Restore(Ids),
    /// Pin runs, which protects them from deletion.
    Pin(Ids),
    /// Unpin runs.
    Unpin(Ids),
    /// Set the note of a run; searches find it.
    Note {
        /// Number of the run.
        id: i64,
        /// Text that replaces the note; '' removes it.
        words: String,
    },
}

#[derive(Debug, clap::Args)]
struct List {
    #[command(flatten)]
    filters: Filters,
    /// Maximum number of runs.
    #[arg(short = 'n', long, value_name = "N", default_value_t = 100)]
    most: usize,
    /// Print JSON lines: one object per run.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    unlock: Unlock,
}

#[derive(Debug, clap::Args)]
struct Ids {
    /// Numbers of the runs.
    #[arg(required = true)]
    ids: Vec<i64>,
}

/// Runs `runs`.
pub fn run(arguments: &Runs) -> Outcome {
    let unlock = match &arguments.what {
        None => Some(arguments.list.unlock),
        Some(RunsCommand::List(list) | RunsCommand::Search { list, .. }) => Some(list.unlock),
        Some(RunsCommand::Show { unlock, .. }) => Some(*unlock),
        Some(RunsCommand::Picture(wanted)) => Some(wanted.unlock),
        _ => None,
    };
    // A look is recorded.
    let store = match unlock {
        Some(unlock) if !unlock.is_given() => store_to_read()?,
        _ => store()?,
    };
    match &arguments.what {
        None => list(&store, &arguments.list, None),
        Some(RunsCommand::List(wanted)) => list(&store, wanted, None),
        Some(RunsCommand::Search {
            words,
            list: wanted,
        }) => list(&store, wanted, Some(words.join(" "))),
        Some(RunsCommand::Show { id, json, unlock }) => show(&store, RunId(*id), *json, *unlock),
        Some(RunsCommand::Picture(wanted)) => picture::write(&store, wanted),
        Some(RunsCommand::Delete(ids)) => each(&store, ids, Change::Delete),
        Some(RunsCommand::Restore(ids)) => each(&store, ids, Change::Restore),
        Some(RunsCommand::Pin(ids)) => each(&store, ids, Change::Pin),
        Some(RunsCommand::Unpin(ids)) => each(&store, ids, Change::Unpin),
        Some(RunsCommand::Note { id, words }) => note(&store, RunId(*id), words),
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

fn each(store: &Store, ids: &Ids, change: Change) -> Outcome {
    for id in ids.ids.iter().copied().map(RunId) {
        let run = known(store, id)?;
        let (done, before) = change.words();
        if change.is_made(&run) {
            output::say(&format!("run {id}: {before}; nothing changed"));
            continue;
        }
        change.make(store, id).map_err(Failure::input)?;
        output::say(&format!("run {id}: {done}"));
    }
    Ok(())
}

fn note(store: &Store, id: RunId, words: &str) -> Outcome {
    let run = known(store, id)?;
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

fn list(store: &Store, wanted: &List, words: Option<String>) -> Outcome {
    let searched = words.is_some();
    let filter = wanted.filters.in_store(words, store)?;
    let numbers = store.numbers(&filter).map_err(Failure::input)?;
    let locked = wanted.unlock.locked(store, numbers)?;
    // So many more that enough are left.
    let most = wanted.most.saturating_add(locked.count());
    let mut found = store.list(&filter, most).map_err(Failure::input)?;
    found.retain(|run| !locked.has(RunId(run.run)));
    found.truncate(wanted.most);
    locked.say("lists");
    if wanted.json {
        return found.iter().try_for_each(output::json);
    }
    output::text(&list::table(&found))?;
    output::say(&match found.len() {
        0 if searched => "no matching runs".into(),
        0 => "no matching runs".into(),
        _ => list::sum(&found),
    });
    if found.len() == wanted.most && wanted.most > 0 {
        output::say(&format!(
            "showing the newest {}; -n N shows more",
            wanted.most
        ));
    }
    Ok(())
}

fn show(store: &Store, id: RunId, json: bool, unlock: Unlock) -> Outcome {
    let run = known(store, id)?;
    refuse_locked(store, id, unlock)?;
    if json {
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
    rows.extend(run_words(run, most));
    let messages: Vec<serde_json::Value> =
        serde_json::from_str(&run.question.messages).unwrap_or_default();
    if !messages.is_empty() {
        let words = format!("{}; --json shows them", messages.len());
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
