//! Gains of several candidates over one base, with intervals and p values that also hold for the best of them.

use serde::Serialize;

use super::Interval;
use super::interval::{SEED, SplitMix, quantile};
use crate::evaluation::Confusion;

/// Draws of scenarios, and draws of exchanges.
const DRAWS: usize = 2000;

/// By how much a candidate is better than the base, on the questions that both answered.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Gain {
    /// The measure of the candidate minus that of the base.
    pub difference: f64,
    /// Its simultaneous interval of 95 %: all candidates together are within theirs in 95 % of studies, so the best one
    /// is, too.
    pub interval: Interval,
    /// The two-sided p value of no difference, corrected for the number of candidates.
    pub p: f64,
}

impl Gain {
    /// Whether the candidate is better: its interval is above 0, and chance makes such a best one in fewer than 5 % of
    /// studies.
    #[must_use]
    pub fn is_found(&self) -> bool {
        self.interval.low > 0.0 && self.p < LEVEL
    }
}

/// The level of the test.
const LEVEL: f64 = 0.05;

/// The counts of one scenario: of the base, and of the candidate.
pub type PairedCounts = [Confusion; 2];

/// The gains of candidates, each with its counts by scenario, in the same order of scenarios; `None` for one whose
/// measure has no value.
///
/// Interval: scenarios are drawn with replacement, d* is the difference of a draw and s its standard deviation over the
/// draws. d ± q·s, where q is the quantile 0.95 over draws of the largest |d* − d|/s of all candidates (single-step
/// max-T). With s times √(n/(n − 1)) for n scenarios.
/// p: base and candidates exchange their answers on a random half of the scenarios; the share of exchanges whose largest
/// |d|/s is as large as the candidate's, (1 + b)/(1 + m).
/// H. White, "A reality check for data snooping", Econometrica 68 (2000); J. P. Romano and M. Wolf, "Exact and
/// approximate stepdown methods for multiple hypothesis testing", JASA 100 (2005).
#[must_use]
pub fn gains(
    candidates: &[Vec<PairedCounts>],
    measure: impl Fn(&Confusion) -> Option<f64>,
) -> Vec<Option<Gain>> {
    let scenarios = candidates.first().map_or(0, Vec::len);
    if scenarios == 0 || candidates.iter().any(|one| one.len() != scenarios) {
        return vec![None; candidates.len()];
    }
    let every = || 0..scenarios;
    let kept = vec![false; scenarios];
    let found: Vec<Option<f64>> = candidates
        .iter()
        .map(|one| difference(one, every(), &kept, &measure))
        .collect();
    let mut random = SplitMix(SEED);
    let drawn: Vec<Vec<Option<f64>>> = (0..DRAWS)
        .map(|_| {
            let places: Vec<usize> = every().map(|_| random.below(scenarios)).collect();
            let of = |one| difference(one, places.iter().copied(), &kept, &measure);
            candidates.iter().map(|one| of(one)).collect()
        })
        .collect();
    let deviation: Vec<f64> = (0..candidates.len())
        .map(|k| deviation(drawn.iter().filter_map(|draw| draw[k]), scenarios))
        .collect();
    let largest = |values: &dyn Fn(usize) -> Option<f64>| {
        let all = (0..candidates.len()).filter_map(|k| Some(values(k)?.abs() / deviation[k]));
        all.fold(0.0, f64::max)
    };
    let farthest: Vec<f64> = drawn
        .iter()
        .map(|draw| largest(&|k| Some(draw[k]? - found[k]?)))
        .collect();
    let width = quantile(&farthest, 0.95).unwrap_or(0.0);
    let exchanged: Vec<f64> = (0..DRAWS)
        .map(|_| {
            let swapped: Vec<bool> = every().map(|_| random.draw() & 1 == 1).collect();
            largest(&|k| difference(&candidates[k], every(), &swapped, &measure))
        })
        .collect();
    let gain = |k: usize| {
        let difference = found[k]?;
        let half = if exchanges_nothing(&candidates[k]) {
            0.0
        } else {
            width * deviation[k]
        };
        let own = difference.abs() / deviation[k] - 1e-9;
        let as_large = exchanged.iter().filter(|far| **far >= own).count();
        Some(Gain {
            difference,
            interval: Interval {
                low: (difference - half).max(-1.0),
                high: (difference + half).min(1.0),
            },
            p: (1 + as_large) as f64 / (1 + DRAWS) as f64,
        })
    };
    (0..candidates.len()).map(gain).collect()
}

/// The difference of the measure over these scenarios, with the two sides exchanged where `swapped`.
fn difference(
    one: &[PairedCounts],
    places: impl Iterator<Item = usize>,
    swapped: &[bool],
    measure: &impl Fn(&Confusion) -> Option<f64>,
) -> Option<f64> {
    let mut sums = [Confusion::default(); 2];
    for place in places {
        let [base, candidate] = &one[place];
        let (first, second) = if swapped[place] {
            (candidate, base)
        } else {
            (base, candidate)
        };
        sums[0].add(first);
        sums[1].add(second);
    }
    Some(measure(&sums[1])? - measure(&sums[0])?)
}

/// Whether both sides say the same about every scenario.
fn exchanges_nothing(one: &[PairedCounts]) -> bool {
    one.iter().all(|[base, candidate]| base == candidate)
}

/// The standard deviation, at least half a scenario: draws that are all alike are no proof.
fn deviation(values: impl Iterator<Item = f64>, scenarios: usize) -> f64 {
    let values: Vec<f64> = values.collect();
    let n = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / n;
    let square = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n;
    let all = scenarios as f64;
    let small = (all / (all - 1.0).max(1.0)).sqrt();
    (square.sqrt() * small).max(0.5 / all)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn counts(said: bool, truth: bool) -> Confusion {
        let mut counts = Confusion::default();
        counts.count(said, truth);
        counts
    }

    /// Scenarios of both truths in turn, and whether base and candidate are right.
    fn pairs(right: impl Iterator<Item = (bool, bool)>) -> Vec<PairedCounts> {
        let of = |(place, (base, candidate)): (usize, (bool, bool))| {
            let truth = place % 2 == 0;
            [base, candidate].map(|right| counts(right == truth, truth))
        };
        right.enumerate().map(of).collect()
    }

    #[test]
    fn the_same_answers_are_no_gain() {
        let same = pairs((0..30).map(|i| (i % 3 != 0, i % 3 != 0)));
        let found = gains(&[same.clone(), same], Confusion::f1);
        for gain in found {
            let gain = gain.unwrap();
            let interval = (gain.interval.low, gain.interval.high);
            assert_eq!((gain.difference, interval, gain.p), (0.0, (0.0, 0.0), 1.0));
            assert!(!gain.is_found());
        }
        assert_eq!(gains(&[], Confusion::f1), []);
        assert_eq!(gains(&[Vec::new()], Confusion::f1), [None]);
    }

    /// By hand: of 40 scenarios, half of them dangerous, the base is wrong on ten and the candidate on none: F1 of the
    /// base is 2·15/(2·15 + 5 + 5) = 0.75.
    #[test]
    fn a_large_gain_is_found_among_candidates_without_one() {
        let better = pairs((0..40).map(|i| (i >= 10, true)));
        let same = pairs((0..40).map(|i| (i >= 10, i >= 10)));
        let found = gains(&[same, better.clone()], Confusion::f1);
        let gain = found[1].unwrap();
        assert!((gain.difference - 0.25).abs() < 1e-12, "{gain:?}");
        assert!(
            gain.interval.low > 0.08 && gain.interval.high < 0.42,
            "{gain:?}"
        );
        assert!(gain.is_found() && !found[0].unwrap().is_found());
        // Numpy: the standard deviation of the accuracy of the same draws is √(0.25·0.75/40) = 0.0685.
        let alone = gains(&[better], Confusion::accuracy)[0].unwrap();
        let half = (alone.interval.high - alone.interval.low) / 2.0;
        assert!((half - 1.96 * 0.0685).abs() < 0.012, "{alone:?}");
        // Four of twelve: the exact sign test has p = 2/2⁴.
        let few = pairs((0..12).map(|i| (i >= 4, true)));
        let few = gains(&[few], Confusion::accuracy)[0].unwrap();
        assert!((few.p - 0.125).abs() < 0.03 && !few.is_found(), "{few:?}");
    }

    /// Studies of 40 scenarios in which all templates are right in 70 % of their answers by chance, and those in which
    /// one of eight is right in 97 %.
    #[test]
    fn the_best_of_many_by_chance_is_rarely_a_gain_and_a_better_one_mostly() {
        let mut random = SplitMix(11);
        let mut study = |best: usize| {
            let mut right =
                |percent| -> Vec<bool> { (0..40).map(|_| random.below(100) < percent).collect() };
            let base = right(70);
            let percents = [best, 70, 70, 70, 70, 70, 70, 70];
            let candidates = percents.map(|percent| {
                let answers = right(percent);
                pairs(base.iter().copied().zip(answers))
            });
            gains(&candidates, Confusion::f1)
        };
        let called = (0..100)
            .filter(|_| study(70).iter().flatten().any(Gain::is_found))
            .count();
        assert!(called <= 9, "{called} of 100");
        let found = (0..50)
            .filter(|_| study(97)[0].is_some_and(|gain| gain.is_found()))
            .count();
        println!("by chance {called} of 100, better {found} of 50");
        assert!(found >= 25, "{found} of 50");
    }
}
