//! Recorded answers as runs for the store, matched to scenarios in the same folder.

use std::path::Path;

use rayon::prelude::*;
use serde_json::json;

use super::recorded::{Recorded, find};
use super::scenes::{claims, described, of_answers, subject};
use crate::evaluation::{Problem, reading};
use nearmiss_scene::scenario::Scene;
use nearmiss_store::{ClaimCounts, Ending, Key, NewRun, Origin, Run, RunId, RunState};

/// A scenario whose file was found.
struct Tied {
    hash: String,
    scene: Option<Scene>,
}

/// Every answer recorded below `root`, as a run that was read at `now_ms`, and everything there that is none.
///
/// An answer is tied to its scenario by the name, and by the hash of the file where that lies below the same folder.
/// Its window is the one that the paper's scripts describe; of tasks other than collision and safety it is not known.
#[must_use]
pub fn runs(root: &Path, now_ms: i64) -> (Vec<Run>, Vec<Problem>) {
    let (answers, mut problems) = find(root);
    let tied = of_answers(&answers, root, &mut problems, |_, opened| Tied {
        hash: opened.scenario.hash.to_string(),
        scene: opened.scene,
    });
    let run = |answer| {
        let tied = tied.get(&subject(answer));
        run_of(answer, tied, root, now_ms)
    };
    let runs = answers.par_iter().map(run).collect();
    (runs, problems)
}

fn run_of(answer: &Recorded, tied: Option<&Tied>, root: &Path, now_ms: i64) -> Run {
    let said = answer.read();
    let techniques = answer.techniques.to_string();
    let scene = tied.and_then(|tied| tied.scene.as_ref());
    let window = scene.and_then(|scene| described(scene, answer.task, answer.collision));
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
            ego: scene.map_or_else(|| "recorded".into(), |scene| scene.ego.to_string()),
            task: answer.task,
            frame: answer.frame.to_string(),
            techniques,
            window: window.map(|window| (window.first(), window.last())),
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
            images: Vec::new(),
        },
        answer: answer.text.clone(),
        reasoning: String::new(),
        ending: Ending {
            verdict,
            reading: Some(how),
            claims: scene.map_or_else(ClaimCounts::default, |scene| claims(answer, scene)),
            ..Ending::bare(state)
        },
        verdict_json,
        tool_rounds: None,
        most_usd: None,
        notes: String::new(),
        pinned: false,
        deleted_ms: None,
    }
}
