//! Confidence intervals of proportions.

use schemars::JsonSchema;
use serde::Serialize;

use super::Z;

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
pub fn shown(interval: Option<Interval>, observations: u32) -> Option<Interval> {
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

#[cfg(test)]
mod tests {
    use super::*;

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
}
