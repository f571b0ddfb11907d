//! A batch on its way: progress, interruption, and the table at its end.

use std::collections::HashMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use tokio::runtime::Runtime;

use super::batch::Options;
use super::handed;
use super::opened::Opened;
use super::sheet::Sheet;
use super::shown::Rows;
use super::varied::Varied;
use crate::cli::batches::lost;
use crate::cli::interrupt::{GRACE, INTERRUPTED, signal};
use crate::cli::progress::Progress;
use crate::cli::{Failure, Outcome, output};
use crate::evaluation::batch::{Asking, Desk, Ended, Judges, Paused, Selection, answers};
use crate::evaluation::can_ask;
use crate::store::{BatchId, Identity, Item, ItemState, Key};

/// A batch that is written down.
pub struct BatchRun {
    pub id: BatchId,
    pub judges: Judges,
    pub desk: Arc<Desk>,
    pub selection: Selection,
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

/// The models that cannot be asked as things stand, and why.
pub fn refused(runtime: &Runtime, sheet: &Sheet, judges: &Judges) -> Vec<(String, String)> {
    let ask = async {
        let mut refused = Vec::new();
        for (model, question) in &sheet.first {
            if let Err(why) = can_ask(question, &judges[model]).await {
                refused.push((model.clone(), why.to_string()));
            }
        }
        refused
    };
    runtime.block_on(ask)
}

/// Nothing is begun where a model would refuse every question.
pub fn all_can_be_asked(refused: &[(String, String)]) -> Outcome {
    match refused {
        [] => Ok(()),
        [(model, why), ..] => Err(Failure::input(format!("{model}: {why}"))),
    }
}

/// Asks what a batch has to ask, then writes its table.
pub fn ask(
    runtime: &Runtime,
    opened: &Opened,
    options: &Options,
    going: BatchRun,
    sheet: &Sheet,
) -> Outcome {
    let BatchRun { id, selection, .. } = going;
    let items = opened.store.items(id).map_err(Failure::input)?;
    let mut items: Vec<Item> = items
        .into_iter()
        .filter(|i| selection.has(i.state))
        .collect();
    // What failed before may fail again and again, and must not keep what was never asked from its turn.
    items.sort_by_key(|item| item.state != ItemState::Waiting);
    // The questions were made for the estimate: with these keys nobody has to make them again to know who has them.
    let made = sheet.items.iter().map(|item| (item.identity(), &item.key));
    let made: HashMap<Identity<'_>, &Option<Key>> = made.collect();
    for item in &mut items {
        if let Some(key) = made.get(&item.asked.identity()) {
            let key = Option::clone(key);
            item.asked.key = key;
        }
    }
    output::say(&format!("nearmiss: {id}: {}", sheet.line()));
    let asking = Arc::new(Asking {
        store: Arc::clone(&opened.store),
        batch: id,
        desk: going.desk,
        at_once: opened.at_once(&going.judges, options),
        judges: going.judges,
        stop: Arc::new(AtomicBool::new(false)),
    });
    let (items, with_providers) = asking.without_handed(items).map_err(Failure::input)?;
    if with_providers > 0 {
        output::say(&format!(
            "nearmiss: {with_providers} of them with a provider: `nearmiss batches collect` fetches their answers"
        ));
    }
    for batch in opened.store.provider_batches().map_err(Failure::input)? {
        if let Some(words) = lost(&batch) {
            output::say(&format!("nearmiss: batch {}: {words}", batch.id));
        }
    }
    let items = match options.batch {
        true => match handed::over(runtime, &asking, items)? {
            handed::Left::Nothing => return Ok(()),
            handed::Left::Own(items) => items,
        },
        false => items,
    };
    let Some(paused) = runtime.block_on(until_interrupted(&asking, items))? else {
        return Err(Failure {
            message: format!(
                "interrupted; `nearmiss evaluate --resume {id}` goes on with it, and asks again what had no answer yet"
            ),
            status: INTERRUPTED,
        });
    };
    for one in &paused {
        output::say(&format!("nearmiss: {}", output::visible(&words(one))));
    }
    show(opened, id, going.json, going.csv)
}

/// Who was not asked further, and why.
fn words(paused: &Paused) -> String {
    let after = match paused.after {
        1 => "after one question that it refused".to_string(),
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
pub fn show(opened: &Opened, id: BatchId, json: bool, csv: bool) -> Outcome {
    let answers = answers(&opened.store, id).map_err(Failure::input)?;
    let rows = Rows::of(&answers.plain);
    let varied = Varied::of(&answers);
    if json {
        let mut document = rows.document(Some(id));
        varied.add_to(&mut document);
        output::json(&document)?;
    } else if csv {
        output::text(&rows.csv()?)?;
    } else {
        output::text(&(rows.table() + &varied.tables()))?;
    }
    unanswered(opened, id)
}

/// Says which questions have no whole answer, and why.
fn unanswered(opened: &Opened, id: BatchId) -> Outcome {
    let items = opened.store.items(id).map_err(Failure::input)?;
    let open: Vec<_> = items
        .iter()
        .filter(|i| i.state != ItemState::Answered)
        .collect();
    if open.is_empty() {
        return Ok(());
    }
    // What cannot be asked is no reason to try again.
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
            "of {}{askable}, {} without a whole answer; {again}",
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
    asking: &Arc<Asking>,
    items: Vec<Item>,
) -> Result<Option<Vec<Paused>>, Failure> {
    let mut meter = Meter::new(items.len());
    let all = Arc::clone(asking).all(items, |ended| meter.hear(&ended));
    tokio::pin!(all);
    tokio::select! {
        biased;
        done = &mut all => return done.map(Some).map_err(Failure::input),
        () = signal() => {}
    }
    asking.stop.store(true, Ordering::SeqCst);
    output::say("nearmiss: interrupted; answers that arrive within a moment are kept");
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

    fn hear(&mut self, ended: &Ended) {
        self.done += 1;
        self.usd += ended.cost_usd.unwrap_or(0.0);
        let rate = f64::from(self.done) / self.begun.elapsed().as_secs_f64().max(0.001);
        self.progress
            .say(format!("{rate:.1}/s, {:.4} USD", self.usd));
        self.progress.step();
    }
}
