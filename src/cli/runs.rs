//! `nearmiss runs`: what was asked and answered.

use super::filters::{Filters, store};
use super::{Failure, Outcome, cost, output, time};
use crate::store::{Origin, Run, RunId, Store, StoreError, Summary};

/// Arguments of `runs`.
#[derive(Debug, clap::Args)]
#[command(args_conflicts_with_subcommands = true)]
pub struct Runs {
    #[command(subcommand)]
    what: Option<What>,
    #[command(flatten)]
    list: List,
}

#[derive(Debug, clap::Subcommand)]
enum What {
    /// The newest runs, newest first; the same as `runs` alone.
    List(List),
    /// Everything about one run; its messages with --json.
    Show {
        /// Its number.
        id: i64,
        /// As one line of JSON, the same as a line of an export.
        #[arg(long)]
        json: bool,
    },
    /// Runs with all these words in scenario, answer, reasoning, justification or notes.
    Search {
        /// Words, or beginnings of words.
        #[arg(required = true)]
        words: Vec<String>,
        #[command(flatten)]
        list: List,
    },
    /// Runs no longer listed, nor used as answers; `restore` brings them back.
    Delete(Ids),
    /// Deleted runs back again.
    Restore(Ids),
    /// Runs that cannot be deleted.
    Pin(Ids),
    /// Pinned runs as all others.
    Unpin(Ids),
    /// Your words about a run; they are searched too.
    Note {
        /// Its number.
        id: i64,
        /// What to write, in place of what is there.
        words: String,
    },
}

#[derive(Debug, clap::Args)]
struct List {
    #[command(flatten)]
    filters: Filters,
    /// At most so many.
    #[arg(short = 'n', long, value_name = "N", default_value_t = 100)]
    most: usize,
    /// One JSON object a line.
    #[arg(long)]
    json: bool,
}

#[derive(Debug, clap::Args)]
struct Ids {
    /// Their numbers.
    #[arg(required = true)]
    ids: Vec<i64>,
}

/// Runs `runs`.
pub fn run(arguments: &Runs) -> Outcome {
    let store = store()?;
    match &arguments.what {
        None => list(&store, &arguments.list, None),
        Some(What::List(wanted)) => list(&store, wanted, None),
        Some(What::Search {
            words,
            list: wanted,
        }) => list(&store, wanted, Some(words.join(" "))),
        Some(What::Show { id, json }) => show(&store, RunId(*id), *json),
        Some(What::Delete(ids)) => each(ids, |id| store.delete(id, true)),
        Some(What::Restore(ids)) => each(ids, |id| store.delete(id, false)),
        Some(What::Pin(ids)) => each(ids, |id| store.pin(id, true)),
        Some(What::Unpin(ids)) => each(ids, |id| store.pin(id, false)),
        Some(What::Note { id, words }) => store.note(RunId(*id), words).map_err(Failure::input),
    }
}

fn each(ids: &Ids, change: impl Fn(RunId) -> Result<(), StoreError>) -> Outcome {
    ids.ids
        .iter()
        .try_for_each(|id| change(RunId(*id)))
        .map_err(Failure::input)
}

fn list(store: &Store, wanted: &List, words: Option<String>) -> Outcome {
    let filter = wanted.filters.filter(words);
    let found = store.list(&filter, wanted.most).map_err(Failure::input)?;
    if wanted.json {
        return found.iter().try_for_each(output::json);
    }
    let rows = found.iter().map(line).collect::<String>();
    output::text(&output::visible(&rows))?;
    if found.len() == wanted.most {
        output::say(&format!(
            "the newest {}; -n N shows more, filters fewer",
            wanted.most
        ));
    }
    Ok(())
}

fn line(run: &Summary) -> String {
    let said = match (run.dangerous, run.state.as_str()) {
        (Some(true), _) => "dangerous",
        (Some(false), _) => "safe",
        (None, state) => state,
    };
    let origin = match run.origin.as_str() {
        "asked" => String::new(),
        "recorded" => " recorded, imported".into(),
        other => format!(" {other}"),
    };
    let sample = match run.sample {
        0 => String::new(),
        n => format!(" sample {n}"),
    };
    let pin = if run.pinned { " pinned" } else { "" };
    let mut text = format!(
        "{:>6}  {}  {said:<11}  {}  {}  {} {} {}{sample}{origin}{pin}\n",
        run.run,
        time::local(run.created_ms),
        run.scenario,
        run.model,
        run.task,
        run.frame,
        run.techniques,
    );
    if let Some(excerpt) = &run.excerpt {
        let words: Vec<_> = excerpt.split_whitespace().collect();
        text.push_str(&format!("        {}\n", words.join(" ")));
    }
    text
}

fn show(store: &Store, id: RunId, json: bool) -> Outcome {
    let found = store.run(id).map_err(Failure::input)?;
    let Some(run) = found else {
        return Err(Failure::input(StoreError::NoRun(id)));
    };
    if json {
        return output::json(&run.to_record());
    }
    output::text(&output::visible(&words(&run)))
}

/// Everything of a run that people want to see.
fn words(run: &Run) -> String {
    let (question, ending, consumed) = (&run.question, &run.ending, &run.ending.consumed);
    let mut text = String::new();
    let mut row = |name: &str, value: Option<String>| {
        if let Some(value) = value.filter(|v| !v.is_empty()) {
            text.push_str(&format!("{name:<13} {value}\n"));
        }
    };
    row("run", Some(run.id.to_string()));
    // Nobody knows when a recorded answer was asked for.
    let when = match run.origin {
        Origin::Recorded => "imported",
        Origin::Asked | Origin::Replayed => "asked",
    };
    row(when, Some(time::local(run.created_ms)));
    row("origin", Some(run.origin.name().into()));
    row("read from", run.source.clone());
    row("scenario", Some(question.scenario.clone()));
    row("ego", Some(question.ego.clone()));
    row("task", Some(question.task.name().into()));
    row(
        "how",
        Some(format!("{} · {}", question.frame, question.techniques)),
    );
    let steps = question
        .window
        .map(|(first, last)| format!("{first} to {last}"));
    row("steps", steps);
    row("model", Some(question.model.clone()));
    row("answered by", ending.model_returned.clone());
    row("server", Some(question.endpoint.clone()));
    let messages: Vec<serde_json::Value> =
        serde_json::from_str(&question.messages).unwrap_or_default();
    let messages = Some(messages.len()).filter(|count| *count > 0);
    row(
        "messages",
        messages.map(|count| format!("{count}; --json shows them")),
    );
    row(
        "parameters",
        Some(question.parameters.clone()).filter(|p| p != "{}"),
    );
    row(
        "sample",
        Some(question.sample)
            .filter(|n| *n > 0)
            .map(|n| n.to_string()),
    );
    row("batch", question.batch.clone());
    row("state", Some(ending.state.name().into()));
    row("problem", ending.error.clone());
    let verdict = ending.verdict.as_ref().and_then(|said| said.verdict());
    row("verdict", verdict.map(|v| v.word().into()));
    row("reading", ending.reading.clone());
    let tokens = cost::tokens(consumed);
    let cost = match consumed.cost_usd {
        Some(usd) => {
            let source = ending.price_source.as_deref().unwrap_or("source unknown");
            Some(format!("{usd} US dollars ({source})"))
        }
        None => tokens.as_ref().map(|_| {
            let returned = ending.model_returned.as_deref();
            let why = cost::unknown(consumed, &question.model, returned);
            format!("unknown ({why})")
        }),
    };
    row("tokens", tokens);
    row("cost", cost);
    row("notes", Some(run.notes.clone()));
    row("pinned", run.pinned.then(|| "yes".into()));
    row("deleted", run.deleted_ms.map(time::local));
    for (name, part) in [("reasoning", &run.reasoning), ("answer", &run.answer)] {
        if !part.is_empty() {
            text.push_str(&format!("\n── {name} ──\n{}\n", part.trim_end()));
        }
    }
    text
}
