//! Reading what all stored answers come to, with the truth by the built-in judge.

use std::collections::HashMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use super::Tasks;
use super::history::{Judging, Question, verdict};
use crate::evaluation::{Known, Results, results};
use crate::judge;
use crate::scenario::Entry;
use crate::store::{Store, StoredOutcome};
use crate::tui::message::Msg;
use crate::tui::message::runs::{ResultsAsk, ResultsNews};

/// What a truth is about: scenario, ego, task and window.
type About = (String, String, &'static str, Option<(i64, i64)>);

impl Tasks {
    /// Reads on a thread of its own; a newer reading, or closing the screen, ends an older one.
    pub(super) fn results(&mut self, ask: ResultsAsk) {
        self.results.store(true, Ordering::Relaxed);
        let stop = Arc::new(AtomicBool::new(false));
        self.results = Arc::clone(&stop);
        if matches!(ask, ResultsAsk::Stop) {
            return;
        }
        let judging = Judging {
            ego: self.ego.clone(),
            thresholds: self.thresholds.clone(),
        };
        let (path, sender) = (self.folders.store(), self.sender.clone());
        tokio::task::spawn_blocking(move || {
            // A store that is not there yet has no answers.
            let said = match Store::open(&path) {
                Ok(store) => answer(&store, &judging, ask, &stop),
                Err(error) => refused(ask, &error.to_string()),
            };
            if let Some(said) = said {
                let _ = sender.send(Msg::Results(said));
            }
        });
    }
}

fn refused(ask: ResultsAsk, why: &str) -> Option<ResultsNews> {
    match ask {
        ResultsAsk::Read(id, _) => Some(ResultsNews::Read(id, Err(why.into()))),
        ResultsAsk::Run(id) => Some(ResultsNews::Run(id, Err(why.into()))),
        ResultsAsk::Stop => None,
    }
}

/// What the store says to a question of the screen; nothing where it was told to stop.
#[must_use]
pub fn answer(
    store: &Store,
    judging: &Judging,
    ask: ResultsAsk,
    stop: &AtomicBool,
) -> Option<ResultsNews> {
    match ask {
        ResultsAsk::Stop => None,
        ResultsAsk::Run(id) => {
            let found = store.run(id).map(|run| run.map(Box::new));
            Some(ResultsNews::Run(id, found.map_err(|e| e.to_string())))
        }
        ResultsAsk::Read(id, entries) => {
            let rows = match store.decisions() {
                Ok(stored) => Ok(counted(stored, judging, &entries, stop)?),
                Err(error) => Err(error.to_string()),
            };
            Some(ResultsNews::Read(id, rows))
        }
    }
}

/// Counts what the models said; the judge's own runs are the truth, and what they do not say it is asked, where the
/// scenario is in the list.
fn counted(
    stored: Vec<StoredOutcome>,
    judging: &Judging,
    entries: &[Entry],
    stop: &AtomicBool,
) -> Option<Vec<Results>> {
    let mut truths: HashMap<About, Option<Known>> = HashMap::new();
    let (judges, models): (Vec<_>, Vec<_>) =
        stored.into_iter().partition(|o| o.model == judge::MODEL);
    for said in judges {
        // The newest comes first.
        if let (Some(about), Some(dangerous)) = (about(&said), said.dangerous) {
            let known = || Some(Known::judged(dangerous, said.named.iter().copied()));
            truths.entry(about).or_insert_with(known);
        }
    }
    let mut files: HashMap<&str, Vec<&Entry>> = HashMap::new();
    for entry in entries {
        files.entry(entry.name.as_str()).or_default().push(entry);
    }
    let mut all = Vec::with_capacity(models.len());
    for said in models {
        if stop.load(Ordering::Relaxed) {
            return None;
        }
        let truth = about(&said).and_then(|about| {
            let known = truths.entry(about).or_insert_with(|| {
                let question = Question {
                    task: said.task,
                    scenario_hash: said.scenario_hash.as_deref(),
                    ego: &said.ego,
                    window: said.window,
                };
                let files = files.get(said.scenario.as_str());
                let mut files = files.into_iter().flatten();
                files.find_map(|entry| known(entry, judging, &question))
            });
            known.clone()
        });
        all.push((said, truth));
    }
    Some(results(all))
}

/// Nothing where the scenario's contents are not known: its name alone might mean another one.
fn about(said: &StoredOutcome) -> Option<About> {
    let scenario = said.scenario_hash.clone()?;
    Some((scenario, said.ego.clone(), said.task.name(), said.window))
}

/// What the built-in judge says now.
fn known(entry: &Entry, judging: &Judging, question: &Question<'_>) -> Option<Known> {
    let verdict = verdict(entry, judging, question)?;
    let obstacles = verdict.obstacles.iter().map(|o| (o.id, o.risk_score));
    Some(Known::judged(verdict.dangerous, obstacles))
}
