//! Tests of declared comparisons, and of intervals over scenarios.

use super::*;

#[test]
fn declared_comparisons_are_families_of_their_own() {
    let ways = [
        way(Task::Safety, "base", "lab/x"),
        way(Task::Safety, "cp", "lab/x"),
        way(Task::Safety, "cp", "lab/y"),
        way(Task::Safety, "base", "lab/z"),
    ];
    let scored: Vec<Scored> = ways.iter().flat_map(answers).collect();
    let found = |baseline: Option<&str>, primary: Option<(&str, &str)>| {
        let comparison = Comparison {
            baseline: baseline.map(String::from),
            primary: primary.map(|(a, b)| (a.into(), b.into())),
            ..Comparison::default()
        };
        assert!(
            comparison
                .unknown(&ways.iter().collect::<Vec<_>>())
                .is_empty()
        );
        let pairs = Report::compared(&scored, &comparison).pairs;
        let short = |way: &PromptConfig| format!("{} {}", way.model, way.techniques.unwrap());
        pairs
            .iter()
            .map(|p| {
                format!(
                    "{}: {} / {}, {}",
                    p.family.name(),
                    short(&p.first),
                    short(&p.second),
                    p.differs
                )
            })
            .collect::<Vec<_>>()
    };
    assert_eq!(found(None, None).len(), 3);
    // Others stand first, the baseline second.
    let with_x = [
        "baseline: lab/z base / lab/x base, model",
        "baseline: lab/y cp / lab/x cp, model",
    ];
    assert_eq!(found(Some("lab/x"), None), with_x);
    let declared = found(Some("lab/x"), Some(("lab/x", "lab/y")));
    assert_eq!(
        declared,
        ["declared: lab/x cp / lab/y cp, model", with_x[0]]
    );
    // Whole ways may differ in several things.
    let several = found(None, Some(("ego · cp · lab/y", "ego · base · lab/x")));
    assert_eq!(several[0], "declared: lab/y cp / lab/x base, several");
    assert_eq!(several.len(), 4);
    let typo = Comparison {
        baseline: Some("lab/w".into()),
        ..Comparison::default()
    };
    assert_eq!(typo.unknown(&[&ways[0]]), ["lab/w"]);
}

#[test]
fn samples_of_a_scenario_are_no_further_scenarios() {
    let way = way(Task::Collision, "cp", "lab/x");
    let scored = |samples: u32| -> Vec<Scored> {
        let of = |n: u32, sample: u32| {
            let truth = Some(if n.is_multiple_of(2) {
                Label::Collision(None)
            } else {
                Label::Safe
            });
            let mut one = one(
                &format!("s{n}"),
                &way,
                truth,
                says(n.is_multiple_of(2) != n.is_multiple_of(5), &[]),
            );
            one.sample = sample;
            one
        };
        (0..40)
            .flat_map(|n| {
                (0..samples)
                    .map(move |sample| of(n, sample))
                    .collect::<Vec<_>>()
            })
            .collect()
    };
    let cell = |samples| {
        Report::from_scored(&scored(samples))
            .whole()
            .next()
            .unwrap()
            .clone()
    };
    let (two, four) = (cell(2), cell(4));
    assert_eq!((two.scenarios, two.n, four.n), (40, 80, 160));
    assert_eq!(two.intervals, four.intervals);
    assert_eq!(two.samples.all_right.share, Some(0.8));
    assert_eq!(
        (four.samples.all_right.k, four.samples.all_right.share),
        (4, Some(0.8))
    );
    // With one answer each it is Wilson's: 32 of 40, statsmodels 0.15.
    let accuracy = cell(1).intervals.accuracy.unwrap();
    assert!(
        (accuracy.low - 0.652_427).abs() < 1e-5 && (accuracy.high - 0.895_000).abs() < 1e-5,
        "{accuracy:?}"
    );
}
