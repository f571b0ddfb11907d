//! Claims in the answers that the paper's authors recorded: how many are found, and how many hold.
//!
//! The answers are not part of this repository, see `tests/recorded.rs`; without them the test says so and ends.
//! `NEARMISS_CLAIMS=N` prints every Nth claim with the words around it, to be read by hand.
#![allow(clippy::unwrap_used, clippy::expect_used)]

use crate::support;

mod labelled;

use std::collections::BTreeMap;
use std::path::Path;

use nearmiss::evaluation::claims::{ClaimBasis, Judgement, Subject, TimeOrigin, checked};
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
    for run in &runs {
        let hash = run.question.scenario_hash.clone().unwrap_or_default();
        let Some(scene) = scenes.get(&(run.question.scenario.clone(), hash)) else {
            continue;
        };
        if !Task::VERDICTS.contains(&run.question.task) {
            continue;
        }
        answers += 1;
        let subject = Subject::new(scene, TimeOrigin::from_messages(&run.question.messages), run.question.window);
        let all = checked(&run.answer, &subject);
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
    assert!(answers > 1000, "{answers}");
    assert!(number > 1000, "{number}");
}
