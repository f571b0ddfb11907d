//! Confusion matrices and proportions of yes-or-no answers, with intervals over scenarios or maps.

use std::collections::BTreeMap;

use nearmiss_scene::scenario::identity;
use schemars::JsonSchema;
use serde::Serialize;
use strum::{IntoStaticStr, VariantArray};

use super::statistics::{Interval, scenario_interval};

/// Counts of answers by verdict and ground truth.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, JsonSchema)]
pub struct Confusion {
    /// Yes, and right.
    #[serde(rename = "tp")]
    #[schemars(title = "TP", extend("table" = "accuracy"))]
    pub true_positives: u32,
    /// Yes, and wrong.
    #[serde(rename = "fp")]
    #[schemars(title = "FP", extend("table" = "accuracy"))]
    pub false_positives: u32,
    /// No, and wrong.
    #[serde(rename = "fn")]
    #[schemars(title = "FN", extend("table" = "accuracy"))]
    pub false_negatives: u32,
    /// No, and right.
    #[serde(rename = "tn")]
    #[schemars(title = "TN", extend("table" = "accuracy"))]
    pub true_negatives: u32,
}

impl Confusion {
    /// Counts one answer.
    pub fn count(&mut self, said: bool, truth: bool) {
        *match (said, truth) {
            (true, true) => &mut self.true_positives,
            (true, false) => &mut self.false_positives,
            (false, true) => &mut self.false_negatives,
            (false, false) => &mut self.true_negatives,
        } += 1;
    }

    /// Adds other counts.
    pub fn add(&mut self, other: &Self) {
        self.true_positives += other.true_positives;
        self.false_positives += other.false_positives;
        self.false_negatives += other.false_negatives;
        self.true_negatives += other.true_negatives;
    }

    /// TP, FP, FN and TN, in the order of tables.
    #[must_use]
    pub fn counts(&self) -> [u32; 4] {
        [
            self.true_positives,
            self.false_positives,
            self.false_negatives,
            self.true_negatives,
        ]
    }

    /// Cases that were answered.
    #[must_use]
    pub fn answered(&self) -> u32 {
        self.positives() + self.negatives()
    }

    /// The share of answers that are right; nothing without an answer.
    #[must_use]
    pub fn accuracy(&self) -> Option<f64> {
        ratio(self.true_positives + self.true_negatives, self.answered())
    }

    /// The share of negatives that were called so; nothing without negatives.
    #[must_use]
    pub fn specificity(&self) -> Option<f64> {
        ratio(self.true_negatives, self.negatives())
    }

    /// The one answer to all cases, though some are positive and some are not: such answers tell nothing of a case,
    /// whatever their F1 is.
    #[must_use]
    pub fn always(&self) -> Option<bool> {
        let yes = self.true_positives + self.false_positives;
        let mixed = self.positives() > 0 && self.negatives() > 0;
        match yes {
            _ if !mixed => None,
            0 => Some(false),
            _ if yes == self.answered() => Some(true),
            _ => None,
        }
    }

    /// Cases that are positive in truth.
    #[must_use]
    pub fn positives(&self) -> u32 {
        self.true_positives + self.false_negatives
    }

    /// Cases that are negative in truth.
    #[must_use]
    pub fn negatives(&self) -> u32 {
        self.false_positives + self.true_negatives
    }

    /// The share of yes that is right; nothing if yes was never said.
    #[must_use]
    pub fn precision(&self) -> Option<f64> {
        ratio(
            self.true_positives,
            self.true_positives + self.false_positives,
        )
    }

    /// The share of positives that were found; nothing without positives.
    #[must_use]
    pub fn recall(&self) -> Option<f64> {
        ratio(self.true_positives, self.positives())
    }

    /// The harmonic mean of precision and recall, 2 TP / (2 TP + FP + FN); nothing without positives.
    #[must_use]
    pub fn f1(&self) -> Option<f64> {
        let wrong = self.false_positives + self.false_negatives;
        (self.positives() > 0)
            .then(|| ratio(2 * self.true_positives, 2 * self.true_positives + wrong))?
    }
}

fn ratio(part: u32, whole: u32) -> Option<f64> {
    (whole > 0).then(|| f64::from(part) / f64::from(whole))
}

/// A proportion: a count out of a total.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Share {
    /// Those that are meant.
    pub hits: u32,
    /// All.
    pub of: u32,
    /// Scenarios that they are about: several answers about one are not independent.
    pub scenarios: u32,
    /// The interval of 95 %, with the scenario as the unit, see [`scenario_interval`].
    pub interval: Option<Interval>,
}

/// Counts a share, answer by answer.
#[derive(Debug, Clone, Default)]
pub(super) struct Tally<'a> {
    /// Hits and all answers of each scenario.
    scenarios: BTreeMap<&'a str, (u32, u32)>,
}

impl<'a> Tally<'a> {
    /// Counts one more answer, about this scenario.
    pub fn count(&mut self, scenario: &'a str, hit: bool) {
        self.add(scenario, u32::from(hit), 1);
    }

    /// Counts more answers about this scenario.
    pub fn add(&mut self, scenario: &'a str, hits: u32, of: u32) {
        let (of_scenario, all) = self.scenarios.entry(scenario).or_default();
        *of_scenario += hits;
        *all += of;
    }

    /// The counted proportion.
    pub fn share(&self) -> Share {
        let counts: Vec<(u32, u32)> = self.scenarios.values().copied().collect();
        Share {
            hits: counts.iter().map(|(hits, _)| hits).sum(),
            of: counts.iter().map(|(_, of)| of).sum(),
            scenarios: counts.iter().filter(|(_, of)| *of > 0).count() as u32,
            interval: scenario_interval(&counts),
        }
    }
}

impl Share {
    /// From 0 to 1; nothing of nothing.
    #[must_use]
    pub fn value(&self) -> Option<f64> {
        (self.of > 0).then(|| f64::from(self.hits) / f64::from(self.of))
    }
}

/// What is drawn, and what differs, as a whole: answers about one are not independent.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, Default, strum::Display, IntoStaticStr, VariantArray,
)]
#[strum(serialize_all = "lowercase")]
pub enum Cluster {
    /// A scenario with all its windows and samples.
    #[default]
    Scenario,
    /// A map, or a long recording, with all its scenarios: the unit of [`Split`](super::batch::Split), too.
    Map,
}

impl Cluster {
    /// The unit that a scenario is of.
    #[must_use]
    pub fn unit(self, scenario: &str) -> &str {
        match self {
            Self::Scenario => scenario,
            Self::Map => identity::family(scenario),
        }
    }
}

nearmiss_record::named!(Cluster, "unit");

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn shares_of_what_was_said_and_of_what_is() {
        let mut c = Confusion::default();
        assert_eq!((c.precision(), c.recall(), c.f1()), (None, None, None));
        let answers = [(true, true), (true, true), (true, false), (false, true)];
        for (said, truth) in answers {
            c.count(said, truth);
        }
        c.count(false, false);
        assert_eq!((c.answered(), c.accuracy()), (5, Some(0.6)));
        assert_eq!(c.specificity(), Some(0.5));
        assert_eq!((c.positives(), c.negatives()), (3, 2));
        assert_eq!(c.precision(), Some(2.0 / 3.0));
        assert_eq!(c.recall(), Some(2.0 / 3.0));
        assert!(c.f1().is_some_and(|f| (f - 2.0 / 3.0).abs() < 1e-12));
    }

    #[test]
    fn who_never_says_yes_has_no_precision_and_no_merit() {
        let mut c = Confusion::default();
        c.count(false, true);
        assert_eq!((c.precision(), c.f1()), (None, Some(0.0)));
    }

    #[test]
    fn one_answer_to_all_is_told_where_both_truths_are_there() {
        let of = |counts: [u32; 4]| Confusion {
            true_positives: counts[0],
            false_positives: counts[1],
            false_negatives: counts[2],
            true_negatives: counts[3],
        };
        for (counts, always) in [
            ([3, 2, 0, 0], Some(true)),
            ([0, 0, 3, 2], Some(false)),
            ([3, 2, 1, 0], None),
            ([3, 0, 0, 0], None),
            ([0, 0, 0, 2], None),
            ([0; 4], None),
        ] {
            assert_eq!(of(counts).always(), always, "{counts:?}");
        }
    }

    #[test]
    fn answers_are_counted_by_scenario() {
        let names: Vec<String> = (0..12).map(|n| format!("S-{n}")).collect();
        let counted = |samples: usize| {
            let mut tally = Tally::default();
            for (at, name) in names.iter().enumerate() {
                (0..samples).for_each(|_| tally.count(name, at < 4));
            }
            tally.share()
        };
        let (once, thrice) = (counted(1), counted(3));
        assert_eq!((once.hits, once.of, once.scenarios), (4, 12, 12));
        assert_eq!((thrice.hits, thrice.of, thrice.scenarios), (12, 36, 12));
        assert_eq!(once.value(), thrice.value());
        // Wilson's with one answer each, else the bootstrap, which more samples do not narrow.
        let (low, high) = once.interval.map(|i| (i.low, i.high)).unwrap();
        assert!((low - 0.138_119).abs() < 1e-5 && (high - 0.609_378).abs() < 1e-5);
        assert_eq!(thrice.interval, counted(9).interval);
        assert_eq!(Tally::default().share(), Share::default());
    }
}
