//! Recorded answers as runs for the store, matched to scenarios in the same folder.

use std::path::Path;

use serde_json::json;

use super::recorded::{Recorded, find};
use super::scenes::{Opened, of_answers, safety_window, subject};
use crate::evaluation::{Problem, reading};
use crate::store::{Ending, Key, NewRun, Origin, Run, RunId, RunState};
use crate::verdict::Task;

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
    let tied = of_answers(&answers, root, &mut problems, |_, opened| Tied::of(&opened));
    let run = |answer| {
        let tied = tied.get(&subject(answer));
        run_of(answer, tied, root, now_ms)
    };
    let runs = answers.iter().map(run).collect();
    (runs, problems)
}

impl Tied {
    fn of(opened: &Opened) -> Self {
        let driven = |scene| {
            let window = |collision| safety_window(scene, collision).map(|w| (w.first(), w.last()));
            Driven {
                ego: scene.ego.to_string(),
                windows: [true, false].map(window),
            }
        };
        Self {
            hash: opened.scenario.hash.to_string(),
            ego: opened.scene.as_ref().map(driven),
        }
    }
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
