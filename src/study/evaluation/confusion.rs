//! Confusion matrices of yes-or-no answers: counts, precision, recall, F1.

use schemars::JsonSchema;
use serde::Serialize;

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

#[cfg(test)]
mod tests {
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
}
