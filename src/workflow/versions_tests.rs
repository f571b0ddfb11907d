//! Tests of what changed between two versions, on invented answers.
#![allow(clippy::unwrap_used)]

use super::*;
use nearmiss_scene::verdict::{ObstacleRisk, Task, Verdict};

fn said(task: Task, truth: Label, dangerous: bool, named: i64) -> Scored {
    let verdict = Verdict {
        task,
        dangerous,
        obstacles: vec![ObstacleRisk {
            id: named,
            risk_score: 0,
            reason: String::new(),
            written_score: None,
        }],
        justification: String::new(),
        critical: None,
        probability: None,
        token_probability: None,
        unknown: Vec::new(),
    };
    let mut scored = Scored::built_in("a", "lab/small", Some(truth), verdict);
    scored.run = Some(RunId(1));
    scored.consumed.input_tokens = Some(100);
    scored.consumed.output_tokens = Some(20);
    scored.consumed.cost_usd = Some(0.5);
    scored
}

fn row(a: Scored, b: Scored) -> ComparedAnswers {
    ComparedAnswers {
        entry: Entry::of_argument(Path::new("a.xml")),
        answers: [a, b],
    }
}

#[test]
fn a_change_is_held_against_the_truth() {
    use VersionChange::{Better, Missing, Other, Same, Worse};
    let truth = Label::Collision(Some(7));
    let yes = |named| said(Task::Safety, truth, true, named);
    let no = || said(Task::Safety, truth, false, 7);
    let mut unread = no();
    unread.status = AnswerStatus::Unparsed("no JSON".into());
    let mut missing = no();
    missing.status = AnswerStatus::Unasked("not yet".into());
    missing.run = None;
    for (a, b, change) in [
        (no(), yes(7), Better),
        (yes(7), no(), Worse),
        (yes(7), yes(7), Same),
        (no(), no(), Same),
        // Yes and no are held against the truth, whichever obstacle is named.
        (yes(7), yes(8), Same),
        (no(), yes(8), Better),
        (unread.clone(), yes(7), Better),
        (unread.clone(), no(), Other),
        (yes(7), missing.clone(), Missing),
    ] {
        assert_eq!(row(a.clone(), b.clone()).change(), change, "{a:?} {b:?}");
    }
    assert!(row(yes(7), missing).is_missing(1));
}

#[test]
fn totals_count_changes_and_costs_and_test_only_enough_pairs() {
    let one = |n: usize, dangerous| {
        let mut one = said(Task::Collision, Label::Collision(None), dangerous, 1);
        one.scenario = format!("S-{n}");
        one
    };
    let mut comparison = VersionComparison::default();
    for n in 0..9 {
        comparison.rows.push(row(one(n, n > 6), one(n, true)));
    }
    let totals = comparison.totals();
    assert_eq!((totals.pairs, totals.changed), (9, 7));
    assert_eq!((totals.better, totals.worse), (7, 0));
    assert_eq!(totals.test, None, "nine scenarios are too few");
    assert_eq!((totals.sides[0].right, totals.sides[1].right), (2, 9));
    assert_eq!((totals.sides[0].tokens, totals.sides[1].usd), (1080, 4.5));
    // Another answer about a scenario is no further scenario.
    comparison.rows.push(row(one(8, true), one(8, true)));
    assert_eq!(comparison.totals().test, None);
    comparison.rows.push(row(one(9, true), one(9, true)));
    let test = comparison.totals().test.unwrap();
    // 2 · ½⁷, as McNemar's exact test of one answer a scenario.
    assert!((test.p - 0.015_625).abs() < 1e-12, "{test:?}");
    assert!((test.difference - 0.7).abs() < 1e-12, "{test:?}");
}

#[test]
fn answers_of_locked_test_splits_are_left_out_and_counted() {
    let truth = Label::Collision(Some(7));
    let numbered = |run| {
        let mut one = said(Task::Safety, truth, true, 7);
        one.run = run;
        one
    };
    let of = |a: Option<i64>, b: Option<i64>| row(numbered(a.map(RunId)), numbered(b.map(RunId)));
    let rows = vec![
        of(Some(1), Some(2)),
        of(Some(3), Some(4)),
        of(Some(5), Some(3)),
        of(None, None),
    ];
    let mut comparison = VersionComparison::default();
    comparison.set_rows(rows, |run| run == RunId(3));
    assert_eq!(comparison.locked, 2);
    let shown: Vec<_> = comparison
        .rows
        .iter()
        .map(|row| row.answers[0].run)
        .collect();
    assert_eq!(shown, [Some(RunId(1)), None]);
    assert_eq!(comparison.totals().pairs, 1);
}
