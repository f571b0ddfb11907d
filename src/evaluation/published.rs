//! Recorded answers as runs for the store, matched to scenarios in the same folder.

use std::collections::BTreeMap;
use std::path::Path;

use rayon::prelude::*;
use serde_json::json;

use super::answer::reading;
use super::labels::Label;
use super::lead::{Labelled, Lead};
use super::recorded::{Loss, Problem, Recorded, find};
use crate::formats::Entry;
use crate::scenario::{Scene, Window};
use crate::store::{Ending, Key, NewRun, Origin, Run, RunId, RunState};
use crate::verdict::Task;

/// Steps that the paper's scripts describe.
pub(super) const HISTORY: usize = 10;

/// A scenario whose file was found.
#[derive(Debug, Clone, PartialEq)]
struct Tied {
    hash: String,
    ego: Option<Driven>,
}

/// A recorded ego.
#[derive(Debug, Clone, PartialEq)]
struct Driven {
    /// As the store writes it.
    ego: String,
    /// The paper's window in collisions, and in safe scenarios.
    windows: [Option<(i64, i64)>; 2],
}

/// Every answer recorded below `root`, as a run that was read at `now_ms`, and everything there that is none.
///
/// An answer is tied to its scenario by the name, and by the hash of the file where that lies below the same folder.
/// The window of the safety task is the paper's; of the other tasks it is not known.
#[must_use]
pub fn runs(root: &Path, now_ms: i64) -> (Vec<Run>, Vec<Problem>) {
    let (answers, mut problems) = find(root);
    let files = scenarios(root);
    let mut names: Vec<(&str, bool)> = answers.iter().map(of).collect();
    names.sort_unstable();
    names.dedup();
    let read = names.into_par_iter().map(|(name, collision)| {
        let entry = files.get(name).map(|files| chosen(files, collision));
        ((name, collision), entry.map(tie).transpose())
    });
    let mut tied = BTreeMap::new();
    for (name, found) in read.collect::<Vec<_>>() {
        match found {
            Ok(found) => drop(tied.insert(name, found)),
            Err(problem) => problems.push(problem),
        }
    }
    let run = |answer| {
        let tied = tied.get(&of(answer)).and_then(Option::as_ref);
        run_of(answer, tied, root, now_ms)
    };
    let runs = answers.iter().map(run).collect();
    (runs, problems)
}

/// The scenario that an answer is about, and in which half of the data.
fn of(answer: &Recorded) -> (&str, bool) {
    (&answer.scenario, answer.collision)
}

/// The scenarios below a folder by name; none where there is none, which is said answer by answer.
pub(super) fn scenarios(root: &Path) -> BTreeMap<String, Vec<Entry>> {
    let mut files: BTreeMap<String, Vec<Entry>> = BTreeMap::new();
    let found = crate::formats::find(&[root.to_path_buf()]);
    for entry in found.map(|found| found.entries).unwrap_or_default() {
        files.entry(entry.name.clone()).or_default().push(entry);
    }
    files
}

/// Of several files of one name the one in the half of the data that the answer is from.
pub(super) fn chosen(files: &[Entry], collision: bool) -> &Entry {
    let half = |entry: &&Entry| entry.group.starts_with("normal") != collision;
    files.iter().find(half).unwrap_or(&files[0])
}

fn tie(entry: &Entry) -> Result<Tied, Problem> {
    let problem = |message: String| Problem {
        path: entry.display().into(),
        message,
        loss: Loss::Unread,
    };
    let scenario = entry.read().map_err(|e| problem(e.to_string()))?;
    let hash = scenario.hash.to_string();
    let ego = entry
        .recorded_ego(&scenario)
        .map_err(|e| problem(e.to_string()))?;
    let ego = ego.map(|ego| {
        let scene = Scene::new(scenario, ego);
        let window = |label| {
            let labelled = Labelled {
                scene: &scene,
                label,
                contact: None,
            };
            let window: Option<Window> = labelled.window(Lead::Paper, HISTORY);
            window.map(|w| (w.first(), w.last()))
        };
        let windows = [Label::Collision(None), Label::Safe].map(window);
        Driven {
            ego: scene.ego.to_string(),
            windows,
        }
    });
    Ok(Tied { hash, ego })
}

fn run_of(answer: &Recorded, tied: Option<&Tied>, root: &Path, now_ms: i64) -> Run {
    let said = answer.read();
    let techniques = answer.techniques.to_string();
    let ego = tied.and_then(|tied| tied.ego.as_ref());
    let window = match answer.task {
        Task::Safety => ego.and_then(|ego| ego.windows[usize::from(!answer.collision)]),
        _ => None,
    };
    let key = Key::digest(&json!({
        "recorded": answer.model,
        "scenario": answer.scenario,
        "collision": answer.collision,
        "task": answer.task.name(),
        "frame": answer.frame,
        "techniques": techniques,
        "answer": answer.text,
    }));
    let (verdict, how) = match said {
        Ok(read) => (Some(read.said), reading(&read.how)),
        Err(why) => (None, why.to_string()),
    };
    let verdict_json = verdict.as_ref().and_then(|v| serde_json::to_string(v).ok());
    let state = match answer.text.trim() {
        "" => RunState::Truncated,
        _ => RunState::Answered,
    };
    let file = answer.file.strip_prefix(root).unwrap_or(&answer.file);
    Run {
        id: RunId(0),
        created_ms: now_ms,
        updated_ms: now_ms,
        key: Some(key),
        origin: Origin::Recorded,
        source: Some(file.display().to_string()),
        question: NewRun {
            sample: 0,
            batch: None,
            scenario: answer.scenario.clone(),
            scenario_hash: tied.map(|tied| tied.hash.clone()),
            ego: ego.map_or_else(|| "recorded".into(), |found| found.ego.clone()),
            task: answer.task,
            frame: answer.frame.to_string(),
            techniques,
            window,
            model: answer.model.clone(),
            provider: "recorded".into(),
            dialect: None,
            endpoint: "recorded".into(),
            address: None,
            template: String::new(),
            template_version: None,
            template_hash: String::new(),
            messages: "[]".into(),
            parameters: "{}".into(),
            answer_schema: None,
        },
        answer: answer.text.clone(),
        reasoning: String::new(),
        ending: Ending {
            verdict,
            reading: Some(how),
            ..Ending::bare(state)
        },
        verdict_json,
        notes: String::new(),
        pinned: false,
        deleted_ms: None,
    }
}
