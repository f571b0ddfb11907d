//! Intervals of proportions, and of all else by resampling scenarios; quantiles; draws that are the same everywhere.

use schemars::JsonSchema;
use serde::Serialize;

use super::Z;
use crate::evaluation::Confusion;

/// An interval of 95 %; for programs the pair of its ends.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
#[serde(into = "(f64, f64)")]
#[schemars(with = "(f64, f64)")]
pub struct Interval {
    /// Its lower end.
    pub low: f64,
    /// Its upper end.
    pub high: f64,
}

impl From<Interval> for (f64, f64) {
    fn from(interval: Interval) -> Self {
        (interval.low, interval.high)
    }
}

/// Observations from which on an interval is shown: of fewer it says little more than that they are few.
pub const FEWEST: u32 = 10;

/// An interval, where at least [`FEWEST`] observations stand behind it.
#[must_use]
pub fn if_enough(interval: Option<Interval>, observations: u32) -> Option<Interval> {
    interval.filter(|_| observations >= FEWEST)
}

/// The Wilson score interval of 95 % of a proportion, `hits` of `all`; nothing of nothing.
///
/// Centre (p + z²/2n) / (1 + z²/n), half width z/(1 + z²/n) · √(p(1 − p)/n + z²/4n²), without continuity correction.
/// E. B. Wilson, "Probable inference, the law of succession, and statistical inference", JASA 22 (1927); recommended
/// for small n by L. D. Brown, T. T. Cai and A. DasGupta, "Interval estimation for a binomial proportion", Statistical
/// Science 16 (2001).
#[must_use]
pub fn wilson(hits: u32, all: u32) -> Option<Interval> {
    if all == 0 || hits > all {
        return None;
    }
    wilson_of_share(f64::from(hits) / f64::from(all), all)
}

/// The same of a share from 0 to 1 that `independent` observations stand behind: of several answers about each of so
/// many scenarios, which are not independent, the scenarios count. The effective sample size is then the number of
/// clusters, its least (L. Kish, "Survey Sampling", 1965, sections 5.4 and 8.2, with an intraclass correlation of 1).
#[must_use]
pub fn wilson_of_share(p: f64, independent: u32) -> Option<Interval> {
    if independent == 0 || !(0.0..=1.0).contains(&p) {
        return None;
    }
    let n = f64::from(independent);
    let shrink = 1.0 + Z * Z / n;
    let centre = (p + Z * Z / (2.0 * n)) / shrink;
    let half = Z / shrink * (p * (1.0 - p) / n + Z * Z / (4.0 * n * n)).sqrt();
    // At both ends the interval ends there exactly; rounding would miss it by a hair.
    Some(Interval {
        low: if p <= 0.0 { 0.0 } else { centre - half },
        high: if p >= 1.0 { 1.0 } else { centre + half },
    })
}

/// The interval of 95 % of a share of answers, from the hits and all answers of each scenario; `None` with fewer than
/// [`super::FEWEST`] scenarios.
///
/// Where a scenario has several answers, which are not independent, the bootstrap over scenarios; else Wilson's.
#[must_use]
pub fn scenario_interval(scenarios: &[(u32, u32)]) -> Option<Interval> {
    let answered = scenarios.iter().filter(|(_, all)| *all > 0);
    let answered: Vec<(u32, u32)> = answered.copied().collect();
    let clustered = answered.iter().any(|(_, all)| *all > 1);
    let drawn = clustered.then(|| ratio_interval(&answered)).flatten();
    let sum = |(hits, all): (u32, u32), one: &(u32, u32)| (hits + one.0, all + one.1);
    let counts = answered.iter().fold((0, 0), sum);
    share_interval(
        drawn,
        counts,
        u32::try_from(answered.len()).unwrap_or(u32::MAX),
    )
}

/// The interval of a share of answers about so many scenarios: the one that was drawn, else Wilson's. The bootstrap
/// cannot vary where all answers are right, or none is; there Wilson's takes the scenarios as observations.
#[must_use]
pub fn share_interval(
    drawn: Option<Interval>,
    (hits, all): (u32, u32),
    scenarios: u32,
) -> Option<Interval> {
    let interval = match drawn {
        Some(interval) if interval.low < interval.high => Some(interval),
        Some(_) => wilson_of_share(f64::from(hits) / f64::from(all), scenarios),
        None => wilson(hits, all),
    };
    if_enough(interval, scenarios)
}

/// How often is drawn anew, where there are up to 10,000 scenarios.
pub const RESAMPLES: usize = 2000;

/// The most scenarios that are drawn, all draws together: of more than 10,000 is drawn less often, as the interval of
/// so many is narrow and needs fewer draws.
const DRAWN: usize = 20_000_000;

/// The least that is drawn anew.
const MIN_RESAMPLES: usize = 200;

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
pub(super) fn resampled(scenarios: usize, mut each: impl FnMut(&mut dyn Iterator<Item = usize>)) {
    if scenarios == 0 {
        return;
    }
    let resamples = (DRAWN / scenarios).clamp(MIN_RESAMPLES, RESAMPLES);
    let mut random = SplitMix(SEED);
    for _ in 0..resamples {
        each(&mut (0..scenarios).map(|_| random.below(scenarios)));
    }
}

pub(super) fn ends(mut found: Vec<f64>) -> Option<Interval> {
    found.sort_by(f64::total_cmp);
    Some(Interval {
        low: of_sorted(&found, 0.025)?,
        high: of_sorted(&found, 0.975)?,
    })
}

/// Where the draws begin: the same data give the same interval and the same test everywhere.
pub const SEED: u64 = 20_250_101;

/// SplitMix64: G. L. Steele, D. Lea and C. H. Flood, "Fast splittable pseudorandom number generators" (2014).
pub struct SplitMix(pub u64);

impl SplitMix {
    /// The next 64 bits.
    pub fn draw(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A number below `n`, by multiplication: its bias is below n / 2⁶⁴.
    pub fn below(&mut self, n: usize) -> usize {
        ((u128::from(self.draw()) * n as u128) >> 64) as usize
    }
}

/// The quantile `q`, from 0 to 1, of some values; nothing of nothing.
///
/// Linear between the order statistics, (n − 1)·q from the least: definition 7 of R. J. Hyndman and Y. Fan, "Sample
/// quantiles in statistical packages", The American Statistician 50 (1996), which numpy uses.
#[must_use]
pub fn quantile(values: &[f64], q: f64) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    of_sorted(&sorted, q)
}

/// The same of values in order.
pub(super) fn of_sorted(sorted: &[f64], q: f64) -> Option<f64> {
    let last = sorted.len().checked_sub(1)?;
    let place = q.clamp(0.0, 1.0) * last as f64;
    let below = place.floor() as usize;
    let above = (below + 1).min(last);
    let part = place - below as f64;
    Some(sorted[below] + part * (sorted[above] - sorted[below]))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::{quantile, *};

    /// statsmodels 0.15, `proportion_confint(k, n, method="wilson")`.
    #[test]
    fn as_statsmodels_has_it() {
        for (hits, all, low, high) in [
            (12, 100, 0.069_994_064_370_194_88, 0.198_120_994_267_114_21),
            (0, 30, 0.0, 0.113_513_393_173_968_8),
            (30, 30, 0.886_486_606_826_031_1, 1.0),
            (26, 30, 0.703_186_733_179_637, 0.946_903_445_159_452_6),
            (1, 1, 0.206_549_314_377_237_4, 1.0),
        ] {
            let found = wilson(hits, all);
            assert!(
                found.is_some_and(|i| (i.low - low).abs() < 1e-12 && (i.high - high).abs() < 1e-12),
                "{hits} of {all}: {found:?}"
            );
        }
        assert_eq!(wilson(0, 0), None);
    }

    #[test]
    fn with_one_answer_each_it_is_wilsons() {
        let single: Vec<(u32, u32)> = (0..40).map(|n| (u32::from(n % 5 != 0), 1)).collect();
        assert_eq!(scenario_interval(&single), wilson(32, 40));
        assert_eq!(scenario_interval(&single[..9]), None, "nine are too few");
        assert_eq!(scenario_interval(&[]), None);
    }

    #[test]
    fn more_answers_about_the_same_scenarios_make_it_no_narrower() {
        let of = |samples: u32| -> Interval {
            let all: Vec<(u32, u32)> = (0..40)
                .map(|n| (samples * u32::from(n % 5 != 0), samples))
                .collect();
            scenario_interval(&all).unwrap()
        };
        assert_eq!(of(2), of(8));
        // By answers it would be half as wide.
        let by_answers = wilson(256, 320).unwrap();
        let width = |interval: Interval| interval.high - interval.low;
        assert!(width(of(8)) > 1.5 * width(by_answers));
        // The bootstrap cannot vary where all are right.
        assert_eq!(scenario_interval(&[(3, 3); 20]), wilson(20, 20));
    }

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

    /// The published test vector of SplitMix64 for the seed 1234567.
    #[test]
    fn the_generator_is_splitmix64() {
        let mut random = SplitMix(1_234_567);
        let first = [(); 3].map(|()| random.draw());
        assert_eq!(
            first,
            [
                6_457_827_717_110_365_317,
                3_203_168_211_198_807_973,
                9_817_491_932_198_370_423
            ]
        );
    }

    /// `numpy.percentile`, numpy 2.4.
    #[test]
    fn as_numpy_has_it() {
        let times = [120.0, 80.0, 300.0, 95.0, 400.0, 1000.0, 60.0];
        let is = |found: Option<f64>, wanted: f64| {
            assert!(
                found.is_some_and(|f| (f - wanted).abs() < 1e-9),
                "{found:?}"
            );
        };
        is(quantile(&times, 0.5), 120.0);
        is(quantile(&times, 0.95), 820.0);
        is(quantile(&[1.0, 2.0, 3.0, 4.0], 0.95), 3.85);
        assert_eq!(quantile(&[], 0.5), None);
    }
}
