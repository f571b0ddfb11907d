//! Several answers to one question: their agreement and majority.

use serde::Serialize;

/// The majority of answers; `None` without answers or on a tie.
#[must_use]
pub fn majority(yes: u32, no: u32) -> Option<bool> {
    (yes != no).then_some(yes > no)
}

/// Agreement of answers to the same question.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct AnswerAgreement {
    /// Scenarios with two verdicts or more.
    pub scenarios: u32,
    /// Of them those on which all say the same.
    pub unanimous: u32,
    /// The sum of the shares of pairs of answers that agree, see [`Self::agreement`].
    #[serde(skip)]
    pairs: f64,
}

impl AnswerAgreement {
    /// Counts the verdicts on one scenario; fewer than two say nothing about spread.
    pub fn count(&mut self, yes: u32, no: u32) {
        let all = f64::from(yes + no);
        if yes + no < 2 {
            return;
        }
        let pairs = |k: u32| f64::from(k) * (f64::from(k) - 1.0);
        self.scenarios += 1;
        self.unanimous += u32::from(yes == 0 || no == 0);
        self.pairs += (pairs(yes) + pairs(no)) / (all * (all - 1.0));
    }

    /// The share of unanimous scenarios; `None` if no scenario has two verdicts.
    #[must_use]
    pub fn unanimity(&self) -> Option<f64> {
        (self.scenarios > 0).then(|| f64::from(self.unanimous) / f64::from(self.scenarios))
    }

    /// The mean over scenarios of the share of pairs of answers that agree, (y(y−1) + m(m−1)) / (k(k−1)) of y yes and
    /// m no among k: the observed agreement of J. L. Fleiss, "Measuring nominal scale agreement among many raters",
    /// Psychological Bulletin 76 (1971).
    #[must_use]
    pub fn agreement(&self) -> Option<f64> {
        (self.scenarios > 0).then(|| self.pairs / f64::from(self.scenarios))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agreement_by_hand() {
        let mut spread = AnswerAgreement::default();
        for (yes, no) in [(3, 0), (2, 1), (0, 2), (1, 0), (2, 2)] {
            spread.count(yes, no);
        }
        // Pairs that agree: 3 of 3, 1 of 3, 1 of 1, 2 of 6; the single answer is not counted.
        assert_eq!((spread.scenarios, spread.unanimous), (4, 2));
        assert_eq!(spread.unanimity(), Some(0.5));
        let wanted = (1.0 + 1.0 / 3.0 + 1.0 + 1.0 / 3.0) / 4.0;
        assert!(
            spread
                .agreement()
                .is_some_and(|a| (a - wanted).abs() < 1e-12)
        );
    }

    #[test]
    fn a_tie_is_no_verdict() {
        let votes = [(2, 1), (1, 2), (1, 1), (0, 0)].map(|(yes, no)| majority(yes, no));
        assert_eq!(votes, [Some(true), Some(false), None, None]);
    }
}
