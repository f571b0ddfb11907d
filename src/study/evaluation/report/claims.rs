//! Claims of answers about obstacles: how many are right, wrong and open.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Serialize;

use super::super::statistics::{Interval, ratio_interval, shown};
use super::super::{AnswerStatus, Scored};

/// Claims of the answers of a cell.
#[derive(Debug, Clone, PartialEq, Default, Serialize, JsonSchema)]
pub struct ClaimTally {
    /// Answers whose claims were checked.
    #[serde(rename = "claims_of")]
    #[schemars(title = "Checked", extend("table" = "claims"))]
    pub answers: u32,
    /// Answers that were not checked, as their scenario was not at hand.
    #[serde(rename = "claims_unchecked")]
    #[schemars(title = "Not checked", extend("table" = "claims"))]
    pub unchecked: u32,
    /// Claims about obstacles that hold; null if none was checked.
    #[serde(rename = "claims_right")]
    #[schemars(title = "Right", extend("table" = "claims"))]
    pub right: Option<u32>,
    /// Claims that do not hold; null if none was checked.
    #[serde(rename = "claims_wrong")]
    #[schemars(title = "Wrong", extend("table" = "claims"))]
    pub wrong: Option<u32>,
    /// Claims that cannot be decided; null if none was checked.
    #[serde(rename = "claims_open")]
    #[schemars(title = "Open", extend("table" = "claims"))]
    pub open: Option<u32>,
    /// Right, wrong and open claims of an answer, on average.
    #[serde(rename = "claims_per_answer")]
    #[schemars(title = "Claims an answer", extend("table" = "claims", "decimals" = 1))]
    pub per_answer: Option<f64>,
    /// The share of wrong claims of those that are right or wrong.
    #[serde(rename = "claims_wrong_share")]
    #[schemars(title = "Wrong share", extend("table" = "claims", "decimals" = 2))]
    pub wrong_share: Option<f64>,
    /// Its interval of 95 %: the bootstrap over units; null of few.
    #[serde(rename = "claims_wrong_share_ci")]
    pub interval: Option<Interval>,
}

impl ClaimTally {
    /// Counts the claims of whole answers, with a verdict or without.
    pub(super) fn count(scored: &[&Scored]) -> Self {
        let mut units: BTreeMap<&str, (u32, u32)> = BTreeMap::new();
        let (mut answers, mut unchecked) = (0, 0);
        let mut sums = [0_u32; 3];
        for one in scored {
            if !matches!(
                one.status,
                AnswerStatus::Verdict(_) | AnswerStatus::Unparsed(_)
            ) {
                continue;
            }
            let Some(counts) = one.claims.known() else {
                unchecked += 1;
                continue;
            };
            answers += 1;
            sums.iter_mut().zip(counts).for_each(|(sum, n)| *sum += n);
            let [right, wrong, _] = counts;
            let (of_wrong, decided) = units.entry(one.unit()).or_default();
            *of_wrong += wrong;
            *decided += right + wrong;
        }
        let decided = units.into_values().filter(|(_, decided)| *decided > 0);
        let counts: Vec<(u32, u32)> = decided.collect();
        let many = u32::try_from(counts.len()).unwrap_or(u32::MAX);
        let share = |part: u32, of: u32| (of > 0).then(|| f64::from(part) / f64::from(of));
        let [right, wrong, open] = sums.map(|sum| (answers > 0).then_some(sum));
        Self {
            answers,
            unchecked,
            right,
            wrong,
            open,
            per_answer: share(sums.iter().sum(), answers),
            wrong_share: share(sums[1], sums[0] + sums[1]),
            interval: shown(ratio_interval(&counts), many),
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::evaluation::tests_scored::{answer, failed};
    use nearmiss_store::ClaimCounts;

    fn with(scenario: &str, claims: Option<[u32; 3]>) -> Scored {
        let mut scored = answer(scenario, "m/x", true, &[]);
        if let Some([right, wrong, open]) = claims {
            scored.claims = ClaimCounts {
                claims_right: Some(right),
                claims_wrong: Some(wrong),
                claims_open: Some(open),
                claims_check: Some(1),
            };
        }
        scored
    }

    #[test]
    fn unchecked_answers_are_told_from_those_without_claims() {
        let all = [
            with("a", Some([6, 2, 1])),
            with("b", Some([0, 0, 0])),
            with("c", None),
            failed("d", "m/x"),
        ];
        let tally = ClaimTally::count(&all.iter().collect::<Vec<_>>());
        assert_eq!((tally.answers, tally.unchecked), (2, 1));
        assert_eq!(
            (tally.right, tally.wrong, tally.open),
            (Some(6), Some(2), Some(1))
        );
        assert_eq!(tally.wrong_share, Some(0.25));
        assert_eq!(tally.per_answer, Some(4.5));
        assert_eq!(tally.interval, None, "one scenario has no interval");
        let none = ClaimTally::count(&[&all[2]]);
        assert_eq!((none.wrong_share, none.per_answer), (None, None));
        assert_eq!(none.right, None);
    }

    #[test]
    fn scenarios_are_drawn_with_all_their_claims() {
        let of = |samples: usize| -> Vec<Scored> {
            (0..40 * samples)
                .map(|i| with(&format!("s{}", i % 40), Some([4, u32::from(i % 4 == 0), 0])))
                .collect()
        };
        let interval = |all: &[Scored]| {
            let tally = ClaimTally::count(&all.iter().collect::<Vec<_>>());
            tally.interval.unwrap()
        };
        let (once, thrice) = (interval(&of(1)), interval(&of(3)));
        assert!((once.low - thrice.low).abs() < 1e-12 && (once.high - thrice.high).abs() < 1e-12);
        let share = 10.0 / 170.0;
        assert!(once.low < share && share < once.high, "{once:?}");
    }
}
