//! A running batch: progress, interruption, and the final table.

use std::sync::Arc;
use std::time::Instant;

use tokio::runtime::Runtime;

use super::context::BatchContext;
use super::table::Rows;
use super::varied::Varied;
use super::{dry_run, submit};
use crate::cli::batches::lost;
use crate::cli::interrupt::{GRACE, INTERRUPTED, signal};
use crate::cli::progress::Progress;
use crate::cli::{Failure, Outcome, output};
use crate::evaluation::batch::answers;
use crate::store::{BatchId, Item, ItemState};
use crate::workflow::batch::{BatchRun, DryRun, PausedModel, QuestionOutcome, Selection};

/// Format of a batch's table.
#[derive(Debug, Clone, Copy)]
pub struct Table {
    pub json: bool,
    pub csv: bool,
}

/// Threads that wait for the network and the disk. An answer's thread waits until it is on the disk; the more wait at
/// once, the more share a sync.
const WAITING: usize = 16;

/// What waits for the network.
pub fn runtime() -> Result<Runtime, Failure> {
    tokio::runtime::Builder::new_multi_thread()
        .worker_threads(WAITING)
        .enable_all()
        .build()
        .map_err(Failure::input)
}

/// Asks what a batch has to ask, or submits it to the providers, then writes its table.
pub fn ask(
    runtime: &Runtime,
    context: &BatchContext,
    run: &Arc<BatchRun>,
    dry_run: &DryRun,
    (submits, table): (bool, Table),
) -> Outcome {
    let id = run.id;
    output::say(&format!("nearmiss: {id}: {}", dry_run::line(dry_run)));
    let (items, with_providers) = run.items(dry_run).map_err(Failure::input)?;
    if with_providers > 0 {
        output::say(&format!(
            "nearmiss: {with_providers} of them submitted to providers: `nearmiss batches collect` fetches the answers"
        ));
    }
    for batch in context.store.provider_batches().map_err(Failure::input)? {
        if let Some(words) = lost(&batch) {
            output::say(&format!("nearmiss: batch {}: {words}", batch.id));
        }
    }
    let items = match submits {
        true => match submit::submit(runtime, run, items)? {
            submit::Left::Nothing => return Ok(()),
            submit::Left::Own(items) => items,
        },
        false => items,
    };
    let Some(paused) = runtime.block_on(until_interrupted(run, items))? else {
        return Err(Failure {
            message: format!("interrupted; `nearmiss evaluate --resume {id}` continues it"),
            status: INTERRUPTED,
        });
    };
    for one in &paused {
        output::say(&format!("nearmiss: {}", output::visible(&words(one))));
    }
    show(context, id, table)
}

/// Who was not asked further, and why.
fn words(paused: &PausedModel) -> String {
    let after = match paused.after {
        1 => "after one rejected question".to_string(),
        after => format!("after {after} questions in a row without an answer"),
    };
    let open = super::number(paused.open, "question");
    let stay = if paused.open == 1 { "stays" } else { "stay" };
    format!(
        "{}: not asked further {after}: {}; {open} {stay} open",
        paused.who, paused.why
    )
}

/// Writes the table of a batch as it stands.
pub fn show(context: &BatchContext, id: BatchId, table: Table) -> Outcome {
    let answers = answers(&context.store, id).map_err(Failure::input)?;
    let rows = Rows::from_scored(&answers.plain);
    let varied = Varied::from_answers(&answers);
    if table.json {
        let mut document = rows.document(Some(id));
        varied.add_to(&mut document);
        output::json(&document)?;
    } else if table.csv {
        rows.write_csv()?;
    } else {
        output::text(&(rows.table() + &varied.tables()))?;
    }
    unanswered(context, id)
}

/// Says which questions have no whole answer, and why.
fn unanswered(context: &BatchContext, id: BatchId) -> Outcome {
    let items = context.store.items(id).map_err(Failure::input)?;
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
        let questions = super::number(never.len(), "question");
        output::say(&format!("nearmiss: {questions} cannot be asked:"));
        say_reasons(&never);
    }
    if open.is_empty() {
        return Ok(());
    }
    say_reasons(&open);
    let again = match open.iter().any(|item| Selection::Open.has(item.state)) {
        true => format!("`nearmiss evaluate --resume {id}` asks them again"),
        false => format!("`nearmiss evaluate --resume {id} --retry-failed` asks them again"),
    };
    let askable = match never.is_empty() {
        true => "",
        false => " that can be asked",
    };
    Err(Failure {
        message: format!(
            "of {}{askable}, {} without a complete answer; {again}",
            super::number(items.len() - never.len(), "question"),
            open.len()
        ),
        status: 1,
    })
}

/// Says why these have no whole answer, what holds for most of them first.
fn say_reasons(items: &[&Item]) {
    let mut reasons: Vec<(&str, usize)> = Vec::new();
    for item in items {
        let why = item.error.as_deref().unwrap_or("not asked yet");
        match reasons.iter_mut().find(|(known, _)| *known == why) {
            Some((_, count)) => *count += 1,
            None => reasons.push((why, 1)),
        }
    }
    reasons.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
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
