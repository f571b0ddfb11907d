//! A running batch: what is submitted to providers, progress, interruption, and the final table.

use std::sync::Arc;
use std::time::Instant;

use tokio::runtime::Runtime;

use super::context::BatchContext;
use super::options::Format;
use super::table::{BatchTable, write, write_parts};
use super::{dry_run, number};
use crate::batches::lost_note;
use crate::ending::{GRACE, signal};
use crate::output::Progress;
use crate::{Failure, Outcome, output};
use nearmiss_store::{BatchId, Item, ItemState, SplitPart};
use nearmiss_study::evaluation::batch::{TestSplit, answers};
use nearmiss_workflow::batch::{
    BatchRun, DryRun, PausedModel, QuestionOutcome, Selection, SubmittedItems,
};
use nearmiss_workflow::count_reasons;

/// Format of a batch's table.
#[derive(Debug, Clone, Copy)]
pub struct Table {
    pub format: Format,
    /// Whether the figures of a test split are shown before it is complete.
    pub unlock: bool,
    /// The part of a split that was asked; `None` for all.
    pub part: Option<SplitPart>,
}

/// Asks what a batch has to ask, or submits it to the providers, then writes its table.
pub fn ask(
    runtime: &Runtime,
    context: &BatchContext,
    run: &Arc<BatchRun>,
    dry_run: &DryRun,
    (submits, retries, table): (bool, u32, Table),
) -> Outcome {
    let id = run.id;
    output::say(&format!("nearmiss: {id}: {}", dry_run::line(dry_run)));
    let (items, with_providers) = run.items(dry_run).map_err(Failure::input)?;
    if with_providers > 0 {
        output::say(&format!(
            "nearmiss: {with_providers} of them submitted to providers: `nearmiss runs batches collect` fetches the answers"
        ));
    }
    for batch in context.store.provider_batches().map_err(Failure::input)? {
        if let Some(words) = lost_note(&batch) {
            output::say(&format!("nearmiss: batch {}: {words}", batch.id));
        }
    }
    let items = if submits {
        let own = submit(runtime, run, items)?;
        if own.is_empty() {
            return Ok(());
        }
        own
    } else {
        items
    };
    let ask = |items| {
        let paused = runtime.block_on(until_interrupted(run, items))?;
        paused
            .ok_or_else(|| Failure::interrupted(&format!("`nearmiss evaluate {id}` continues it")))
    };
    let mut paused = ask(items)?;
    for _ in 0..retries {
        let mut failed = run.failed(dry_run).map_err(Failure::input)?;
        failed.retain(|item| paused.iter().all(|one| !one.holds(&item.asked.model)));
        if failed.is_empty() {
            break;
        }
        let questions = number(failed.len(), "question");
        output::say(&format!(
            "nearmiss: {id}: {questions} without a verdict asked again"
        ));
        paused.extend(ask(failed)?);
    }
    for one in &paused {
        output::say(&format!("nearmiss: {}", output::visible(&one.summary())));
    }
    show(context, id, table)
}

/// Submits the questions, and prints which provider received them. Those to the built-in judge, which no provider
/// accepts, are left.
fn submit(runtime: &Runtime, run: &BatchRun, items: Vec<Item>) -> Result<Vec<Item>, Failure> {
    let submitted: SubmittedItems = runtime
        .block_on(run.submit(items))
        .map_err(Failure::input)?;
    for (model, taken) in &submitted.submitted {
        let batches: Vec<String> = taken.batches.iter().map(ToString::to_string).collect();
        let mut words = format!(
            "{}: {} with the provider",
            output::visible(model),
            number(taken.handed, "question")
        );
        if !batches.is_empty() {
            words.push_str(&format!(" as {}", batches.join(", ")));
        }
        if taken.stored > 0 {
            let stored = number(taken.stored, "answer");
            words.push_str(&format!("; the store has {stored}"));
        }
        if taken.taken > 0 {
            words.push_str(&format!("; {} already running", taken.taken));
        }
        output::say(&format!("nearmiss: {words}"));
        for note in &taken.notes {
            output::say(&format!("nearmiss: {}: {note}", output::visible(model)));
        }
    }
    for (item, why) in submitted.unaskable.iter().take(3) {
        output::say(&format!("nearmiss: {}: {why}", item.asked.scenario));
    }
    if submitted.unaskable.len() > 3 {
        let more = submitted.unaskable.len() - 3;
        output::say(&format!("nearmiss: {more} more cannot be asked"));
    }
    let id = run.id;
    let on = format!(
        "`nearmiss runs batches collect --wait` fetches the answers, then `nearmiss evaluate {id}` writes the table"
    );
    for (model, error) in &submitted.broken {
        let words = format!("nearmiss: {model}: {error}");
        output::say(&output::visible(&words));
    }
    if !submitted.broken.is_empty() {
        let models = number(submitted.broken.len(), "model");
        return Err(Failure::finding(format!(
            "not everything could be submitted for {models}; {on}"
        )));
    }
    output::say(&format!("nearmiss: {on}"));
    Ok(submitted.own)
}

/// Writes the table of a batch as it stands.
pub fn show(context: &BatchContext, id: BatchId, table: Table) -> Outcome {
    let store = &context.store;
    let batch = store.batch(id).map_err(Failure::input)?;
    let test = batch.map(|batch| TestSplit::open(store, &batch, table.unlock));
    if let Some(test) = test.transpose().map_err(Failure::input)?.flatten() {
        write_parts(table.format, store, id, &test)?;
        let counted = |item: &Item| !test.is_locked() || item.asked.split != Some(SplitPart::Test);
        return unanswered(context, id, table.part, counted);
    }
    let answers = answers(&context.store, id).map_err(Failure::input)?;
    let counted = BatchTable::new(None, &answers);
    write(table.format, id, vec![counted], Vec::new(), |parts| {
        parts.iter().map(BatchTable::text).collect()
    })?;
    output::say(&format!(
        "nearmiss: `nearmiss report --batch {id}` has intervals and comparisons"
    ));
    unanswered(context, id, None, |_| true)
}

/// Says which questions of a part, or of all, have no whole answer, and why; and how many of those that are `counted`
/// have one that cannot be read.
fn unanswered(
    context: &BatchContext,
    id: BatchId,
    part: Option<SplitPart>,
    counted: impl Fn(&Item) -> bool,
) -> Outcome {
    let mut items = context.store.items(id).map_err(Failure::input)?;
    items.retain(|item| part.is_none() || item.asked.split == part);
    let unparsed = items
        .iter()
        .filter(|item| counted(item) && Selection::Failed.asks_anew(item))
        .count();
    if unparsed > 0 {
        let (answers, them) = match unparsed {
            1 => ("1 complete answer has".to_string(), "it"),
            n => (format!("{n} complete answers have"), "them"),
        };
        output::say(&format!(
            "nearmiss: {answers} no readable verdict (unparsed); `nearmiss evaluate {id} --retry-failed` asks for {them} again"
        ));
    }
    let open: Vec<_> = items
        .iter()
        .filter(|i| i.state != ItemState::Answered)
        .collect();
    if open.is_empty() {
        return Ok(());
    }
    // Questions that cannot be asked are no reason to try again.
    let (never, open): (Vec<&Item>, Vec<&Item>) = open
        .into_iter()
        .partition(|item| item.state == ItemState::Unaskable);
    if !never.is_empty() {
        let questions = number(never.len(), "question");
        output::say(&format!("nearmiss: {questions} cannot be asked:"));
        say_reasons(&never);
    }
    if open.is_empty() {
        return Ok(());
    }
    say_reasons(&open);
    let again = if open.iter().any(|item| Selection::Open.has(item.state)) {
        format!("`nearmiss evaluate {id}` asks them again")
    } else {
        format!("`nearmiss evaluate {id} --retry-failed` asks them again")
    };
    let askable = if never.is_empty() {
        ""
    } else {
        " that can be asked"
    };
    Err(Failure::finding(format!(
        "of {}{askable}, {} without a complete answer; {again}",
        number(items.len() - never.len(), "question"),
        open.len()
    )))
}

/// Says why these have no whole answer, what holds for most of them first.
fn say_reasons(items: &[&Item]) {
    let reasons = count_reasons(items.iter().copied());
    for (why, count) in reasons.iter().take(NAMED) {
        output::say(&format!("nearmiss: {count} × {why}"));
    }
    let more: usize = reasons.iter().skip(NAMED).map(|(_, count)| count).sum();
    if more > 0 {
        output::say(&format!("nearmiss: and {more} more for other reasons"));
    }
}

/// Reasons that are named each.
const NAMED: usize = 3;

/// Asks until everything is through, or until it is interrupted: then nothing more is begun, and what is on its way is
/// waited for a little. Nothing where it was interrupted, else who was not asked further.
async fn until_interrupted(
    run: &Arc<BatchRun>,
    items: Vec<Item>,
) -> Result<Option<Vec<PausedModel>>, Failure> {
    let mut meter = Meter::new(items.len());
    let all = Arc::clone(run).ask(items, |ended| meter.hear(&ended));
    tokio::pin!(all);
    tokio::select! {
        biased;
        done = &mut all => return done.map(Some).map_err(Failure::input),
        () = signal() => {}
    }
    run.control.stop();
    output::say("nearmiss: interrupted; waiting briefly for answers on their way");
    tokio::select! {
        done = &mut all => done.map(|_| None).map_err(Failure::input),
        () = tokio::time::sleep(GRACE) => Ok(None),
    }
}

/// Progress with rate and cost.
struct Meter {
    progress: Progress,
    begun: Instant,
    done: u32,
    usd: f64,
}

impl Meter {
    fn new(questions: usize) -> Self {
        Self {
            progress: Progress::with_words(questions, "answers"),
            begun: Instant::now(),
            done: 0,
            usd: 0.0,
        }
    }

    fn hear(&mut self, ended: &QuestionOutcome) {
        self.done += 1;
        self.usd += ended.cost_usd().unwrap_or(0.0);
        let rate = f64::from(self.done) / self.begun.elapsed().as_secs_f64().max(0.001);
        self.progress
            .say(format!("{rate:.1}/s, {:.4} USD", self.usd));
        self.progress.step();
    }
}
