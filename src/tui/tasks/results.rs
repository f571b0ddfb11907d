//! Reading what stored answers come to: a batch by its own truth, or all of them with the truth by the built-in judge.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use super::Tasks;
use super::history::{Judging, Question, scene_of, verdict_on};
use crate::evaluation::batch::{self, AnswerSet};
use crate::evaluation::{GroundTruth, Results, results, with_intervals};
use crate::formats::Entry;
use crate::judge;
use crate::scenario::Transform;
use crate::store::{Store, StoredOutcome};
use crate::tui::message::Msg;
use crate::tui::message::runs::{CountedAnswers, PageId, ResultsCommand, ResultsEvent};

/// The key of a ground truth: scenario, ego, task and window.
type TruthKey<'a> = (&'a str, &'a str, &'static str, Option<(i64, i64)>);

impl Tasks {
    /// Reads on a thread of its own; a newer reading, or closing the screen, ends an older one.
    pub(super) fn results(&mut self, command: ResultsCommand) {
        self.results.store(true, Ordering::Relaxed);
        let stop = Arc::new(AtomicBool::new(false));
        self.results = Arc::clone(&stop);
        if matches!(command, ResultsCommand::Stop) {
            return;
        }
        let judging = Judging {
            ego: self.ego.clone(),
            thresholds: self.thresholds.clone(),
        };
        let (path, sender) = (self.folders.store(), self.sender.clone());
        tokio::task::spawn_blocking(move || {
            let mut say = |event| {
                // The receiver is gone once the loop has ended.
                let _ = sender.send(Msg::Results(event));
            };
            // A store that is not there yet has no answers.
            match Store::open_to_read(&path) {
                Ok(store) => answer(&store, &judging, command, &stop, &mut say),
                Err(error) => refused(command, &error.to_string(), &mut say),
            }
        });
    }
}

fn refused(command: ResultsCommand, why: &str, say: &mut dyn FnMut(ResultsEvent)) {
    match command {
        ResultsCommand::Read(id, ..) => say(ResultsEvent::Read(id, Err(why.into()))),
        ResultsCommand::Run(id) => say(ResultsEvent::Run(id, Err(why.into()))),
        ResultsCommand::Stop => {}
    }
}

/// Says what the store says to a question of the screen; nothing more where it was told to stop.
pub fn answer(
    store: &Store,
    judging: &Judging,
    command: ResultsCommand,
    stop: &AtomicBool,
    say: &mut dyn FnMut(ResultsEvent),
) {
    match command {
        ResultsCommand::Stop => {}
        ResultsCommand::Run(id) => {
            let found = store.run_shown(id).map(|run| run.map(Box::new));
            say(ResultsEvent::Run(id, found.map_err(|e| e.to_string())));
        }
        ResultsCommand::Read(id, chosen, entries) => {
            let read = read(store, judging, (id, chosen, &entries), stop, say);
            if let Err(error) = read {
                say(ResultsEvent::Read(id, Err(error.to_string())));
            }
        }
    }
}

fn read(
    store: &Store,
    judging: &Judging,
    (id, chosen, entries): (PageId, Option<AnswerSet>, &[Entry]),
    stop: &AtomicBool,
    say: &mut dyn FnMut(ResultsEvent),
) -> Result<(), crate::store::StoreError> {
    let offers = batch::offers(store)?;
    // The newest batch that has answers; what cannot be asked, or was not yet, tells nothing.
    let answered = offers.iter().find(|offer| offer.progress.answered > 0);
    let first = answered.map_or(AnswerSet::Everything, |offer| offer.counting);
    let counting = chosen.unwrap_or(first);
    let mut tell = |rows: Vec<Results>, unasked: usize, whole: bool| {
        let read = CountedAnswers {
            counting,
            offers: offers.clone(),
            rows,
            unasked,
            whole,
        };
        say(ResultsEvent::Read(id, Ok(Box::new(read))));
    };
    match counting {
        AnswerSet::Batch(batch, part) => {
            if let Some(found) = batch::counted(store, batch, part, stop)? {
                tell(with_intervals(found.rows), found.unasked, true);
            }
        }
        AnswerSet::Everything => {
            let stored = store.decisions()?;
            let early = |rows| tell(rows, 0, false);
            if let Some(rows) = everything(&stored, judging, entries, stop, early) {
                tell(with_intervals(rows), 0, true);
            }
        }
    }
    Ok(())
}

/// Counts what the models said; the judge's own runs are the truth, and what they do not say it is asked, where the
/// scenario is in the list. As that takes its time, what is known without it is counted `early`.
fn everything(
    stored: &[StoredOutcome],
    judging: &Judging,
    entries: &[Entry],
    stop: &AtomicBool,
    early: impl FnOnce(Vec<Results>),
) -> Option<Vec<Results>> {
    let (judges, models): (Vec<_>, Vec<_>) = stored.iter().partition(|o| o.model == judge::MODEL);
    let mut truths: HashMap<TruthKey<'_>, GroundTruth> = HashMap::new();
    for said in judges {
        // The newest comes first.
        if let (Some(about), Some(dangerous)) = (about(said), said.dangerous) {
            let known = || GroundTruth::judged(dangerous, said.named.iter().copied());
            truths.entry(about).or_insert_with(known);
        }
    }
    let count = |truths: &HashMap<TruthKey<'_>, GroundTruth>| {
        let known = |said| about(said).and_then(|about| truths.get(&about));
        results(models.iter().map(|said| (*said, known(said))))
    };
    let unknown = unknown(&models, entries, &truths);
    if unknown.is_empty() {
        return Some(count(&truths));
    }
    early(count(&truths));
    let judged: Vec<_> = unknown
        .into_par_iter()
        .flat_map_iter(|(files, asked)| match stop.load(Ordering::Relaxed) {
            true => Vec::new(),
            false => judged(&files, &asked, judging),
        })
        .collect();
    if stop.load(Ordering::Relaxed) {
        return None;
    }
    truths.extend(judged);
    Some(count(&truths))
}

/// Questions about one scene, and the files that may be its scenario.
type Scene<'a> = (Vec<&'a Entry>, Vec<&'a StoredOutcome>);

/// One question of each kind without a ground truth, by scenes.
fn unknown<'a>(
    models: &[&'a StoredOutcome],
    entries: &'a [Entry],
    truths: &HashMap<TruthKey<'a>, GroundTruth>,
) -> Vec<Scene<'a>> {
    let mut files: HashMap<&str, Vec<&Entry>> = HashMap::new();
    for entry in entries {
        files.entry(entry.name.as_str()).or_default().push(entry);
    }
    let mut seen = HashSet::new();
    let mut scenes: BTreeMap<(&str, &str), Scene<'a>> = BTreeMap::new();
    for said in models {
        let Some(about) = about(said) else { continue };
        let (name, _) = Transform::of_name(&said.scenario);
        let Some(files) = files.get(name) else {
            continue;
        };
        if !truths.contains_key(&about) && seen.insert(about) {
            let scene = scenes.entry((about.0, about.1));
            let (_, asked) = scene.or_insert_with(|| (files.clone(), Vec::new()));
            asked.push(said);
        }
    }
    scenes.into_values().collect()
}

/// The built-in judge's answers to questions about one scene; empty if no file holds it.
fn judged<'a>(
    files: &[&Entry],
    asked: &[&'a StoredOutcome],
    judging: &Judging,
) -> Vec<(TruthKey<'a>, GroundTruth)> {
    let question = |said: &&'a StoredOutcome| Question {
        task: said.task,
        scenario: &said.scenario,
        scenario_hash: said.scenario_hash.as_deref(),
        ego: &said.ego,
        window: said.window,
    };
    let Some(first) = asked.first().map(question) else {
        return Vec::new();
    };
    let mut scenes = files
        .iter()
        .filter_map(|entry| scene_of(entry, judging, &first));
    let Some(scene) = scenes.next() else {
        return Vec::new();
    };
    let known = |said: &&'a StoredOutcome| {
        let verdict = verdict_on(&scene, judging, &question(said))?;
        let obstacles = verdict.obstacles.iter().map(|o| (o.id, o.risk_score));
        Some((
            about(said)?,
            GroundTruth::judged(verdict.dangerous, obstacles),
        ))
    };
    asked.iter().filter_map(known).collect()
}

/// Nothing where the scenario's contents are not known: its name alone might mean another one.
fn about(said: &StoredOutcome) -> Option<TruthKey<'_>> {
    let scenario = said.scenario_hash.as_deref()?;
    Some((scenario, &said.ego, said.task.name(), said.window))
}
