//! Agreement beyond chance: of two judges, of persons with several categories, of several answers to one question.

use std::collections::BTreeMap;

use serde::Serialize;

use super::{FEWEST, Interval, Z};

/// Cohen's kappa of two judges that say yes or no.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Kappa {
    /// Questions that both answered.
    pub n: u32,
    /// The share of them on which both say the same.
    pub agreement: f64,
    /// 1 for full agreement, 0 for that of chance; `None` if chance alone makes both agree always.
    pub kappa: Option<f64>,
    /// Its interval of 95 %, over answers; `None` of fewer than [`FEWEST`].
    pub interval: Option<Interval>,
}

impl Kappa {
    /// From the counts [both yes, yes and no, no and yes, both no]; nothing of nothing.
    ///
    /// κ = (p₀ − pₑ)/(1 − pₑ) with the observed agreement p₀ and that of chance pₑ. J. Cohen, "A coefficient of
    /// agreement for nominal scales", Educational and Psychological Measurement 20 (1960). The interval is κ ± 1.96
    /// times the standard error of J. L. Fleiss, J. Cohen and B. S. Everitt, "Large sample standard errors of kappa
    /// and weighted kappa", Psychological Bulletin 72 (1969), within −1 and 1.
    #[must_use]
    pub fn from_counts(counts: [u32; 4]) -> Option<Self> {
        let n: u32 = counts.iter().sum();
        if n == 0 {
            return None;
        }
        let all = f64::from(n);
        let [a, b, c, d] = counts.map(|count| f64::from(count) / all);
        let rows = [a + b, c + d];
        let columns = [a + c, b + d];
        let observed = a + d;
        let chance = rows[0] * columns[0] + rows[1] * columns[1];
        let value = (chance < 1.0).then(|| (observed - chance) / (1.0 - chance));
        // Few answers have none, as of other figures.
        let interval = value.filter(|_| n >= FEWEST).map(|kappa| {
            let diagonal = [a, d].into_iter().enumerate().map(|(i, p)| {
                let spread = 1.0 - (rows[i] + columns[i]) * (1.0 - kappa);
                p * spread * spread
            });
            let aside = b * (columns[0] + rows[1]).powi(2) + c * (columns[1] + rows[0]).powi(2);
            let aside = (1.0 - kappa).powi(2) * aside;
            let less = (kappa - chance * (1.0 - kappa)).powi(2);
            let variance = (diagonal.sum::<f64>() + aside - less) / ((1.0 - chance).powi(2) * all);
            let half = Z * variance.max(0.0).sqrt();
            Interval {
                low: (kappa - half).max(-1.0),
                high: (kappa + half).min(1.0),
            }
        });
        Some(Self {
            n,
            agreement: observed,
            kappa: value,
            interval,
        })
    }
}

/// Cohen's kappa of two persons, from their choices about the same things; `None` without any, or where chance alone
/// makes both agree always.
///
/// κ = (p₀ − pₑ)/(1 − pₑ) with the observed agreement p₀ and that of chance pₑ, from each person's own shares. J. Cohen,
/// "A coefficient of agreement for nominal scales", Educational and Psychological Measurement 20 (1960).
#[must_use]
pub fn cohen<C: Ord>(choices: &[(C, C)]) -> Option<f64> {
    let n = choices.len() as f64;
    let mut shares: BTreeMap<&C, [f64; 2]> = BTreeMap::new();
    for (first, second) in choices {
        shares.entry(first).or_default()[0] += 1.0 / n;
        shares.entry(second).or_default()[1] += 1.0 / n;
    }
    let same = choices.iter().filter(|(a, b)| a == b).count() as f64 / n;
    let chance: f64 = shares.values().map(|[a, b]| a * b).sum();
    beyond_chance(same, chance)
}

/// Fleiss' kappa of several persons, from the choices about each thing; things with one choice say nothing and are left
/// out. `None` as for [`cohen`].
///
/// The observed agreement is the mean over things of the share of pairs of choices that agree, that of chance Σ pⱼ² of
/// the shares of all choices. J. L. Fleiss, "Measuring nominal scale agreement among many raters", Psychological
/// Bulletin 76 (1971); things may have different numbers of choices.
#[must_use]
pub fn fleiss<C: Ord>(things: &[Vec<C>]) -> Option<f64> {
    let (mut observed, mut n, mut all) = (0.0, 0.0, 0.0);
    let mut totals: BTreeMap<&C, f64> = BTreeMap::new();
    for choices in things.iter().filter(|choices| choices.len() > 1) {
        let mut counts: BTreeMap<&C, f64> = BTreeMap::new();
        for choice in choices {
            *counts.entry(choice).or_default() += 1.0;
            *totals.entry(choice).or_default() += 1.0;
        }
        let m = choices.len() as f64;
        observed += counts.values().map(|k| k * (k - 1.0)).sum::<f64>() / (m * (m - 1.0));
        n += 1.0;
        all += m;
    }
    let chance: f64 = totals.values().map(|k| (k / all).powi(2)).sum();
    beyond_chance(observed / n, chance)
}

fn beyond_chance(observed: f64, chance: f64) -> Option<f64> {
    // Of nothing both are not numbers.
    (observed.is_finite() && chance < 1.0 - 1e-12).then(|| (observed - chance) / (1.0 - chance))
}

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
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// statsmodels 0.15, `cohens_kappa`: kappa, kappa_low, kappa_upp.
    #[test]
    fn as_statsmodels_has_it() {
        for (counts, kappa, low, high) in [
            (
                [20, 5, 10, 15],
                0.4,
                0.151_092_290_476_661,
                0.648_907_709_523_338_9,
            ),
            (
                [45, 15, 25, 15],
                0.130_434_782_608_695_54,
                -0.062_938_277_962_589_65,
                0.323_807_843_007_980_7,
            ),
            ([10, 0, 0, 10], 1.0, 1.0, 1.0),
            ([0, 5, 5, 0], -1.0, -1.0, -1.0),
        ] {
            let found = Kappa::from_counts(counts).unwrap();
            let interval = found.interval.unwrap();
            let near = |a: f64, b: f64| (a - b).abs() < 1e-9;
            assert!(near(found.kappa.unwrap(), kappa), "{found:?}");
            assert!(
                near(interval.low, low) && near(interval.high, high),
                "{found:?}"
            );
        }
    }

    #[test]
    fn who_always_says_the_same_has_no_kappa() {
        let same = Kappa::from_counts([7, 0, 0, 0]).unwrap();
        assert_eq!(
            (same.agreement, same.kappa, same.interval),
            (1.0, None, None)
        );
        assert_eq!(Kappa::from_counts([0; 4]), None);
    }

    fn near(found: Option<f64>, wanted: f64) {
        assert!(
            found.is_some_and(|k| (k - wanted).abs() < 1e-3),
            "{found:?}"
        );
    }

    /// scikit-learn 1.7, `cohen_kappa_score([0,0,1,2,2,1], [0,1,1,2,2,0])` = 0.5.
    #[test]
    fn two_persons_as_scikit_learn_has_it() {
        near(
            cohen(&[(0, 0), (0, 1), (1, 1), (2, 2), (2, 2), (1, 0)]),
            0.5,
        );
        assert_eq!(cohen::<u8>(&[]), None);
        assert_eq!(cohen(&[(1, 1), (1, 1)]), None);
    }

    /// The example of Wikipedia's page on Fleiss' kappa: ten things, 14 raters, κ = 0.210.
    #[test]
    fn several_persons_as_published() {
        let counts = [
            [0, 0, 0, 0, 14],
            [0, 2, 6, 4, 2],
            [0, 0, 3, 5, 6],
            [0, 3, 9, 2, 0],
            [2, 2, 8, 1, 1],
            [7, 7, 0, 0, 0],
            [3, 2, 6, 3, 0],
            [2, 5, 3, 2, 2],
            [6, 5, 2, 1, 0],
            [0, 2, 2, 3, 7],
        ];
        let things: Vec<Vec<usize>> = counts
            .iter()
            .map(|row| {
                let each = row.iter().enumerate();
                each.flat_map(|(category, n)| vec![category; *n]).collect()
            })
            .collect();
        near(fleiss(&things), 0.210);
        assert_eq!(fleiss(&[vec![1]]), None, "one choice says nothing");
    }

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
