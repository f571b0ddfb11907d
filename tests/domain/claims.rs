//! Claims in the answers that the paper's authors recorded: how many are found, and how many hold.
//!
//! The answers are not part of this repository, see `tests/recorded.rs`; without them the test says so and ends.
//! `NEARMISS_CLAIMS=N` prints every Nth claim with the words around it, to be read by hand.
#![allow(clippy::unwrap_used, clippy::expect_used)]

use crate::support;

mod labelled;

use std::collections::BTreeMap;
use std::path::Path;

use nearmiss::evaluation::claims::{
    CheckedClaim, CheckedSentence, ClaimBasis, Judgement, Subject, TimeOrigin, sentences,
    truth_table,
};
use nearmiss::formats::find;
use nearmiss::paper;
use nearmiss::scenario::Scene;
use nearmiss::verdict::Task;

use support::recorded::folder;

/// Every scene below the folder, by name and half of the data.
fn scenes(root: &Path) -> BTreeMap<(String, String), Scene> {
    let found = find(&[root.to_path_buf()]).unwrap();
    let scene = |entry: &nearmiss::formats::Entry| {
        let scenario = entry.read().ok()?;
        let ego = entry.recorded_ego(&scenario).ok()??;
        let hash = scenario.hash.to_string();
        Some(((entry.name.clone(), hash), Scene::new(scenario, ego)))
    };
    found.entries.iter().filter_map(scene).collect()
}

#[derive(Debug, Default)]
struct Counts {
    right: usize,
    wrong: usize,
    unknown: usize,
    paper: usize,
    centres: usize,
}

#[test]
fn claims_in_recorded_answers_are_found_and_mostly_hold() {
    let Some(root) = folder() else { return };
    let scenes = scenes(&root);
    let (runs, _) = paper::runs(&root, 0);
    let every: Option<usize> = std::env::var("NEARMISS_CLAIMS")
        .ok()
        .and_then(|n| n.parse().ok());
    let (mut answers, mut with, mut number) = (0, 0, 0);
    let mut cells: BTreeMap<String, Counts> = BTreeMap::new();
    let mut told: Vec<(String, String, Vec<CheckedSentence>)> = Vec::new();
    for run in &runs {
        let hash = run.question.scenario_hash.clone().unwrap_or_default();
        let Some(scene) = scenes.get(&(run.question.scenario.clone(), hash)) else {
            continue;
        };
        if !Task::VERDICTS.contains(&run.question.task) {
            continue;
        }
        answers += 1;
        let subject = Subject::new(
            scene,
            TimeOrigin::from_messages(&run.question.messages),
            run.question.window,
        );
        let found = sentences(&run.answer, &subject);
        let all: Vec<CheckedClaim> = found.iter().flat_map(|one| one.claims.clone()).collect();
        // ".../cart_icl/openai/analysis/...": the way of describing and of prompting, and the model.
        let source = run.source.as_deref().unwrap_or_default();
        let parts: Vec<&str> = source.rsplit('/').collect();
        if let [_, _, model, method, ..] = parts.as_slice() {
            let (frame, prompt) = method.split_once('_').unwrap_or((method, ""));
            for name in [
                model.to_string(),
                format!("{model} {frame}"),
                format!("{model} {frame} {prompt}"),
            ] {
                told.push((name, run.question.scenario.clone(), found.clone()));
            }
        }
        with += usize::from(!all.is_empty());
        for found in &all {
            let cell = format!("{:9} {}", run.question.frame, found.claim.quantity.name());
            let counts = cells.entry(cell).or_default();
            match found.judgement {
                Judgement::Right => counts.right += 1,
                Judgement::Wrong => counts.wrong += 1,
                Judgement::Unknown(_) => counts.unknown += 1,
            }
            counts.paper += usize::from(found.basis == ClaimBasis::Paper);
            counts.centres += usize::from(found.basis == ClaimBasis::Centres);
            number += 1;
            if every.is_some_and(|n| number % n == 0) {
                let span = found.claim.span.clone();
                let from = run.answer[..span.start]
                    .char_indices()
                    .rev()
                    .nth(400)
                    .map_or(0, |(i, _)| i);
                let to = run.answer[span.end..]
                    .char_indices()
                    .nth(80)
                    .map_or(run.answer.len(), |(i, _)| span.end + i);
                println!(
                    "#{number} {} {}\n   …{}⟦{}⟧{}…\n   {:?} {}",
                    run.source.as_deref().unwrap_or("?"),
                    run.question.window.map_or("?".into(), |w| format!("{w:?}")),
                    run.answer[from..span.start].replace('\n', "⏎"),
                    &run.answer[span.clone()],
                    run.answer[span.end..to].replace('\n', "⏎"),
                    found.judgement,
                    found.line(),
                );
            }
        }
    }
    println!("{answers} answers, {with} with claims, {number} claims");
    let mut sum = Counts::default();
    for (cell, c) in &cells {
        println!(
            "{cell:42} right {:5} (paper {:4}, centres {:4}) wrong {:5} unknown {:5}",
            c.right, c.paper, c.centres, c.wrong, c.unknown
        );
        sum.right += c.right;
        sum.wrong += c.wrong;
        sum.unknown += c.unknown;
    }
    println!("{sum:?}");
    let texts = { told.iter() }
        .map(|(name, scenario, found)| (name.as_str(), scenario.as_str(), found.as_slice()));
    let rows = truth_table(texts);
    for row in rows
        .iter()
        .filter(|row| row.kind.starts_with("all") || !row.model.contains(' '))
    {
        let interval = row
            .interval
            .map_or(String::new(), |i| format!("[{:.3}, {:.3}]", i.low, i.high));
        let share = format!("{:.3} {interval}", row.share.unwrap_or(f64::NAN));
        println!(
            "{:20} {:32} right {:6} wrong {:6} open {:6}  {share}",
            row.model, row.kind, row.right, row.wrong, row.open
        );
    }
    let mut models: BTreeMap<&str, Vec<&[CheckedSentence]>> = BTreeMap::new();
    for (name, _, found) in &told {
        models.entry(name).or_default().push(found);
    }
    for (name, all) in &models {
        let all: Vec<CheckedSentence> = all.iter().flat_map(|one| one.iter().cloned()).collect();
        let [right, wrong, open, unheard] = CheckedSentence::counts(&all);
        let against = all.iter().filter(|one| !one.contradicts.is_empty()).count();
        println!(
            "{name:20} {} answers: sentences right {right} wrong {wrong} open {open} not understood {unheard}, {against} \
             contradict another one",
            models[name].len()
        );
    }
    assert!(answers > 1000, "{answers}");
    assert!(number > 1000, "{number}");
}
