//! The verdicts of one way by question and by scenario: majorities, agreement, and intervals over units.

use std::collections::{BTreeMap, BTreeSet};

use schemars::JsonSchema;
use serde::Serialize;

use super::super::statistics::{
    AllRight, AnswerAgreement, Interval, ShareIntervals, majority, scenario_interval,
    share_interval, share_intervals, shown,
};
use super::super::{Confusion, Scored};
use super::consumption::count;

/// Steps of a window, first and last.
type Window = Option<(i64, i64)>;

/// The verdicts on one question: one scenario, one window.
#[derive(Debug, Default)]
struct Votes {
    truth: Option<bool>,
    yes: u32,
    no: u32,
    /// Answers without a verdict.
    silent: u32,
    samples: BTreeSet<u32>,
}

/// The verdicts of one way.
#[derive(Debug, Default)]
pub(super) struct Ballot<'a> {
    questions: BTreeMap<(&'a str, Window), Votes>,
    units: BTreeMap<&'a str, Confusion>,
    /// By unit, the questions that it is right about, and those asked.
    right: BTreeMap<&'a str, (u32, u32)>,
}

/// What several samples of the same questions come to.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, JsonSchema)]
pub struct Samples {
    /// Questions with two verdicts or more.
    #[schemars(title = "Questions")]
    pub scenarios: u32,
    /// Of them those on which all samples agree.
    pub unanimous: u32,
    /// Their share.
    #[schemars(title = "Unanimous", extend("decimals" = 2))]
    pub unanimity: Option<f64>,
    /// The share of pairs of samples that agree.
    #[schemars(title = "Agreement", extend("decimals" = 2))]
    pub agreement: Option<f64>,
    /// The chance that all k samples of a question are right.
    #[schemars(title = "All right", extend("decimals" = 2))]
    pub all_right: Option<f64>,
    /// The number of samples, k.
    pub all_right_k: u32,
    /// Questions with k answers.
    pub all_right_of: u32,
    /// The majority of samples for each question, against the ground truth.
    pub majority: Confusion,
    /// Questions with a truth whose samples say yes and no equally often, or nothing at all.
    #[schemars(title = "Undecided")]
    pub undecided: u32,
    /// Of them those whose samples say yes and no equally often.
    #[schemars(title = "Ties")]
    pub ties: u32,
    /// The share of questions with a truth that have a majority.
    #[schemars(title = "Coverage", extend("decimals" = 2))]
    pub majority_coverage: Option<f64>,
    /// F1 of the majorities.
    #[schemars(title = "F1", extend("decimals" = 2))]
    pub majority_f1: Option<f64>,
}

impl<'a> Ballot<'a> {
    /// Takes an answer, or that there is none; `said` is its yes or no.
    pub fn take(&mut self, one: &'a Scored, said: Option<bool>) {
        let votes = self
            .questions
            .entry((&one.scenario, one.window))
            .or_default();
        votes.truth = votes.truth.or(one.is_collision());
        votes.samples.insert(one.sample);
        match said {
            Some(true) => votes.yes += 1,
            Some(false) => votes.no += 1,
            None => votes.silent += u32::from(one.is_right().is_some()),
        }
        if let Some(is_right) = one.is_right() {
            let (right, asked) = self.right.entry(one.unit()).or_default();
            *right += u32::from(is_right);
            *asked += 1;
        }
        let unit = self.units.entry(one.unit()).or_default();
        if let (Some(said), Some(truth)) = (said, one.is_collision()) {
            unit.count(said, truth);
        }
    }

    /// How many scenarios were asked about.
    pub fn scenarios(&self) -> u32 {
        let names: BTreeSet<&str> = self.questions.keys().map(|(name, _)| *name).collect();
        count(names.len())
    }

    /// What samples come to, with F1 where it is wanted. A question without a run has no window: it is that of the
    /// scenario, where there is one.
    pub fn samples(&mut self, with_f1: bool) -> Samples {
        let unknown: Vec<&str> = self
            .questions
            .keys()
            .filter(|(_, w)| w.is_none())
            .map(|(s, _)| *s)
            .collect();
        for scenario in unknown {
            let after = (scenario, Some((i64::MIN, i64::MIN)));
            let known = self.questions.range(after..).next().map(|(key, _)| *key);
            let Some(known) = known.filter(|(name, _)| *name == scenario) else {
                continue;
            };
            if let Some(votes) = self.questions.remove(&(scenario, None)) {
                let into = self.questions.entry(known).or_default();
                into.samples.extend(votes.samples);
                into.yes += votes.yes;
                into.no += votes.no;
                into.silent += votes.silent;
            }
        }
        let mut found = Samples::default();
        let mut spread = AnswerAgreement::default();
        for votes in self.questions.values() {
            spread.count(votes.yes, votes.no);
            match (majority(votes.yes, votes.no), votes.truth) {
                (Some(said), Some(truth)) => found.majority.count(said, truth),
                (None, Some(_)) => {
                    found.undecided += 1;
                    found.ties += u32::from(votes.yes > 0);
                }
                (_, None) => {}
            }
        }
        let most = self
            .questions
            .values()
            .map(|votes| votes.samples.len())
            .max();
        // An answer without a verdict is not right; a sample that is not asked yet is no answer.
        let right = self.questions.values().filter_map(|votes| {
            let (right, wrong) = if votes.truth? {
                (votes.yes, votes.no)
            } else {
                (votes.no, votes.yes)
            };
            Some((right, wrong + votes.silent))
        });
        let all_right = AllRight::of_questions(count(most.unwrap_or(0)), right);
        let decided = found.majority.answered();
        let all = decided + found.undecided;
        Samples {
            scenarios: spread.scenarios,
            unanimous: spread.unanimous,
            unanimity: spread.unanimity(),
            agreement: spread.agreement(),
            all_right: all_right.share,
            all_right_k: all_right.k,
            all_right_of: all_right.questions,
            majority_coverage: (all > 0).then(|| f64::from(decided) / f64::from(all)),
            majority_f1: found.majority.f1().filter(|_| with_f1),
            ..found
        }
    }

    /// The counts of the units with a verdict and a truth.
    fn counted(&self) -> Vec<Confusion> {
        let all = self.units.values().copied();
        all.filter(|counts| counts.answered() > 0).collect()
    }

    /// The intervals of shares: over units where one has several answers, else Wilson's, F1 apart.
    pub fn intervals(&self) -> ShareIntervals {
        let counted = self.counted();
        let mut sum = Confusion::default();
        counted.iter().for_each(|counts| sum.add(counts));
        let drawn = share_intervals(&counted);
        let clustered = counted.iter().any(|counts| counts.answered() > 1);
        let of = |interval: Option<Interval>, part: fn(&Confusion) -> (u32, u32)| {
            let (hits, all) = part(&sum);
            let holding = counted.iter().filter(|counts| part(counts).1 > 0).count();
            share_interval(interval.filter(|_| clustered), (hits, all), count(holding))
        };
        let right: Vec<(u32, u32)> = self.right.values().copied().collect();
        ShareIntervals {
            right: scenario_interval(&right),
            precision: of(drawn.precision, |c| {
                (c.true_positives, c.true_positives + c.false_positives)
            }),
            recall: of(drawn.recall, |c| (c.true_positives, c.positives())),
            specificity: of(drawn.specificity, |c| (c.true_negatives, c.negatives())),
            accuracy: of(drawn.accuracy, |c| {
                (c.true_positives + c.true_negatives, c.answered())
            }),
            // Where no draw differs, the bootstrap says nothing.
            f1: shown(drawn.f1, count(counted.len())).filter(|drawn| drawn.low < drawn.high),
        }
    }
}
