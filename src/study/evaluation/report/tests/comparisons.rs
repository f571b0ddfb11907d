//! Tests of declared comparisons and intervals, and of comparisons on simulated batches: false alarms and power.

use super::*;

#[test]
fn declared_comparisons_are_families_of_their_own() {
    let configurations = [
        configuration(Task::Safety, "base", "lab/x"),
        configuration(Task::Safety, "cp", "lab/x"),
        configuration(Task::Safety, "cp", "lab/y"),
        configuration(Task::Safety, "base", "lab/z"),
    ];
    let scored: Vec<Scored> = configurations.iter().flat_map(answers).collect();
    let found = |baseline: Option<&str>, primary: Option<(&str, &str)>| {
        let comparison = Comparison {
            baseline: baseline.map(String::from),
            primary: primary.map(|(a, b)| (a.into(), b.into())),
        };
        assert!(
            comparison
                .unknown(&configurations.iter().collect::<Vec<_>>())
                .is_empty()
        );
        let pairs = Report::compared(&scored, &comparison).pairs;
        let short = |configuration: &PromptConfig| {
            format!(
                "{} {}",
                configuration.model,
                configuration.techniques.unwrap()
            )
        };
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
    assert_eq!(typo.unknown(&[&configurations[0]]), ["lab/w"]);
}

#[test]
fn samples_of_a_scenario_are_no_further_scenarios() {
    let configuration = configuration(Task::Collision, "cp", "lab/x");
    let scored = |samples: u32| -> Vec<Scored> {
        let of = |n: u32, sample: u32| {
            let truth = Some(if n.is_multiple_of(2) {
                Label::Collision(None)
            } else {
                Label::Safe
            });
            let mut one = one(
                &format!("s{n}"),
                &configuration,
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
            .full_cells()
            .next()
            .unwrap()
            .clone()
    };
    let (two, four) = (cell(2), cell(4));
    assert_eq!((two.scenarios, two.n, four.n), (40, 80, 160));
    let intervals = |cell: &Cell| {
        [
            cell.right_of_all_ci,
            cell.precision_ci,
            cell.recall_ci,
            cell.specificity_ci,
            cell.accuracy_ci,
            cell.f1_ci,
        ]
    };
    assert_eq!(intervals(&two), intervals(&four));
    assert_eq!(two.samples.all_right, Some(0.8));
    assert_eq!(
        (four.samples.all_right_k, four.samples.all_right),
        (4, Some(0.8))
    );
    // With one answer each it is Wilson's: 32 of 40, statsmodels 0.15.
    let accuracy = cell(1).accuracy_ci.unwrap();
    assert!(
        (accuracy.low - 0.652_427).abs() < 1e-5 && (accuracy.high - 0.895_000).abs() < 1e-5,
        "{accuracy:?}"
    );
}

/// Three scenarios of each of twelve maps: by map fewer units, with wider intervals and the same figures.
#[test]
fn a_map_is_one_unit_where_it_is_asked_for() {
    let configurations = [
        configuration(Task::Safety, "base", "lab/x"),
        configuration(Task::Safety, "base", "lab/y"),
    ];
    let report = |cluster: Cluster| {
        let scored = configurations
            .iter()
            .enumerate()
            .flat_map(|(model, configuration)| {
                (0..36_u32).map(move |n| {
                    let (map, truth) = (n / 3, n.is_multiple_of(2));
                    // A map that is wrong is wrong in all its scenarios.
                    let is_right = !map.is_multiple_of(4 - model as u32);
                    let label = if truth {
                        Label::Collision(None)
                    } else {
                        Label::Safe
                    };
                    let name = format!("DEU_Map{map}-1_{}_T-1", n + 1);
                    let mut one = one(
                        &name,
                        configuration,
                        Some(label),
                        says(truth == is_right, &[]),
                    );
                    one.cluster = cluster;
                    one
                })
            });
        Report::from_scored(&scored.collect::<Vec<_>>())
    };
    let (by_scenario, by_map) = (report(Cluster::Scenario), report(Cluster::Map));
    let width = |report: &Report| {
        let interval = report.full_cells().next().unwrap().right_of_all_ci.unwrap();
        interval.high - interval.low
    };
    assert!(width(&by_map) > 1.4 * width(&by_scenario));
    let right = |report: &Report| report.full_cells().next().unwrap().right_of_all;
    assert_eq!(right(&by_map), right(&by_scenario));
    let (by_scenario, by_map) = (&by_scenario.pairs[0], &by_map.pairs[0]);
    assert_eq!((by_scenario.n, by_map.n), (36, 12));
    assert!((by_scenario.test.difference - by_map.test.difference).abs() < 1e-12);
    assert!(by_map.test.p > by_scenario.test.p);
    assert!(by_map.test.detectable > by_scenario.test.detectable);
    let text = report(Cluster::Map).document("a report").markdown();
    assert!(text.contains("with the map as the unit"), "{text}");
    assert!(text.contains("Comparisons on the same maps"), "{text}");
    // What was not asked of both is left out by scenario, within the map.
    let few: Vec<Scored> = {
        let one = |model: usize, n: u32, is_right: bool| {
            let name = format!("DEU_Map1-1_{n}_T-1");
            let said = says(is_right, &[]);
            let mut one = one(
                &name,
                &configurations[model],
                Some(Label::Collision(None)),
                said,
            );
            one.cluster = Cluster::Map;
            one
        };
        vec![one(0, 1, true), one(0, 2, false), one(1, 1, true)]
    };
    let pair = &Report::from_scored(&few).pairs[0];
    assert_eq!((pair.n, pair.left_out, pair.test.difference), (1, 0, 0.0));
}

/// Scenarios of a simulated batch, half of them collisions, and samples of each question.
const SCENARIOS: usize = 42;
const SAMPLES: u32 = 2;

/// How often each model is wrong, by scenario.
type Noise = fn(usize) -> f64;

/// The answers of two models to the same questions; every answer is wrong by chance, whatever the other ones are.
fn batch(random: &mut fastrand::Rng, noise: [Noise; 2]) -> Vec<Scored> {
    let mut scored = Vec::new();
    for (model, noise) in ["lab/a", "lab/b"].into_iter().zip(noise) {
        let configuration = configuration(Task::Safety, "cp", model);
        for n in 0..SCENARIOS {
            let collides = n.is_multiple_of(2);
            let truth = if collides {
                Label::Collision(Some(7))
            } else {
                Label::Safe
            };
            for sample in 0..SAMPLES {
                let wrong = random.f64() < noise(n);
                let mut one = one(
                    &format!("s{n}"),
                    &configuration,
                    Some(truth),
                    says(collides != wrong, &[]),
                );
                one.sample = sample;
                scored.push(one);
            }
        }
    }
    scored
}

/// The share of batches whose declared comparison is significant at 5 %.
fn significant(seed: u64, noise: [Noise; 2]) -> (f64, f64) {
    let asked = std::env::var("NEARMISS_SIMULATED_BATCHES");
    let batches: u32 = asked.ok().and_then(|n| n.parse().ok()).unwrap_or(200);
    let mut random = fastrand::Rng::with_seed(seed);
    let declared = Comparison {
        primary: Some(("lab/a".into(), "lab/b".into())),
        ..Comparison::default()
    };
    let found = (0..batches).filter(|_| {
        let report = Report::compared(&batch(&mut random, noise), &declared);
        let [pair] = &report.pairs[..] else {
            panic!("{:?}", report.pairs)
        };
        assert_eq!((pair.family, pair.n), (Family::Declared, 42));
        pair.corrected < 0.05
    });
    let share = found.count() as f64 / f64::from(batches);
    println!("{share:.3} of {batches} batches");
    (share, f64::from(batches))
}

#[test]
fn equal_models_seldom_differ() {
    let same: [(u64, Noise); 2] = [
        (2, |_| 0.30),
        // Some scenarios are hard for both: answers about one are alike.
        (3, |n| if n.is_multiple_of(3) { 0.75 } else { 0.05 }),
    ];
    for (seed, noise) in same {
        let (share, batches) = significant(seed, [noise; 2]);
        // Two standard errors of 5 %.
        let most = 0.05 + 2.0 * (0.05 * 0.95 / batches).sqrt();
        assert!(share <= most, "{share}");
    }
}

#[test]
fn eight_against_thirty_per_cent_of_noise_are_told_apart() {
    let (share, _) = significant(4, [|_| 0.08, |_| 0.30]);
    assert!(share >= 0.8, "{share}");
}
