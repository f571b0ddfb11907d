//! `nearmiss runs`: stored questions and answers, listed, shown and changed.

use std::path::{Path, PathBuf};

use nearmiss_base::system::{self, columns};
use nearmiss_scene::judge;
use nearmiss_scene::verdict::Task;
use nearmiss_store::{AnswerState, Origin, Run, RunId, Store, StoreError, Summary};
use nearmiss_study::evaluation::{Spending, run_summary, tool_rounds};

use super::batches::{self, Batches};
use super::export::Export;
use super::filters::{Filters, Unlock, store};
use super::import::Import;
use super::ratings::Ratings;
use super::{Failure, Outcome, export, import, output, ratings};

/// Subcommands of `runs`.
#[derive(Debug, clap::Subcommand)]
pub enum Runs {
    /// List runs, newest first, optionally by words and filters.
    List(List),
    /// Show one run, or save the picture that the model received.
    Show(Show),
    /// Delete runs: they are no longer listed or reused; `restore` undoes it.
    Delete(Ids),
    /// Restore deleted runs.
    Restore(Ids),
    /// Pin runs to protect them from deletion.
    Pin(Ids),
    /// Unpin runs.
    Unpin(Ids),
    /// Set the note of a run; filters search its words.
    Note {
        /// Run number.
        id: i64,
        /// New note; '' removes it.
        words: String,
    },
    /// Export stored runs to a file, or a batch with all its answers as a bundle.
    Export(Box<Export>),
    /// Import runs, bundles, stores, or answers recorded by others.
    Import(Import),
    /// Summarise ratings of answers compared side by side.
    Ratings(Ratings),
    /// List, collect and cancel provider batches (for batches of `evaluate`: `evaluate list`).
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
    /// Run number.
    id: i64,
    #[command(flatten)]
    format: output::FormatOption,
    /// PNG file for the picture that the model received, byte for byte.
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
    /// Run numbers.
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
    output::text(&runs_table(&found))?;
    output::say(&match found.len() {
        0 => "no matching runs".into(),
        _ => total(&found),
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
        return write_picture(&store, &run, file, wanted.overwrite);
    }
    if wanted.format.is_json() {
        let superseded = store.superseded().map_err(Failure::input)?;
        return output::json(&run.to_record(superseded.contains(&id)));
    }
    let most = store.bound_of(id).map_err(Failure::input)?;
    output::text(&output::visible(&run_details(&run, most)))
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
fn run_details(run: &Run, most: Option<f64>) -> String {
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

const TITLES: [&str; 10] = [
    "run",
    "asked",
    "verdict",
    "scenario",
    "model",
    "task",
    "frame",
    "techniques",
    "cost [$]",
    "",
];

/// The table, with a line of titles; nothing where there are no runs.
fn runs_table(runs: &[Summary]) -> String {
    if runs.is_empty() {
        return String::new();
    }
    let titles = std::iter::once(TITLES.map(String::from));
    let rows: Vec<[String; 10]> = titles.chain(runs.iter().map(table_row)).collect();
    let indent = rows.iter().map(|row| columns(&row[0])).max();
    let indent = " ".repeat(indent.unwrap_or(0));
    // Numbers end where their column does.
    let mut lines = output::table_lines(&rows, &[0, 8]);
    let mut text = lines.next().unwrap_or_default();
    for (line, run) in lines.zip(runs) {
        text += &line;
        if let Some(excerpt) = &run.excerpt {
            let words: Vec<_> = excerpt.split_whitespace().collect();
            text += &output::visible(&format!("{indent}  {}\n", words.join(" ")));
        }
    }
    text
}

fn table_row(run: &Summary) -> [String; 10] {
    let mut remarks = Vec::new();
    if run.sample > 0 {
        remarks.push(format!("sample {}", run.sample));
    }
    match run.origin {
        Origin::Asked => {}
        Origin::Recorded => remarks.push("recorded, imported".into()),
        Origin::Replayed => remarks.push(run.origin.name().into()),
    }
    if run.superseded {
        remarks.push(AnswerState::Superseded.name().into());
    }
    if run.pinned {
        remarks.push("pinned".into());
    }
    [
        run.run.to_string(),
        output::local(run.created_ms),
        verdict_word(run),
        run.scenario.clone(),
        run.model.clone(),
        run.task.name().into(),
        run.frame.clone(),
        run.techniques.clone(),
        cost(run),
        remarks.join(", "),
    ]
}

/// The verdict in the words of its task, or how far the answer came; in brackets the verdict of an answer that was cut
/// off, which does not count.
fn verdict_word(run: &Summary) -> String {
    let has_verdicts = Task::VERDICTS.contains(&run.task);
    let verdict = match (run.dangerous, run.task) {
        (Some(true), Task::Collision) => "collision",
        (Some(false), Task::Collision) => "no collision",
        (Some(true), Task::Recording) => "high risk",
        (Some(false), Task::Recording) => "safe",
        (Some(true), _) => "critical",
        (Some(false), _) => "not critical",
        (None, _) => "",
    };
    match (run.own_state(), verdict) {
        (AnswerState::Answered, verdict) if !verdict.is_empty() => verdict.into(),
        (AnswerState::Unparsed, _) if has_verdicts => "no verdict".into(),
        (AnswerState::Answered | AnswerState::Unparsed, _) => run.state.name().into(),
        (state, "") => state.name().into(),
        (state, verdict) => format!("{} ({verdict})", state.name()),
    }
}

/// What a run cost, US dollars; `<=` before the most that one can have cost that broke off.
fn cost(run: &Summary) -> String {
    match (run.cost_usd, run.most_usd) {
        (Some(usd), _) => format!("{usd:.6}"),
        (None, Some(0.0)) => "0".into(),
        (None, Some(most)) => format!("<={most:.6}"),
        (None, None) if costs_nothing(run) => "-".into(),
        (None, None) => "unknown".into(),
    }
}

/// The built-in judge costs nothing, and what others recorded cost nothing here.
fn costs_nothing(run: &Summary) -> bool {
    run.model == judge::MODEL || run.origin == Origin::Recorded
}

/// How many runs, and what they cost together.
fn total(runs: &[Summary]) -> String {
    let mut sum = Spending::default();
    for run in runs {
        let free = costs_nothing(run) && run.most_usd.is_none();
        sum.add(run.cost_usd.or(free.then_some(0.0)), run.most_usd);
    }
    let mut text = format!(
        "{}: {:.6} US dollars",
        output::counted(runs.len(), "run"),
        sum.usd
    );
    if sum.bounded > 0 {
        text += &format!(
            "; {} of unknown cost, at most {:.6} more",
            sum.bounded, sum.most_usd
        );
    }
    match sum.unknown {
        0 => {}
        n => text += &format!("; cost of {n} unknown"),
    }
    text
}

/// Writes it.
fn write_picture(store: &Store, run: &Run, file: &Path, overwrite: bool) -> Outcome {
    let id = run.id;
    let hashes = run.question.image_hashes();
    let Some(hash) = hashes.first() else {
        return Err(Failure::input(format!(
            "run {id} was asked without a picture, in the frame {}",
            run.question.frame
        )));
    };
    let image = store.image(hash).map_err(Failure::input)?.ok_or_else(|| {
        Failure::input(format!(
            "the picture {hash} of run {id} is not in the store; import the export or bundle again that has it"
        ))
    })?;
    system::save(file, &image.bytes, overwrite).map_err(|error| output::refused(&error))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use nearmiss_store::{RunState, StoredTemplate};

    fn summary(run: i64, cost: Option<f64>, most: Option<f64>) -> Summary {
        Summary {
            run,
            created_ms: 0,
            origin: Origin::Asked,
            state: RunState::Answered,
            answer_state: AnswerState::Answered,
            scenario: "ZAM_A-1".into(),
            task: Task::Collision,
            frame: "ego".into(),
            techniques: "cp".into(),
            template: StoredTemplate::default(),
            model: "lab/x".into(),
            sample: 0,
            dangerous: None,
            cost_usd: cost,
            most_usd: most,
            output_tokens: None,
            finish: None,
            superseded: false,
            pinned: false,
            excerpt: None,
        }
    }

    #[test]
    fn costs_are_summed_and_bounds_told_apart() {
        let mut built_in = summary(4, None, None);
        built_in.model = judge::MODEL.into();
        let runs = [
            summary(1, Some(0.25), Some(1.0)),
            summary(2, None, Some(0.5)),
            summary(3, None, None),
            built_in,
            summary(5, None, Some(0.0)),
        ];
        assert_eq!(
            total(&runs),
            "5 runs: 0.250000 US dollars; 1 of unknown cost, at most 0.500000 more; cost of 1 unknown"
        );
        assert_eq!(total(&runs[3..4]), "1 run: 0.000000 US dollars");
        let costs = runs.each_ref().map(cost);
        assert_eq!(costs, ["0.250000", "<=0.500000", "unknown", "-", "0"]);
    }

    #[test]
    fn verdicts_have_the_words_of_their_task() {
        let mut run = summary(1, None, None);
        assert_eq!(verdict_word(&run), "no verdict");
        run.dangerous = Some(false);
        assert_eq!(verdict_word(&run), "no collision");
        run.task = Task::Safety;
        assert_eq!(verdict_word(&run), "not critical");
        (run.dangerous, run.task) = (None, Task::Attacker);
        assert_eq!(verdict_word(&run), "answered");
        // A cut answer says something, and is none.
        (run.state, run.finish) = (RunState::Truncated, Some("content_filter".into()));
        (run.task, run.dangerous) = (Task::Safety, Some(true));
        assert_eq!(verdict_word(&run), "filtered (critical)");
        assert_eq!(run.own_state(), AnswerState::Filtered);
        (run.state, run.dangerous) = (RunState::Cancelled, None);
        assert_eq!(verdict_word(&run), "cancelled");
        let table = runs_table(&[run]);
        let lines: Vec<&str> = table.lines().collect();
        assert_eq!(lines.len(), 2, "{table}");
        assert_eq!(
            lines[0].find("verdict"),
            lines[1].find("cancelled"),
            "{table}"
        );
    }
}
