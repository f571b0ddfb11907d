//! Two versions of a prompt over many scenarios: which ones, the table, asking what is missing, side by side.

use std::sync::Arc;

use super::bench::Bench;
use super::editing::said;
use crate::message::runs::{Batch, ComparedVersions, VersionSide};
use crate::message::{BatchProgress, Effect, JobEvent, JobId, JobRequest, Msg, Update};
use crate::model::VersionKind;
use nearmiss_scene::verdict::{Task, Verdict};
use nearmiss_store::{AskedTemplate, RunId};
use nearmiss_study::evaluation::{AnswerStatus, Label, Scored};
use nearmiss_workflow::{ComparedAnswers, VersionChange, VersionComparison};

/// An answer of a number about a scenario, or none; of seven one is missing and one cannot be read.
pub fn scored(scenario: &str, task: Task, n: usize) -> Scored {
    let verdict = Verdict {
        task,
        dangerous: n.is_multiple_of(2),
        obstacles: Vec::new(),
        justification: scenario.into(),
        critical: None,
        probability: None,
        token_probability: None,
        unknown: Vec::new(),
    };
    let mut scored = Scored::built_in(scenario, "lab/small", None, verdict);
    scored.consumed.input_tokens = Some(1_234_567);
    scored.consumed.output_tokens = Some(n as u64);
    scored.consumed.cost_usd = Some(0.01);
    scored.run = Some(RunId(1 + n as i64));
    match n % 7 {
        5 => {
            scored.run = None;
            scored.consumed = nearmiss_store::Consumed::default();
            scored.status = AnswerStatus::Unasked(scenario.into());
        }
        6 => scored.status = AnswerStatus::Unparsed(scenario.into()),
        _ => {}
    }
    scored
}

/// What could be found of two versions; `name` stands for every scenario that has none.
pub fn found(sides: &[VersionSide; 2], name: Option<&str>, n: usize) -> Box<ComparedVersions> {
    let batch = &sides[0].batch;
    let rows = batch.entries.iter().enumerate().map(|(at, entry)| {
        let truth = [Label::Safe, Label::Collision(None)][at / 2 % 2];
        let one = |number| Scored {
            truth: Some(truth),
            ..scored(name.unwrap_or(&entry.name), batch.task, number)
        };
        ComparedAnswers {
            entry: entry.clone(),
            answers: [one(at + n), one(4 * at + n + 1)],
        }
    });
    let comparison = VersionComparison {
        truth: name
            .unwrap_or("exact geometry of the whole recordings")
            .into(),
        rows: rows.collect(),
        unlabelled: n % 3,
        ..VersionComparison::default()
    };
    let asked = AskedTemplate {
        template: name.unwrap_or("collision-ego.md").into(),
        hash: "0123456789".into(),
        answers: 3,
    };
    Box::new(ComparedVersions {
        comparison,
        asked: vec![asked],
    })
}

/// The last lookup.
fn looked(bench: &Bench) -> (JobId, Arc<[VersionSide; 2]>) {
    let found = bench.effects.iter().rev().find_map(|effect| match effect {
        Effect::Start(id, JobRequest::Versions(sides)) => Some((*id, sides.clone())),
        _ => None,
    });
    found.expect("versions are looked up")
}

/// The last batch that was estimated.
fn proposed(bench: &Bench) -> (JobId, Arc<Batch>) {
    let found = bench.effects.iter().rev().find_map(|effect| match effect {
        Effect::Start(id, JobRequest::Estimate(batch)) => Some((*id, batch.clone())),
        _ => None,
    });
    found.expect("a batch is estimated")
}

/// A draft beside the shipped template, with what is stored of both.
fn compared() -> Bench {
    compared_with(0)
}

/// The same, with so many scenarios in locked test splits.
fn compared_with(locked: usize) -> Bench {
    let mut bench = Bench::bundled();
    bench.model.model = "lab/small".into();
    bench.press("e ctrl-g 1 0 enter");
    bench.type_text("Mind the gap. ");
    bench.press("alt-c");
    let (id, sides) = looked(&bench);
    let mut found = found(&sides, None, 0);
    found.comparison.locked = locked;
    let found = Update::Ended(Ok(found));
    bench.send(Msg::Job(id, JobEvent::Versions(found)));
    bench
}

#[test]
fn the_draft_stands_beside_the_version_it_replaces() {
    let bench = compared();
    let (_, sides) = looked(&bench);
    assert!(sides[0].batch.draft.is_none(), "the shipped one is in use");
    let (file, text) = sides[1].batch.draft.clone().unwrap();
    assert_eq!(file, "collision-ego.md");
    assert!(text.contains("Mind the gap. "));
    assert_eq!(sides[0].batch.entries.len(), bench.model.list.rows.len());
    insta::assert_snapshot!("versions_at_80_by_24", bench.frame(80, 24));
    assert!(!bench.frame(80, 24).contains("locked"));
    let frame = bench.frame(200, 60);
    for words in ["▲ better", "▼ worse", "= same", "compared", "tokens · $"] {
        assert!(frame.contains(words), "{words}\n{frame}");
    }
}

#[test]
fn scenarios_of_a_locked_test_split_are_counted() {
    let bench = compared_with(2);
    let frame = bench.frame(80, 24);
    assert!(frame.contains("· 2 in locked test splits"), "{frame}");
}

#[test]
fn any_two_versions_can_be_chosen_also_those_that_only_the_store_knows() {
    let mut bench = compared();
    bench.press("a");
    let frame = bench.frame(120, 40);
    for words in [
        "draft@",
        "shipped",
        "collision-ego@012345",
        "3 stored answers",
    ] {
        assert!(frame.contains(words), "{words}\n{frame}");
    }
    bench.press("shift-g enter");
    let (_, sides) = looked(&bench);
    assert_eq!(sides[0].hash.as_deref(), Some("0123456789"));
    let now = bench.model.versions.sides.clone().unwrap();
    assert_eq!(now[0].kind, VersionKind::Stored(3));
    assert_eq!(now[1].kind, VersionKind::Draft);
    assert!(
        bench.model.versions.found.is_none(),
        "of the versions before"
    );
    bench.press("s");
    let swapped = bench.model.versions.sides.clone().unwrap();
    assert_eq!(swapped, [now[1].clone(), now[0].clone()]);
}

#[test]
fn what_is_missing_is_asked_after_its_cost_was_shown_one_version_after_the_other() {
    let mut bench = compared();
    let rows = bench.model.versions.answers().to_vec();
    let missing = [0, 1].map(|side| rows.iter().filter(|row| row.is_missing(side)).count());
    assert!(missing[0] > 0 && missing[1] > 0, "{missing:?}");
    bench.press("r");
    let asked = |bench: &Bench| {
        let starts = bench.effects.iter();
        let batches = starts.filter(|e| matches!(e, Effect::Start(_, JobRequest::Batch(_))));
        batches.count()
    };
    let accept = |bench: &mut Bench| {
        let (id, batch) = proposed(bench);
        let mut counts = crate::message::runs::Counts {
            looked: batch.entries.len(),
            ..Default::default()
        };
        counts.estimate.requests = batch.entries.len() as u64;
        let counted = JobEvent::Estimate(Update::Ended(Ok(counts)));
        bench.send(Msg::Job(id, counted));
        bench.press("enter");
        id
    };
    assert_eq!(proposed(&bench).1.entries.len(), missing[0]);
    assert_eq!(asked(&bench), 0, "nothing is sent before a yes");
    let first = accept(&mut bench);
    assert_eq!(asked(&bench), 1);
    let (second, batch) = proposed(&bench);
    assert_eq!(
        (batch.entries.len(), batch.draft.is_some()),
        (missing[1], true)
    );
    bench.press("esc");
    assert_eq!(asked(&bench), 1, "the second version was declined");
    let named = JobEvent::Batch(Update::Progress(BatchProgress::Named("7".into(), 1)));
    bench.send(Msg::Job(first, named));
    assert!(bench.frame(120, 40).contains("asking 0/1"));
    let (before, _) = looked(&bench);
    bench.send(Msg::Job(first, JobEvent::Batch(Update::Ended(Ok(())))));
    assert_ne!(looked(&bench).0, before, "the answers are looked up again");
    assert_ne!(first, second);
}

#[test]
fn enter_reads_both_answers_and_n_finds_what_changed() {
    let mut bench = compared();
    bench.press("n");
    let at = bench.model.versions.selected;
    let row = bench.model.versions.answers()[at].clone();
    bench.press("enter");
    let pair = bench.effects.iter().rev().find_map(|effect| match effect {
        Effect::Start(_, JobRequest::Pair(runs)) => Some(*runs),
        _ => None,
    });
    let runs = row.answers.each_ref().map(|one| one.run.unwrap());
    assert_eq!(pair, Some(runs));
    let rows = bench.model.versions.answers();
    bench.model.versions.selected = rows.iter().position(|row| row.is_missing(0)).unwrap();
    bench.press("enter");
    assert!(said(&bench).contains("an answer is missing"));
    let found = bench.model.versions.found.as_mut().unwrap();
    found
        .rows
        .retain(|row| row.change() == VersionChange::Missing);
    bench.model.versions.selected = 0;
    bench.press("n");
    assert!(said(&bench).contains("nothing is compared yet: r asks"));
}

#[test]
fn what_cannot_be_compared_says_why() {
    let mut bench = Bench::bundled();
    bench.perform("compare-versions");
    assert!(said(&bench).contains("the built-in judge reads no prompt"));
    bench.model.model = "lab/small".into();
    bench.press("e ctrl-g 1 0 enter");
    bench.type_text("{{ oops ");
    bench.press("alt-c");
    assert!(said(&bench).contains("requests disabled until fixed"));
    bench.press("alt-z alt-z alt-z esc");
    bench.perform("compare-versions");
    let (id, sides) = looked(&bench);
    let mut nothing = found(&sides, None, 0);
    nothing.asked.clear();
    bench.send(Msg::Job(id, JobEvent::Versions(Update::Ended(Ok(nothing)))));
    assert!(bench.frame(120, 40).contains("one version only"));
}
