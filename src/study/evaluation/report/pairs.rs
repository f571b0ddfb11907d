//! Comparisons of two prompt configurations on the same scenarios.

use std::collections::BTreeMap;

use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;

use super::super::statistics::{McNemar, PairedTest, holm};
use super::super::{PromptConfig, Scored};
use super::comparison::{Compared, Comparison, Family};
use super::consumption::count;
use nearmiss_record::Record;
use nearmiss_scene::verdict::Task;

/// Two ways on the same scenarios.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Pair {
    /// One way.
    pub first: PromptConfig,
    /// The other one.
    pub second: PromptConfig,
    /// In what they differ: `frame`, `techniques`, `model` or `template`; `several` of declared ones.
    pub differs: &'static str,
    /// With which other comparisons it is corrected.
    #[schemars(title = "Family")]
    pub family: Family,
    /// Units with a truth that both were asked about.
    #[schemars(title = "n")]
    pub n: u32,
    /// Units of both that one was not asked about yet.
    #[schemars(title = "Left out")]
    pub left_out: u32,
    /// Of the n those on which the samples of at least one are as often right as wrong.
    #[schemars(title = "Ties")]
    pub ties: u32,
    /// By how much the first is right more often.
    #[serde(flatten)]
    pub test: PairedTest,
    /// The p value of the test, corrected for its family of the same task, by Holm.
    #[serde(rename = "p_holm")]
    #[schemars(title = "p (Holm)", extend("decimals" = 3, "bounded" = true))]
    pub corrected: f64,
    /// The same of majorities: without ties.
    #[serde(flatten)]
    pub mcnemar: McNemar,
}

impl Record for Pair {
    const NAME: &'static str = "pair";
    const TITLE: &'static str = "Two prompt configurations on the same scenarios";
}

/// How often a way is right about each scenario of each unit, and how often not: see [`Scored::is_right`].
type Right<'a> = BTreeMap<&'a str, BTreeMap<&'a str, Counts>>;

/// Every comparison, the declared ones first, in the order of the ways.
pub(super) fn compare_pairs(
    ways: &[(&PromptConfig, Vec<&Scored>)],
    comparison: &Comparison,
) -> Vec<Pair> {
    let right: Vec<Right<'_>> = ways.par_iter().map(|(_, scored)| right(scored)).collect();
    let mut wanted = Vec::new();
    for (i, (first, _)) in ways.iter().enumerate() {
        for (j, (second, _)) in ways.iter().enumerate().skip(i + 1) {
            if let Some(compared) = comparison.of(first, second) {
                let (i, j) = if compared.turned { (j, i) } else { (i, j) };
                wanted.push((i, j, compared));
            }
        }
    }
    let pairs = wanted.into_par_iter().filter_map(|(i, j, compared)| {
        pair([ways[i].0, ways[j].0], &compared, [&right[i], &right[j]])
    });
    let mut pairs: Vec<Pair> = pairs.collect();
    pairs.sort_by_key(|pair| Family::ALL.iter().position(|family| *family == pair.family));
    for (task, family) in Task::VERDICTS
        .into_iter()
        .flat_map(|task| Family::ALL.map(|family| (task, family)))
    {
        let together = |pair: &&mut Pair| pair.first.task == task && pair.family == family;
        let mut of_family: Vec<&mut Pair> = pairs.iter_mut().filter(together).collect();
        let p: Vec<f64> = of_family.iter().map(|p| p.test.p).collect();
        for (pair, corrected) in of_family.iter_mut().zip(holm(&p)) {
            pair.corrected = corrected;
        }
    }
    pairs
}

fn right<'a>(scored: &[&'a Scored]) -> Right<'a> {
    let mut found = Right::new();
    for one in scored {
        if one.is_collision().is_none() {
            continue;
        }
        let of_unit = found.entry(one.unit()).or_default();
        let (right, wrong) = of_unit.entry(&one.scenario).or_default();
        match one.is_right() {
            Some(true) => *right += 1,
            Some(false) => *wrong += 1,
            None => {}
        }
    }
    found
}

/// Right and not.
type Counts = (u32, u32);

/// Sums over the scenarios of a unit that both were asked about, zeros where that is none; `None` where they have no
/// scenario in common.
fn common(a: &BTreeMap<&str, Counts>, b: &BTreeMap<&str, Counts>) -> Option<[Counts; 2]> {
    let shared = { a.iter() }.filter_map(|(name, a)| Some([*a, *b.get(name)?]));
    let shared: Vec<[Counts; 2]> = shared.collect();
    let asked = shared
        .iter()
        .filter(|both| both.iter().all(|(right, wrong)| right + wrong > 0));
    let sum = |x: Counts, y: Counts| (x.0 + y.0, x.1 + y.1);
    let sums = asked.fold([(0, 0); 2], |all, one| {
        [sum(all[0], one[0]), sum(all[1], one[1])]
    });
    (!shared.is_empty()).then_some(sums)
}

fn pair(
    [first, second]: [&PromptConfig; 2],
    compared: &Compared,
    [a, b]: [&Right<'_>; 2],
) -> Option<Pair> {
    let units = { a.iter() }.filter_map(|(unit, a)| Some((a, b.get(unit)?)));
    let both: Vec<_> = units.filter_map(|(a, b)| common(a, b)).collect();
    let asked = both.iter().filter(|[(right, wrong), _]| right + wrong > 0);
    let pairs: Vec<_> = asked.collect();
    let share = |(right, wrong): Counts| f64::from(right) / f64::from(right + wrong);
    let differences: Vec<f64> = pairs.iter().map(|[a, b]| share(*a) - share(*b)).collect();
    let majority = |(right, wrong): Counts| (right != wrong).then_some(right > wrong);
    let votes = pairs.iter().map(|[a, b]| majority(*a).zip(majority(*b)));
    let only = |wanted| count(votes.clone().filter(|v| *v == Some(wanted)).count());
    Some(Pair {
        first: first.clone(),
        second: second.clone(),
        differs: compared.differs,
        family: compared.family,
        n: count(pairs.len()),
        left_out: count(both.len() - pairs.len()),
        ties: count(votes.clone().filter(Option::is_none).count()),
        test: PairedTest::of_differences(&differences)?.shown(count(pairs.len())),
        mcnemar: McNemar::from_discordant(only((true, false)), only((false, true))),
        corrected: 1.0,
    })
}
