//! Reading what stored answers come to: which are counted, and what is true about them.

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use crate::features::history::request::Judging;
use crate::features::pictures::save_new;
use crate::message::Effect;
use crate::model::{CountedAnswers, Model, PageId};
use crate::request::{Replies, Request};
use crate::services::Services;
use nearmiss_formats::Entry;
use nearmiss_record::{Table, columns};
use nearmiss_scene::judge;
use nearmiss_store::{Filter, Run, RunId, Store, StoreError};
use nearmiss_study::evaluation::batch::{self, AnswerSet, BatchResults};
use nearmiss_study::evaluation::report::{self, Truth};
use nearmiss_study::evaluation::{self, Results, ResultsRow, Scored, with_intervals};
use nearmiss_workflow::{TruthChoice, TruthSearch};

/// Requests of the results screen to the store.
#[derive(Debug)]
pub enum ResultsCommand {
    /// Stored answers counted.
    Read(ResultsQuery),
    /// A run whole.
    Run(RunId),
    /// Write these rows, with words about what they are, into new files in a folder.
    Export(Vec<Results>, String, Option<PathBuf>),
    /// Stop reading.
    Stop,
}

/// Which stored answers are counted, and against which truth.
#[derive(Debug, Clone)]
pub struct ResultsQuery {
    /// The number of the reading.
    pub id: PageId,
    /// The answers; else those of the newest batch, or all where there is no batch.
    pub answers: Option<AnswerSet>,
    /// What they are compared with.
    pub truth: TruthChoice,
    /// Files that may be their scenarios.
    pub entries: Vec<Entry>,
}

/// Answers of the store to the results screen.
#[derive(Debug)]
pub enum ResultsEvent {
    /// The counted answers.
    Read(PageId, Result<Box<CountedAnswers>, String>),
    /// How many scenarios of how many were opened to find out what is true about them.
    Judging(PageId, (usize, usize)),
    /// The files that were written.
    Exported(Result<String, String>),
    /// A run, if it is still there.
    Run(RunId, Result<Option<Box<Run>>, String>),
}

/// Tells the reading that is under way to end.
#[derive(Default)]
struct StopReading(Arc<AtomicBool>);

impl Request for ResultsCommand {
    type Reply = ResultsEvent;

    /// Reads on a thread of its own; a newer reading, or closing the screen, ends an older one.
    fn perform(self, services: &mut Services, replies: Replies<Self>) {
        let current = services.state::<StopReading>();
        if matches!(self, Self::Read(..) | Self::Stop) {
            current.0.store(true, Ordering::Relaxed);
            *current = StopReading::default();
        }
        if matches!(self, Self::Stop) {
            return;
        }
        let stop = Arc::clone(&current.0);
        let judging = Judging {
            ego: services.ego.clone(),
            thresholds: services.thresholds.clone(),
        };
        let path = services.folders.store();
        tokio::task::spawn_blocking(move || {
            let mut reply = |event| {
                replies.send(event);
            };
            // A store that is not there yet has no answers.
            match Store::open_to_read(&path) {
                Ok(store) => answer(&store, &judging, self, &stop, &mut reply),
                Err(error) => refused(self, &error.to_string(), &mut reply),
            }
        });
    }

    fn reply(model: &mut Model, event: ResultsEvent) -> Vec<Effect> {
        vec![Effect::Step(super::on_event(model, event))]
    }
}

fn refused(command: ResultsCommand, why: &str, say: &mut (dyn FnMut(ResultsEvent) + Send)) {
    match command {
        ResultsCommand::Read(query) => say(ResultsEvent::Read(query.id, Err(why.into()))),
        ResultsCommand::Run(id) => say(ResultsEvent::Run(id, Err(why.into()))),
        ResultsCommand::Export(..) => say(ResultsEvent::Exported(Err(why.into()))),
        ResultsCommand::Stop => {}
    }
}

/// Says what the store says to a question of the screen; nothing more where it was told to stop.
pub fn answer(
    store: &Store,
    judging: &Judging,
    command: ResultsCommand,
    stop: &AtomicBool,
    say: &mut (dyn FnMut(ResultsEvent) + Send),
) {
    match command {
        ResultsCommand::Stop => {}
        ResultsCommand::Run(id) => {
            let found = store.run_shown(id).map(|run| run.map(Box::new));
            say(ResultsEvent::Run(id, found.map_err(|e| e.to_string())));
        }
        ResultsCommand::Export(rows, truth, folder) => {
            say(ResultsEvent::Exported(export(&rows, &truth, folder)));
        }
        ResultsCommand::Read(query) => {
            let said = Mutex::new(say);
            if let Err(error) = read(store, judging, &query, stop, &said) {
                tell(&said, ResultsEvent::Read(query.id, Err(error.to_string())));
            }
        }
    }
}

/// Writes rows as CSV and as JSON lines, each with what it is compared with; gives the names of the files.
fn export(rows: &[Results], truth: &str, folder: Option<PathBuf>) -> Result<String, String> {
    let folder = folder.unwrap_or_else(|| PathBuf::from("."));
    let rows: Vec<ResultsRow> = rows.iter().map(|row| row.row(truth)).collect();
    let failed = |error: serde_json::Error| error.to_string();
    let table = Table::new("results", columns::<ResultsRow>());
    let table = table.csv(nearmiss_record::rows(&rows).map_err(failed)?);
    let lines = rows.iter().map(nearmiss_record::json_line);
    let lines: Vec<String> = lines.collect::<Result<_, _>>().map_err(failed)?;
    let table = save_new(&folder, "results", "csv", &table)?;
    let lines = save_new(&folder, "results", "jsonl", lines.concat().as_bytes())?;
    Ok(format!("{table} and {lines}"))
}

/// Where events go, from several threads.
type Listener<'a> = Mutex<&'a mut (dyn FnMut(ResultsEvent) + Send)>;

fn tell(listener: &Listener<'_>, event: ResultsEvent) {
    let mut say = listener.lock().unwrap_or_else(PoisonError::into_inner);
    say(event);
}

/// Scenarios that are opened between two frames with new numbers, at least.
const STEP: usize = 5;

fn read(
    store: &Store,
    judging: &Judging,
    query: &ResultsQuery,
    stop: &AtomicBool,
    listener: &Listener<'_>,
) -> Result<(), StoreError> {
    let offers = batch::offers(store)?;
    // The newest batch that has answers; what cannot be asked, or was not yet, tells nothing.
    let answered = offers.iter().find(|offer| offer.progress.answered > 0);
    let first = answered.map_or(AnswerSet::Everything, |offer| offer.counting);
    let counting = query.answers.unwrap_or(first);
    let outcomes = store.outcomes(&Filter::default())?;
    let search = TruthSearch {
        outcomes: &outcomes,
        entries: &query.entries,
        ego: &judging.ego,
        thresholds: &judging.thresholds,
    };
    let (mut truth, truths) = search.stored(store, query.truth)?;
    let choice = if truths.contains(&query.truth) {
        query.truth
    } else {
        TruthChoice::Usual
    };
    if choice != query.truth {
        (truth, _) = search.stored(store, choice)?;
    }
    let show = |found: BatchResults, judging: Option<(usize, usize)>| {
        let read = CountedAnswers {
            counting,
            offers: offers.clone(),
            truth: choice,
            truths: truths.clone(),
            rows: found.rows,
            unasked: found.unasked,
            left_out: found.left_out,
            locked: found.locked,
            judging,
        };
        tell(listener, ResultsEvent::Read(query.id, Ok(Box::new(read))));
    };
    let is_own = matches!(counting, AnswerSet::Batch(..)) && choice == TruthChoice::Usual;
    let count = |truth: &Truth| match counting {
        AnswerSet::Batch(batch, part) => {
            let by_run: HashMap<_, _> = if is_own {
                HashMap::new()
            } else {
                outcomes.iter().map(|one| (one.run, one)).collect()
            };
            let other = |scored: &Scored| {
                let outcome = by_run.get(&scored.run?)?;
                truth.lookup(outcome)
            };
            let other = (!is_own).then_some(&other as batch::OtherTruth<'_>);
            batch::counted(store, batch, part, other, stop)
        }
        AnswerSet::Everything => {
            let stored = report::stored(&outcomes, truth, &store.asides()?);
            let is_judge = |one: &&Scored| one.configuration.model == judge::MODEL;
            let by_itself = choice == TruthChoice::Judge;
            let scored = stored.scored.iter();
            let rows = evaluation::results(scored.filter(|one| !(by_itself && is_judge(one))));
            Ok(Some(BatchResults {
                rows,
                left_out: stored
                    .left_out()
                    .into_iter()
                    .map(|(words, _)| words)
                    .collect(),
                ..BatchResults::default()
            }))
        }
    };
    if !is_own {
        // What is known without opening a scenario is shown at once, then how far that is.
        if let Some(early) = count(&truth)? {
            let progress = |done, of| {
                if done % STEP == 0 || done == of {
                    tell(listener, ResultsEvent::Judging(query.id, (done, of)));
                }
            };
            show(early, Some((0, 0)));
            if !search.complete(choice, &mut truth, stop, &progress) {
                return Ok(());
            }
        }
    }
    if let Some(found) = count(&truth)? {
        let rows = with_intervals(found.rows);
        show(BatchResults { rows, ..found }, None);
    }
    Ok(())
}
