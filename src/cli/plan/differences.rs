//! Differences between two planners over the scenarios that both drove.

use super::driven::DrivenScenario;
use super::figures::{FIGURES, KINDS};
use super::table::OUTCOMES;
use nearmiss_drive::simulation::Outcome;
use nearmiss_scene::traffic_rules::Rule;
use nearmiss_study::evaluation::statistics::PairedTest;

/// Both drives of a scenario.
type Pair = (DrivenScenario, DrivenScenario);

/// A figure of both planners.
pub struct Difference {
    /// Its name in JSON.
    pub key: &'static str,
    /// In the table.
    pub words: &'static str,
    /// Decimals that are shown.
    pub decimals: usize,
    /// Scenarios in which both drives have it.
    pub scenarios: usize,
    /// Over these a count or a mean.
    pub first: Option<f64>,
    /// See `first`.
    pub second: Option<f64>,
    /// Of the differences in these.
    pub test: Option<PairedTest>,
    /// It counts drives that break a rule.
    pub is_rule: bool,
    /// It is the share that another one counts, in JSON alone.
    pub is_share: bool,
}

/// The differences of all figures.
pub fn all(pairs: &[Pair]) -> Vec<Difference> {
    let count = |key, words, is: &dyn Fn(&DrivenScenario) -> bool| {
        let figure = |driven: &DrivenScenario| Some(f64::from(u8::from(is(driven))));
        of(pairs, (key, words, 0), true, &figure)
    };
    let mut all = Vec::new();
    for name in OUTCOMES {
        all.push(count(name, name, &|driven| driven.outcome().name() == name));
        if name != "collision" {
            continue;
        }
        all.extend(KINDS.iter().map(|(words, kind)| {
            count(kind.name(), words, &|driven| {
                driven.collision().is_some_and(|c| c.kind() == *kind)
            })
        }));
    }
    all.extend(Rule::ALL.map(|rule| Difference {
        is_rule: true,
        ..count(rule.name(), rule.text(), &|driven| {
            driven.rules.broken().any(|broken| broken == rule)
        })
    }));
    let beyond = |driven: &DrivenScenario| Some(f64::from(u8::from(driven.is_beyond_vehicle()?)));
    all.push(of(
        pairs,
        ("undrivable_drives", "drives beyond the vehicle", 0),
        true,
        &beyond,
    ));
    all.extend(FIGURES.iter().map(|(key, words, decimals, figure)| {
        // What a drive would have come to is not known where its planner failed.
        let whole = |driven: &DrivenScenario| match driven.outcome() {
            Outcome::PlannerError(_) => None,
            _ => figure(driven),
        };
        of(pairs, (key, words, *decimals), false, &whole)
    }));
    all.push(Difference {
        is_share: true,
        ..of(pairs, ("undrivable_share", "", 2), false, &beyond)
    });
    all
}

/// The difference of a figure over the scenarios in which both drives have it; means over these, and sums of counts over
/// all drives that have them.
fn of(
    pairs: &[Pair],
    (key, words, decimals): (&'static str, &'static str, usize),
    summed: bool,
    figure: &dyn Fn(&DrivenScenario) -> Option<f64>,
) -> Difference {
    let both = pairs
        .iter()
        .filter_map(|(one, two)| Some((figure(one)?, figure(two)?)));
    let both: Vec<(f64, f64)> = both.collect();
    let whole = |own: &dyn Fn(&Pair) -> Option<f64>, of_both: &dyn Fn(&(f64, f64)) -> f64| {
        let counts: Vec<f64> = pairs.iter().filter_map(own).collect();
        match (summed, both.len()) {
            (true, _) => (!counts.is_empty()).then(|| counts.iter().sum()),
            (false, 0) => None,
            (false, n) => Some(both.iter().map(of_both).sum::<f64>() / n as f64),
        }
    };
    let differences: Vec<f64> = both.iter().map(|(one, two)| one - two).collect();
    Difference {
        key,
        words,
        decimals,
        scenarios: both.len(),
        first: whole(&|pair| figure(&pair.0), &|both| both.0),
        second: whole(&|pair| figure(&pair.1), &|both| both.1),
        // One scenario says nothing about how much they differ.
        test: (differences.len() > 1)
            .then(|| PairedTest::of_differences(&differences))
            .flatten(),
        is_rule: false,
        is_share: false,
    }
}
