//! The answers that the paper's authors recorded: found, read, and counted as a tolerant reader counts them.
//!
//! They are not part of this repository. The folder that holds `data/from-words-to-collisions` is `../shared`,
//! or what `NEARMISS_SHARED` names; without it these tests say so and end.
#![allow(clippy::unwrap_used, clippy::expect_used)]

use crate::support;

use std::collections::BTreeMap;
use std::path::Path;

use nearmiss::evaluation::{Label, Labels, annotations};
use nearmiss::paper::{Recorded, find};
use nearmiss::verdict::{ParseQuality, ParsedAnswer, Task};
use serde::Deserialize;

use support::recorded::folder;

/// Counts of one cell: a half of the data, a task, a way of asking, a model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
struct Cell {
    answers: i64,
    parsed: i64,
    flagged: i64,
    named: i64,
}

/// The name of a cell in the expected counts.
fn cell(recorded: &Recorded) -> String {
    let folders: Vec<_> = recorded.file.iter().rev().skip(2).take(3).collect();
    let part = |place: usize| folders[place].to_str().unwrap();
    let half = if recorded.collision {
        "collision"
    } else {
        "normal"
    };
    format!("{half} {} {} {}", part(2), part(1), part(0))
}

/// Answers to the two tasks of the paper, about scenarios whose truth is known.
fn answers(root: &Path) -> (Vec<Recorded>, Labels) {
    let (mut found, problems) = find(root);
    for problem in &problems {
        println!("{problem}");
    }
    let (labels, problems) = annotations(root);
    assert_eq!(problems, vec![]);
    found.retain(|r| Task::VERDICTS.contains(&r.task) && labels.get(&r.scenario).is_some());
    (found, labels)
}

#[test]
fn the_counts_are_those_expected() {
    let Some(root) = folder() else { return };
    let expected = std::fs::read_to_string(root.join("EXPECTED_recorded.json")).unwrap();
    let expected: BTreeMap<String, Cell> = serde_json::from_str(&expected).unwrap();
    let (answers, labels) = answers(&root);
    let mut cells: BTreeMap<String, Cell> = BTreeMap::new();
    let mut strict = 0;
    for recorded in &answers {
        let cell = cells.entry(cell(recorded)).or_default();
        cell.answers += 1;
        match recorded.read() {
            Err(why) => println!("{}: {why}", recorded.file.display()),
            Ok(reading) => {
                strict += i32::from(reading.how == ParseQuality::Strict);
                let verdict = reading.said.verdict().expect("a verdict");
                cell.parsed += 1;
                cell.flagged += i64::from(verdict.dangerous);
                if let Some(Label::Collision(Some(who))) = labels.get(&recorded.scenario) {
                    cell.named += i64::from(verdict.danger().contains(&who));
                }
            }
        }
    }
    let parsed: i64 = cells.values().map(|c| c.parsed).sum();
    println!(
        "{} answers, {parsed} with a verdict, {strict} strictly as asked",
        answers.len()
    );
    let mut differences = 0;
    for (name, wanted) in &expected {
        let found = cells.remove(name).unwrap_or_default();
        if found != *wanted {
            differences += 1;
            println!("{name}: {found:?}, expected {wanted:?}");
        }
        let near = |a: i64, b: i64| (a - b).abs() <= 1;
        assert_eq!(found.answers, wanted.answers, "{name}");
        assert!(
            near(found.parsed, wanted.parsed),
            "{name}: {found:?}, expected {wanted:?}"
        );
        assert!(
            near(found.flagged, wanted.flagged),
            "{name}: {found:?}, expected {wanted:?}"
        );
        assert!(
            near(found.named, wanted.named),
            "{name}: {found:?}, expected {wanted:?}"
        );
    }
    println!("{differences} of {} cells differ", expected.len());
    assert!(cells.is_empty(), "cells that were not expected: {cells:?}");
    assert!(parsed as f64 >= 0.995 * answers.len() as f64);
}

#[test]
fn choices_of_attackers_are_read_too() {
    let Some(root) = folder() else { return };
    let (found, _) = find(&root);
    let mut chosen = 0;
    let mut all = 0;
    for recorded in found.iter().filter(|r| r.task == Task::Attacker) {
        all += 1;
        match recorded.read() {
            Ok(reading) => {
                let ParsedAnswer::Attacker(choice) = reading.said else {
                    panic!("another task")
                };
                chosen += i32::from(choice.attacker.is_some());
            }
            Err(why) => panic!("{}: {why}", recorded.file.display()),
        }
    }
    println!("{all} answers, {chosen} of them with an attacker");
    assert!(all > 0 && chosen > 0);
}
