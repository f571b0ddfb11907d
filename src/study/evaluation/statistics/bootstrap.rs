//! The bootstrap over scenarios: of shares of answers, and of differences.

use super::Interval;
use super::quantile::of_sorted;
use super::random::{SEED, SplitMix};
use crate::evaluation::Confusion;

/// How often is drawn anew, where there are up to 10,000 scenarios.
pub const RESAMPLES: usize = 2000;

/// The most scenarios that are drawn, all draws together: of more than 10,000 is drawn less often, as the interval of
/// so many is narrow and needs fewer draws.
const DRAWN: usize = 20_000_000;

/// The least that is drawn anew.
const LEAST: usize = 200;

/// Intervals of shares; `None` each if no draw has the share.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ShareIntervals {
    /// Of the share that is right of all asked, with or without a verdict.
    pub right: Option<Interval>,
    /// Of the precision.
    pub precision: Option<Interval>,
    /// Of the recall.
    pub recall: Option<Interval>,
    /// Of the specificity.
    pub specificity: Option<Interval>,
    /// Of the accuracy.
    pub accuracy: Option<Interval>,
    /// Of F1.
    pub f1: Option<Interval>,
}

/// The percentile bootstrap interval of 95 % of F1, see [`share_intervals`].
#[must_use]
pub fn f1_interval(scenarios: &[Confusion]) -> Option<Interval> {
    let [f1] = intervals(scenarios, |counts| [counts.f1()]);
    f1
}

/// The percentile bootstrap intervals of 95 % of shares, from the counts of each scenario.
///
/// [`RESAMPLES`] times as many scenarios as there are, are drawn with replacement, each with all its windows and
/// samples, as answers about the same scenario are not independent; the ends are the quantiles 0.025 and 0.975 of the
/// share of the draws. A draw without the share, as one without a positive scenario has no recall, is left out.
/// B. Efron, "Bootstrap methods: another look at the jackknife", Annals of Statistics 7 (1979); clusters as in A. C.
/// Davison and D. V. Hinkley, "Bootstrap Methods and their Application" (1997), section 3.8.
#[must_use]
pub fn share_intervals(scenarios: &[Confusion]) -> ShareIntervals {
    let [precision, recall, specificity, accuracy, f1] = intervals(scenarios, |counts| {
        [
            counts.precision(),
            counts.recall(),
            counts.specificity(),
            counts.accuracy(),
            counts.f1(),
        ]
    });
    ShareIntervals {
        right: None,
        precision,
        recall,
        specificity,
        accuracy,
        f1,
    }
}

/// The percentile bootstrap intervals of 95 % of any figures of the counts, drawn as in [`share_intervals`].
#[must_use]
pub fn intervals<const N: usize>(
    scenarios: &[Confusion],
    figures: impl Fn(&Confusion) -> [Option<f64>; N],
) -> [Option<Interval>; N] {
    let mut found = [(); N].map(|()| Vec::new());
    resampled(scenarios.len(), |drawn| {
        let mut sum = Confusion::default();
        drawn.for_each(|place| sum.add(&scenarios[place]));
        for (found, figure) in found.iter_mut().zip(figures(&sum)) {
            found.extend(figure);
        }
    });
    found.map(ends)
}

/// The percentile bootstrap interval of 95 % of the mean of a value that each scenario has, drawn as in
/// [`share_intervals`]; `None` of nothing.
#[must_use]
pub fn mean_interval(values: &[f64]) -> Option<Interval> {
    let mut found = Vec::new();
    resampled(values.len(), |drawn| {
        let sum: f64 = drawn.map(|place| values[place]).sum();
        found.push(sum / values.len() as f64);
    });
    ends(found)
}

/// The percentile bootstrap interval of 95 % of a share, from its hits and all answers of each scenario, drawn as in
/// [`share_intervals`]; `None` of nothing.
#[must_use]
pub fn ratio_interval(scenarios: &[(u32, u32)]) -> Option<Interval> {
    let mut found = Vec::new();
    resampled(scenarios.len(), |drawn| {
        let sum = drawn.map(|place| scenarios[place]);
        let (hits, all) = sum.fold((0_u64, 0_u64), |(hits, all), (h, a)| {
            (hits + u64::from(h), all + u64::from(a))
        });
        found.extend((all > 0).then(|| hits as f64 / all as f64));
    });
    ends(found)
}

/// Draws as many places as there are, again and again.
fn resampled(scenarios: usize, mut each: impl FnMut(&mut dyn Iterator<Item = usize>)) {
    if scenarios == 0 {
        return;
    }
    let resamples = (DRAWN / scenarios).clamp(LEAST, RESAMPLES);
    let mut random = SplitMix(SEED);
    for _ in 0..resamples {
        each(&mut (0..scenarios).map(|_| random.below(scenarios)));
    }
}

fn ends(mut found: Vec<f64>) -> Option<Interval> {
    found.sort_by(f64::total_cmp);
    Some(Interval {
        low: of_sorted(&found, 0.025)?,
        high: of_sorted(&found, 0.975)?,
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn counts(said: bool, truth: bool, times: u32) -> Confusion {
        let mut counts = Confusion::default();
        (0..times).for_each(|_| counts.count(said, truth));
        counts
    }

    /// numpy 2.4, 200,000 resamples of 26 TP, 4 FN, 5 FP and 24 TN with `default_rng(0)`:
    /// `np.percentile(f1, [2.5, 97.5])` = 0.744186, 0.936170.
    #[test]
    fn as_numpy_has_it_but_for_the_draws() {
        let one = |said, truth, times| vec![counts(said, truth, 1); times];
        let all = [
            one(true, true, 26),
            one(false, true, 4),
            one(true, false, 5),
            one(false, false, 24),
        ]
        .concat();
        let found = f1_interval(&all).unwrap();
        assert!((found.low - 0.744_186).abs() < 0.015, "{found:?}");
        assert!((found.high - 0.936_170).abs() < 0.015, "{found:?}");
        assert_eq!(f1_interval(&all).unwrap(), found, "the draws are the same");
    }

    /// The same draws in numpy: accuracy 0.847458, `np.percentile` of it 0.745763 and 0.932203; the difference of
    /// values 0, ½ and 1 is bounded by them.
    #[test]
    fn shares_and_means_have_intervals_of_the_same_draws() {
        let one = |said, truth, times| vec![counts(said, truth, 1); times];
        let all = [
            one(true, true, 26),
            one(false, true, 4),
            one(true, false, 5),
            one(false, false, 24),
        ]
        .concat();
        let found = share_intervals(&all);
        assert_eq!(found.f1, f1_interval(&all));
        let accuracy = found.accuracy.unwrap();
        assert!((accuracy.low - 0.745_763).abs() < 0.02, "{accuracy:?}");
        assert!((accuracy.high - 0.932_203).abs() < 0.02, "{accuracy:?}");
        let right: Vec<f64> = (0..59).map(|i| f64::from(u8::from(i < 50))).collect();
        let mean = mean_interval(&right).unwrap();
        assert!((mean.low - accuracy.low).abs() < 0.02, "{mean:?}");
        assert_eq!(mean_interval(&[]), None);
        let hits: Vec<(u32, u32)> = right.iter().map(|right| (*right as u32, 1)).collect();
        assert_eq!(ratio_interval(&hits), Some(mean));
        assert_eq!(share_intervals(&[]), ShareIntervals::default());
    }

    #[test]
    fn samples_of_a_scenario_are_drawn_together() {
        let single: Vec<_> = (0..60).map(|i| counts(i % 5 != 0, i % 2 == 0, 1)).collect();
        let tripled: Vec<_> = (0..60).map(|i| counts(i % 5 != 0, i % 2 == 0, 3)).collect();
        // Three equal samples say nothing more than one.
        assert_eq!(f1_interval(&single), f1_interval(&tripled));
        assert_eq!(f1_interval(&[]), None);
        assert_eq!(f1_interval(&[counts(true, false, 1)]), None);
    }
}
