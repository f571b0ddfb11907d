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

/// How often all of several answers to the same question are right: pass^k.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct AllRight {
    /// How many answers, k.
    pub k: u32,
    /// Questions with at least k answers.
    pub questions: u32,
    /// The mean over them of the chance that k of their answers, drawn without replacement, are all right; `None`
    /// without any.
    pub share: Option<f64>,
}

impl AllRight {
    /// From the right and the wrong answers to each question; one without a verdict is wrong.
    ///
    /// C(r, k)/C(n, k) of r right among n answers, which is unbiased: as the estimator of M. Chen et al., "Evaluating
    /// large language models trained on code", arXiv:2107.03374 (2021), for k of k as in S. Yao et al., "τ-bench",
    /// arXiv:2406.12045 (2024).
    #[must_use]
    pub fn of_questions(k: u32, questions: impl Iterator<Item = (u32, u32)>) -> Self {
        let (mut counted, mut sum) = (0, 0.0);
        for (right, wrong) in questions.filter(|(right, wrong)| k > 0 && right + wrong >= k) {
            let all = right + wrong;
            let drawn = (0..k).map(|i| f64::from(right.saturating_sub(i)) / f64::from(all - i));
            sum += drawn.product::<f64>();
            counted += 1;
        }
        Self {
            k,
            questions: counted,
            share: (counted > 0).then(|| sum / f64::from(counted)),
        }
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
    fn all_right_by_hand() {
        // C(3,2)/C(4,2) = 1/2, C(2,2)/C(2,2) = 1, C(1,2) = 0; the single answer is left out.
        let questions = [(3, 1), (2, 0), (1, 3), (1, 0)];
        let found = AllRight::of_questions(2, questions.into_iter());
        assert_eq!((found.questions, found.share), (3, Some(0.5)));
        assert_eq!(AllRight::of_questions(5, questions.into_iter()).share, None);
    }

    #[test]
    fn a_tie_is_no_verdict() {
        let votes = [(2, 1), (1, 2), (1, 1), (0, 0)].map(|(yes, no)| majority(yes, no));
        assert_eq!(votes, [Some(true), Some(false), None, None]);
    }
}
