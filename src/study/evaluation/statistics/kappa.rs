//! Agreement of two judges beyond chance.

use serde::Serialize;

use super::{Interval, Z};

/// Cohen's kappa of two judges that say yes or no.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Kappa {
    /// Questions that both answered.
    pub n: u32,
    /// The share of them on which both say the same.
    pub agreement: f64,
    /// 1 for full agreement, 0 for that of chance; `None` if chance alone makes both agree always.
    pub kappa: Option<f64>,
    /// Its interval of 95 %.
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
        let interval = value.map(|kappa| {
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
}
