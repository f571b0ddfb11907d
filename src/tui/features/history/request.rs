//! The history's own reader of the store: a thread with a connection of its own, so that nothing waits for a long
//! search.

use std::collections::HashMap;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};

use crate::message::Effect;
use crate::model::{Model, PageId};
use crate::request::{Replies, Request};
use crate::services::Services;
use nearmiss_base::system::{self, NewFile, SaveError};
use nearmiss_formats::{EgoSelection, Entry};
use nearmiss_scene::judge;
use nearmiss_scene::metrics::Thresholds;
use nearmiss_scene::verdict::{Task, Verdict};
use nearmiss_store::{Edge, Filter, Interrupter, Page, Run, RunId, Store, record_line};
use nearmiss_workflow::StoredQuestion;

/// Interval between checks for new runs in the store, while the history is open.
const LOOK: Duration = Duration::from_millis(400);

/// Requests of the history to the store.
#[derive(Debug)]
pub enum HistoryCommand {
    /// The screen is open: the store is watched.
    Open,
    /// The screen is closed.
    Close,
    /// A part of the list, of at most so many.
    Page(PageId, Filter, Edge, usize),
    /// How many runs fit.
    Count(Filter),
    /// A run whole; and the built-in judge's word on it, for which these files may be the scenario.
    Details(RunId, Vec<Entry>),
    /// Pin a run, or no longer.
    Pin(RunId, bool),
    /// Delete a run, or restore it.
    Delete(RunId, bool),
    /// Write what a person has to say about a run.
    Note(RunId, String),
    /// Write the runs that fit into a file, as JSON lines.
    Export(Filter, PathBuf),
}

/// Answers of the store to the history.
#[derive(Debug)]
pub enum HistoryEvent {
    /// A part of the list.
    Page(PageId, Edge, Result<Page, String>),
    /// How many runs fit.
    Counted(Filter, u64),
    /// A run, if it is still there.
    Details(RunId, Result<Option<Box<Run>>, String>),
    /// The built-in judge's answer to the same question: dangerous or not, where known.
    Truth(RunId, Option<bool>),
    /// The store was written to.
    Changed,
    /// A run was changed, or why not.
    Done(RunId, Result<(), String>),
    /// A file was written: what to say, or why not.
    Exported(Result<String, String>),
}

/// Reads for the history while it is open; ends when it is dropped.
struct Reader {
    commands: Sender<HistoryCommand>,
    reading: Arc<OnceLock<Interrupter>>,
}

/// Input for judging the question of a run.
#[derive(Debug, Clone)]
pub struct Judging {
    /// The ego of a scenario where no obstacle is taken in its place.
    pub ego: EgoSelection,
    /// The thresholds of risk scores.
    pub thresholds: Arc<Thresholds>,
}

impl Reader {
    /// Begins to read the store in a file.
    fn begin(path: PathBuf, judging: Judging, replies: Replies<HistoryCommand>) -> Self {
        let (commands, receiver) = channel();
        let reading = Arc::new(OnceLock::new());
        let interrupter = Arc::clone(&reading);
        std::thread::spawn(move || read(&path, &judging, &receiver, &interrupter, &replies));
        Self { commands, reading }
    }

    /// Asks for something. A list takes the place of one that is being read.
    fn send(&self, command: HistoryCommand) {
        if let (HistoryCommand::Page(..), Some(reading)) = (&command, self.reading.get()) {
            reading.interrupt();
        }
        // A reader that ended has said why.
        let _ = self.commands.send(command);
    }
}

/// The reader, while the history is open.
#[derive(Default)]
struct OpenReader(Option<Reader>);

impl Request for HistoryCommand {
    type Reply = HistoryEvent;

    /// Reads go to the history's own reader, changes to where all others are written.
    fn perform(self, services: &mut Services, replies: Replies<Self>) {
        let judging = Judging {
            ego: services.ego.clone(),
            thresholds: services.thresholds.clone(),
        };
        match self {
            Self::Close => services.state::<OpenReader>().0 = None,
            Self::Open => {
                let path = services.folders.store();
                let reader = Reader::begin(path, judging, replies);
                services.state::<OpenReader>().0 = Some(reader);
            }
            Self::Page(..) | Self::Count(..) | Self::Details(..) => {
                if let OpenReader(Some(reader)) = services.state() {
                    reader.send(self);
                }
            }
            Self::Pin(..) | Self::Delete(..) | Self::Note(..) | Self::Export(..) => {
                let Some(store) = services.store.clone() else {
                    let why = "runs are not stored, so nothing can be changed";
                    return replies.complain(why.into());
                };
                tokio::task::spawn_blocking(move || {
                    let mut truths = Truths::default();
                    for event in answer(&store, &judging, &mut truths, self) {
                        replies.send(event);
                    }
                });
            }
        }
    }

    fn reply(model: &mut Model, event: HistoryEvent) -> Vec<Effect> {
        vec![Effect::Step(super::on_event(model, event))]
    }
}

fn read(
    path: &Path,
    judging: &Judging,
    commands: &Receiver<HistoryCommand>,
    reading: &OnceLock<Interrupter>,
    replies: &Replies<HistoryCommand>,
) {
    let store = match Store::open_to_read(path) {
        Ok(store) => store,
        Err(error) => {
            let why = error.to_string();
            for command in commands {
                if let HistoryCommand::Page(id, _, edge, _) = command {
                    replies.send(HistoryEvent::Page(id, edge, Err(why.clone())));
                }
            }
            return;
        }
    };
    let _ = reading.set(store.interrupter());
    let mut truths = Truths::default();
    let mut version = store.version_of_data().ok();
    let mut wait = LOOK;
    loop {
        let first = match commands.recv_timeout(wait) {
            Ok(command) => Some(command),
            Err(RecvTimeoutError::Timeout) => None,
            Err(RecvTimeoutError::Disconnected) => return,
        };
        let idle = first.is_none();
        let begun = Instant::now();
        for command in newest(first.into_iter().chain(commands.try_iter())) {
            for event in answer(&store, judging, &mut truths, command) {
                if !replies.send(event) {
                    return;
                }
            }
        }
        if idle {
            let now = store.version_of_data().ok();
            if now != version && !replies.send(HistoryEvent::Changed) {
                return;
            }
            version = now;
        } else {
            // A search that takes long is not begun again and again while answers arrive.
            wait = LOOK.max(begun.elapsed() * 4);
        }
    }
}

/// Of what waits, the newest of each kind: the others are about what is not looked at any longer.
fn newest(commands: impl Iterator<Item = HistoryCommand>) -> Vec<HistoryCommand> {
    let mut kept: Vec<HistoryCommand> = Vec::new();
    for command in commands {
        let kind = std::mem::discriminant(&command);
        kept.retain(|other| std::mem::discriminant(other) != kind);
        kept.push(command);
    }
    // Visible rows are read first.
    kept.sort_by_key(|command| match command {
        HistoryCommand::Page(..) => 0,
        HistoryCommand::Details(..) => 1,
        _ => 2,
    });
    kept
}

/// The store's answer to a request of the history.
#[must_use]
pub fn answer(
    store: &Store,
    judging: &Judging,
    truths: &mut Truths,
    command: HistoryCommand,
) -> Vec<HistoryEvent> {
    match command {
        HistoryCommand::Page(id, filter, edge, most) => match store.page(&filter, edge, most) {
            // A newer list has been asked for.
            Err(error) if error.is_interrupted() => Vec::new(),
            found => vec![HistoryEvent::Page(
                id,
                edge,
                found.map_err(|e| e.to_string()),
            )],
        },
        HistoryCommand::Count(filter) => {
            let most = if filter == Filter::default() {
                u64::MAX
            } else {
                COUNTED
            };
            // A list without its length is worth as much.
            let counted = store.count_to(&filter, most).ok();
            counted
                .map(|n| HistoryEvent::Counted(filter, n))
                .into_iter()
                .collect()
        }
        HistoryCommand::Details(id, entries) => {
            let interrupted = |e: &nearmiss_store::StoreError| e.is_interrupted();
            let mut found = store.run_shown(id);
            if found.as_ref().is_err_and(interrupted) {
                found = store.run_shown(id);
            }
            let truth = match &found {
                Ok(Some(run)) => truths.of(store, judging, run, &entries),
                _ => None,
            };
            let found = found
                .map(|run| run.map(Box::new))
                .map_err(|e| e.to_string());
            vec![
                HistoryEvent::Details(id, found),
                HistoryEvent::Truth(id, truth),
            ]
        }
        HistoryCommand::Pin(id, pinned) => vec![done(id, store.pin(id, pinned))],
        HistoryCommand::Delete(id, deleted) => vec![done(id, store.delete(id, deleted))],
        HistoryCommand::Note(id, words) => vec![done(id, store.note(id, &words))],
        HistoryCommand::Export(filter, path) => {
            vec![HistoryEvent::Exported(export(store, &filter, &path))]
        }
        HistoryCommand::Open | HistoryCommand::Close => Vec::new(),
    }
}

/// Runs that fit are counted this far where there is a filter.
const COUNTED: u64 = 10_000;

fn done(id: nearmiss_store::RunId, result: Result<(), nearmiss_store::StoreError>) -> HistoryEvent {
    HistoryEvent::Done(id, result.map_err(|e| e.to_string()))
}

/// Writes the runs that fit into a new file, as `nearmiss runs export` does: whole or not at all.
fn export(store: &Store, filter: &Filter, path: &Path) -> Result<String, String> {
    let wrong =
        |error: &std::io::Error| format!("{}: {}", path.display(), system::error_text(error));
    let file = NewFile::begin(path, false).map_err(|error| match error {
        SaveError::Exists(path) => {
            format!("{} exists already; choose another name", path.display())
        }
        other => other.to_string(),
    })?;
    let mut writer = std::io::BufWriter::new(file);
    let numbers = store.numbers(filter).map_err(|e| e.to_string())?;
    let superseded = store.superseded().map_err(|e| e.to_string())?;
    let mut written = 0;
    for number in numbers {
        // One that is gone meanwhile is no longer listed either.
        if let Some(run) = store.run(number).map_err(|e| e.to_string())? {
            let record = run.to_record(superseded.contains(&number));
            let line = record_line(&record).map_err(|e| e.to_string())?;
            writer.write_all(line.as_bytes()).map_err(|e| wrong(&e))?;
            written += 1;
        }
    }
    let file = writer.into_inner().map_err(|e| wrong(e.error()))?;
    file.finish().map_err(|error| error.to_string())?;
    Ok(format!("{written} runs written to {}", path.display()))
}

/// The built-in judge's answers to the questions of runs, as far as asked.
#[derive(Debug, Default)]
pub struct Truths(HashMap<TruthKey, Option<bool>>);

/// The key of a ground truth: scenario, ego, task and window.
type TruthKey = (String, String, &'static str, Option<(i64, i64)>);

impl Truths {
    /// The stored answer, else the one judged from the scenario if it is among these files.
    fn of(&mut self, store: &Store, judging: &Judging, run: &Run, files: &[Entry]) -> Option<bool> {
        if run.question.model == judge::MODEL {
            return None;
        }
        if let Ok(Some(said)) = store.verdict_beside(run, judge::MODEL) {
            return Some(said);
        }
        let question = &run.question;
        let about = (
            question.scenario_hash.clone()?,
            question.ego.clone(),
            question.task.name(),
            question.window,
        );
        if let Some(known) = self.0.get(&about) {
            return *known;
        }
        let asked = StoredQuestion {
            task: question.task,
            scenario: &question.scenario,
            scenario_hash: question.scenario_hash.as_deref(),
            ego: Some(&question.ego),
            window: question.window,
        };
        let said = files
            .iter()
            .find_map(|entry| verdict(entry, judging, &asked))
            .map(|verdict| verdict.dangerous);
        self.0.insert(about, said);
        said
    }
}

/// The built-in judge's answer to the question of a run, if this file is its scenario.
fn verdict(entry: &Entry, judging: &Judging, question: &StoredQuestion<'_>) -> Option<Verdict> {
    if !Task::VERDICTS.contains(&question.task) {
        return None;
    }
    let scene = question.scene(entry, &judging.ego)?;
    question.judged(&scene, &judging.thresholds)
}
