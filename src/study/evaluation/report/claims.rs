//! Claims of answers about obstacles: how many are right, wrong and open.

use std::collections::BTreeMap;

use serde_json::{Map, Value, json};

use super::super::statistics::{Interval, ratio_interval, shown};
use super::super::{AnswerStatus, Scored};

/// Claims of the answers of a cell.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ClaimTally {
    /// Answers whose claims were checked.
    pub answers: u32,
    /// Answers that were not checked, as their scenario was not at hand.
    pub unchecked: u32,
    /// Claims that hold.
    pub right: u32,
    /// Claims that do not.
    pub wrong: u32,
    /// Claims that cannot be decided.
    pub open: u32,
    /// The interval of [`Self::wrong_share`], 95 %: the bootstrap over units; `None` of few.
    pub interval: Option<Interval>,
}

impl ClaimTally {
    /// Counts the claims of whole answers, with a verdict or without.
    pub(super) fn count(scored: &[&Scored]) -> Self {
        let mut tally = Self::default();
        let mut units: BTreeMap<&str, (u32, u32)> = BTreeMap::new();
        for one in scored {
            if !matches!(
                one.status,
                AnswerStatus::Verdict(_) | AnswerStatus::Unparsed(_)
            ) {
                continue;
            }
            let Some([right, wrong, open]) = one.claims.known() else {
                tally.unchecked += 1;
                continue;
            };
            tally.answers += 1;
            tally.right += right;
            tally.wrong += wrong;
            tally.open += open;
            let (of_wrong, decided) = units.entry(one.unit()).or_default();
            *of_wrong += wrong;
            *decided += right + wrong;
        }
        let decided = units.into_values().filter(|(_, decided)| *decided > 0);
        let counts: Vec<(u32, u32)> = decided.collect();
        let many = u32::try_from(counts.len()).unwrap_or(u32::MAX);
        tally.interval = shown(ratio_interval(&counts), many);
        tally
    }

    /// Right, wrong and open claims of an answer, on average.
    #[must_use]
    pub fn per_answer(&self) -> Option<f64> {
        let all = self.right + self.wrong + self.open;
        (self.answers > 0).then(|| f64::from(all) / f64::from(self.answers))
    }

    /// The share of wrong claims of those that are right or wrong.
    #[must_use]
    pub fn wrong_share(&self) -> Option<f64> {
        let decided = self.right + self.wrong;
        (decided > 0).then(|| f64::from(self.wrong) / f64::from(decided))
    }

    /// The fields of a cell in JSON.
    pub(super) fn fields(&self) -> Map<String, Value> {
        let known = self.answers > 0;
        let ends = self.interval.map(|i| [i.low, i.high]);
        let fields = [
            ("claims_of", json!(self.answers)),
            ("claims_unchecked", json!(self.unchecked)),
            ("claims_right", json!(known.then_some(self.right))),
            ("claims_wrong", json!(known.then_some(self.wrong))),
            ("claims_open", json!(known.then_some(self.open))),
            ("claims_per_answer", json!(self.per_answer())),
            ("claims_wrong_share", json!(self.wrong_share())),
            ("claims_wrong_share_ci", json!(ends)),
        ];
        fields
            .map(|(name, value)| (name.to_string(), value))
            .into_iter()
            .collect()
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
        assert_eq!((tally.right, tally.wrong, tally.open), (6, 2, 1));
        assert_eq!(tally.wrong_share(), Some(0.25));
        assert_eq!(tally.per_answer(), Some(4.5));
        assert_eq!(tally.interval, None, "one scenario has no interval");
        let none = ClaimTally::count(&[&all[2]]);
        assert_eq!((none.wrong_share(), none.per_answer()), (None, None));
        assert!(none.fields()["claims_right"].is_null());
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
