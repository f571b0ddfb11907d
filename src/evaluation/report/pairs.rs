//! Pairs of prompt configurations that differ in one thing, on the same scenarios.

use std::collections::BTreeMap;

use super::super::statistics::{McNemar, holm, majority};
use super::super::{PromptConfig, Scored};
use super::consumption::count;

/// Two ways that differ in one thing.
#[derive(Debug, Clone, PartialEq)]
pub struct Pair {
    /// One way.
    pub first: PromptConfig,
    /// The other one.
    pub second: PromptConfig,
    /// In what they differ: `frame`, `techniques`, `model` or `template`.
    pub differs: &'static str,
    /// Scenarios with a truth and a verdict of both; of several samples what most of them say.
    pub n: u32,
    /// Scenarios that both were asked about, and that at least one has no verdict on.
    pub left_out: u32,
    /// Which is right more often.
    pub test: McNemar,
    /// The p value corrected for all pairs of the same task, by Holm.
    pub corrected: f64,
}

/// What a way says of each scenario: whether it is right, or nothing where it says nothing.
type Right<'a> = BTreeMap<&'a str, Option<bool>>;

/// Every pair, in the order of the ways.
pub(super) fn compare_pairs(ways: &[(&PromptConfig, Vec<&Scored>)]) -> Vec<Pair> {
    let right: Vec<Right<'_>> = ways.iter().map(|(_, scored)| right(scored)).collect();
    let mut pairs = Vec::new();
    for (i, (first, _)) in ways.iter().enumerate() {
        for (j, (second, _)) in ways.iter().enumerate().skip(i + 1) {
            if let Some(differs) = difference(first, second) {
                pairs.extend(pair(first, second, differs, &right[i], &right[j]));
            }
        }
    }
    for task in crate::verdict::Task::VERDICTS {
        let mut of_task: Vec<&mut Pair> =
            pairs.iter_mut().filter(|p| p.first.task == task).collect();
        let p: Vec<f64> = of_task.iter().map(|p| p.test.p).collect();
        for (pair, corrected) in of_task.iter_mut().zip(holm(&p)) {
            pair.corrected = corrected;
        }
    }
    pairs
}

fn right<'a>(scored: &[&'a Scored]) -> Right<'a> {
    let mut votes: BTreeMap<&str, (bool, u32, u32)> = BTreeMap::new();
    for one in scored {
        let Some(truth) = one.is_collision() else {
            continue;
        };
        let (_, yes, no) = votes.entry(&one.scenario).or_insert((truth, 0, 0));
        match one.positive() {
            Some(true) => *yes += 1,
            Some(false) => *no += 1,
            None => {}
        }
    }
    let right = |(truth, yes, no)| majority(yes, no).map(|said| said == truth);
    votes
        .into_iter()
        .map(|(name, v)| (name, right(v)))
        .collect()
}

/// The one thing in which two ways differ.
fn difference(a: &PromptConfig, b: &PromptConfig) -> Option<&'static str> {
    // A judge without a prompt differs from the others in frame and techniques at once.
    if a.task != b.task || a.frame.is_some() != b.frame.is_some() {
        return None;
    }
    let differ = [
        (a.frame != b.frame, "frame"),
        (a.techniques != b.techniques, "techniques"),
        (a.model != b.model, "model"),
        (a.template != b.template, "template"),
    ];
    let mut differ = differ.into_iter().filter(|(differs, _)| *differs);
    let (_, name) = differ.next()?;
    differ.next().is_none().then_some(name)
}

fn pair(
    first: &PromptConfig,
    second: &PromptConfig,
    differs: &'static str,
    a: &Right<'_>,
    b: &Right<'_>,
) -> Option<Pair> {
    let both: Vec<_> = a
        .iter()
        .filter_map(|(name, one)| b.get(name).map(|other| one.zip(*other)))
        .collect();
    let said: Vec<(bool, bool)> = both.iter().copied().flatten().collect();
    if said.is_empty() {
        return None;
    }
    let only = |wanted| count(said.iter().filter(|s| **s == wanted).count());
    Some(Pair {
        first: first.clone(),
        second: second.clone(),
        differs,
        n: count(said.len()),
        left_out: count(both.len() - said.len()),
        test: McNemar::from_discordant(only((true, false)), only((false, true))),
        corrected: 1.0,
    })
}
