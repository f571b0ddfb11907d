//! McNemar's test of two configurations on the same scenarios, and correction for many such tests.

use schemars::JsonSchema;
use serde::Serialize;

/// Below this many discordant scenarios the test is exact.
pub const EXACT_BELOW: u32 = 25;

/// Two ways on the same scenarios, and whether one is right more often.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct McNemar {
    /// Scenarios that the first alone is right about.
    pub only_first: u32,
    /// Scenarios that the second alone is right about.
    pub only_second: u32,
    /// The chi-square statistic; null if the test is exact.
    pub chi_square: Option<f64>,
    /// The two-sided p value of McNemar's test.
    #[serde(rename = "p_mcnemar")]
    pub p: f64,
}

impl McNemar {
    /// The test of scenarios that one of two ways alone is right about, b and c.
    ///
    /// Below [`EXACT_BELOW`] such scenarios the two-sided binomial test, 2·P(X ≤ min(b, c)) with X from
    /// Binomial(b + c, ½), at most 1; else (|b − c| − 1)²/(b + c) against chi-square with one degree of freedom.
    /// Q. McNemar, "Note on the sampling error of the difference between correlated proportions or percentages",
    /// Psychometrika 12 (1947); the correction is of A. L. Edwards, Psychometrika 13 (1948).
    #[must_use]
    pub fn from_discordant(only_first: u32, only_second: u32) -> Self {
        let all = only_first + only_second;
        let (chi_square, p) = if all < EXACT_BELOW {
            (None, exact(only_first.min(only_second), all))
        } else {
            let apart = (f64::from(only_first.abs_diff(only_second)) - 1.0).max(0.0);
            let statistic = apart * apart / f64::from(all);
            // The upper tail of chi-square with one degree of freedom.
            (Some(statistic), libm::erfc((statistic / 2.0).sqrt()))
        };
        Self {
            only_first,
            only_second,
            chi_square,
            p,
        }
    }
}

fn exact(least: u32, all: u32) -> f64 {
    let mut term = 0.5_f64.powi(i32::try_from(all).unwrap_or(i32::MAX));
    let mut sum = 0.0;
    for i in 0..=least {
        sum += term;
        term *= f64::from(all - i) / f64::from(i + 1);
    }
    (2.0 * sum).min(1.0)
}

/// p values of several tests as they are to be read together, in their order.
///
/// The k-th smallest of m is multiplied by m − k + 1, never below the one before it, at most 1. S. Holm, "A simple
/// sequentially rejective multiple test procedure", Scandinavian Journal of Statistics 6 (1979).
#[must_use]
pub fn holm(p: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..p.len()).collect();
    order.sort_by(|&a, &b| p[a].total_cmp(&p[b]));
    let mut adjusted = vec![0.0; p.len()];
    let mut before = 0.0_f64;
    for (place, &i) in order.iter().enumerate() {
        before = before.max((p[i] * (p.len() - place) as f64).min(1.0));
        adjusted[i] = before;
    }
    adjusted
}

#[cfg(test)]
mod tests {
    use super::*;

    /// statsmodels 0.15: `mcnemar([[5, b], [c, 7]], exact=True)` below 25, else `exact=False, correction=True`.
    #[test]
    fn as_statsmodels_has_it() {
        for (b, c, chi_square, p) in [
            (1, 8, None, 0.039_062_5),
            (0, 5, None, 0.062_5),
            (3, 3, None, 1.0),
            (12, 13, Some(0.0), 1.0),
            (10, 25, Some(5.6), 0.017_960_477_526_078_79),
            (
                40,
                12,
                Some(14.019_230_769_230_77),
                0.000_180_950_490_437_567_56,
            ),
        ] {
            let found = McNemar::from_discordant(b, c);
            assert!((found.p - p).abs() < 1e-12, "{b} {c}: {found:?}");
            let near = match (found.chi_square, chi_square) {
                (Some(a), Some(b)) => (a - b).abs() < 1e-9,
                (a, b) => a == b,
            };
            assert!(near, "{b} {c}: {found:?}");
        }
        assert_eq!(McNemar::from_discordant(0, 0).p, 1.0);
    }

    /// statsmodels 0.15, `multipletests(p, method="holm")`.
    #[test]
    fn holm_as_statsmodels_has_it() {
        let near = |found: Vec<f64>, wanted: &[f64]| {
            let mut pairs = found.iter().zip(wanted);
            assert!(pairs.all(|(a, b)| (a - b).abs() < 1e-12), "{found:?}");
        };
        near(holm(&[0.01, 0.04, 0.03, 0.005]), &[0.03, 0.06, 0.06, 0.02]);
        near(holm(&[0.5, 0.4, 0.9]), &[1.0, 1.0, 1.0]);
    }
}
