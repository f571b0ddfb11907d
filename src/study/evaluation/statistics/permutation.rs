//! The paired permutation test of two ways by scenario, and what difference it could have found.

use schemars::JsonSchema;
use serde::Serialize;

use super::bootstrap::mean_interval;
use super::random::{SEED, SplitMix};
use super::{Interval, Z};

/// Random draws of signs where not all can be tried.
pub const DRAWS: usize = 10_000;

/// Up to this many scenarios that differ, all signs are tried: 2¹³ are fewer than [`DRAWS`].
pub const EXACT_UP_TO: usize = 13;

/// The most signs that are drawn, all draws together, and the fewest draws of very many scenarios.
const DRAWN: usize = 200_000_000;
const LEAST: usize = 1000;

/// The quantile of the standard normal distribution for a power of 80 %.
const Z_POWER: f64 = 0.841_621_233_572_914_2;

/// Two ways on the same scenarios, and by how much the first is right more often.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct PairedTest {
    /// The mean difference of correctness over scenarios, first minus second.
    #[schemars(title = "Difference", extend("decimals" = 2))]
    pub difference: f64,
    /// Its bootstrap interval of 95 %, over scenarios.
    #[serde(rename = "difference_ci")]
    pub interval: Option<Interval>,
    /// The difference that would be found with a power of 80 % at a level of 5 %; null if no scenario differs.
    #[schemars(title = "Detectable", extend("decimals" = 2))]
    pub detectable: Option<f64>,
    /// The two-sided p value.
    #[schemars(title = "p", extend("decimals" = 3, "bounded" = true))]
    pub p: f64,
    /// Whether all signs were tried.
    pub exact: bool,
}

impl PairedTest {
    /// The same, whose interval is shown only where enough scenarios stand behind it.
    #[must_use]
    pub fn shown(self, scenarios: u32) -> Self {
        let interval = super::shown(self.interval, scenarios);
        Self { interval, ..self }
    }

    /// The test of the differences of scenarios: each the mean correctness of the first way over the scenario's windows
    /// and samples, minus that of the second; `None` of none.
    ///
    /// Where both ways are equally good, each difference is as likely as its negative: p is the share of assignments of
    /// signs whose sum is as far from 0 as the one that was found. All 2ⁿ are tried for up to [`EXACT_UP_TO`]
    /// differences other than 0, else [`DRAWS`] random ones, with the one that was found among them: p = (1 + b)/(1 + m).
    /// R. A. Fisher, "The Design of Experiments" (1935), section 21; B. Phipson and G. K. Smyth, "Permutation p-values
    /// should never be zero", Statistical Applications in Genetics and Molecular Biology 9 (2010).
    ///
    /// The detectable difference is (z₀.₉₇₅ + z₀.₈)·√(mean d²/n): of one sample, mean d² is the share of discordant
    /// scenarios. R. J. Connor, "Sample size for testing differences in proportions for the paired-sample design",
    /// Biometrics 43 (1987); E. Miller, "Adding error bars to evals", arXiv:2411.00640 (2024).
    #[must_use]
    pub fn of_differences(differences: &[f64]) -> Option<Self> {
        if differences.is_empty() {
            return None;
        }
        let n = differences.len() as f64;
        let discordant: Vec<f64> = differences.iter().copied().filter(|d| *d != 0.0).collect();
        let exact = discordant.len() <= EXACT_UP_TO;
        let p = if exact {
            all_signs(&discordant)
        } else {
            drawn_signs(&discordant)
        };
        let squares: f64 = differences.iter().map(|d| d * d).sum();
        let detectable = (Z + Z_POWER) * (squares / n / n).sqrt();
        Some(Self {
            difference: differences.iter().sum::<f64>() / n,
            interval: mean_interval(differences),
            p,
            exact,
            detectable: (!discordant.is_empty()).then_some(detectable),
        })
    }
}

/// Sums that differ by rounding alone are equal.
fn limit(differences: &[f64]) -> f64 {
    differences.iter().sum::<f64>().abs() - 1e-9
}

fn all_signs(differences: &[f64]) -> f64 {
    let (all, limit) = (1_u32 << differences.len(), limit(differences));
    let sum = |signs: u32| -> f64 {
        let signed = differences.iter().enumerate();
        signed
            .map(|(i, d)| if signs >> i & 1 == 1 { -d } else { *d })
            .sum()
    };
    let as_far = (0..all).filter(|signs| sum(*signs).abs() >= limit).count();
    as_far as f64 / f64::from(all)
}

fn drawn_signs(differences: &[f64]) -> f64 {
    let limit = limit(differences);
    let draws = (DRAWN / differences.len()).clamp(LEAST, DRAWS);
    let mut random = SplitMix(SEED);
    let mut as_far = 0;
    for _ in 0..draws {
        let mut sum = 0.0;
        for part in differences.chunks(64) {
            let mut signs = random.draw();
            for d in part {
                sum += if signs & 1 == 1 { -d } else { *d };
                signs >>= 1;
            }
        }
        as_far += usize::from(sum.abs() >= limit);
    }
    (1 + as_far) as f64 / (1 + draws) as f64
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn p(differences: &[f64]) -> f64 {
        PairedTest::of_differences(differences).unwrap().p
    }

    /// scipy 1.17, `permutation_test((d,), np.mean, permutation_type="samples")`: exact below 2^13; with one sample a
    /// scenario it is the exact test of McNemar.
    #[test]
    fn few_scenarios_are_tested_exactly() {
        assert_eq!(p(&[1.0; 5]), 0.0625);
        assert_eq!(p(&[0.0; 5]), 1.0);
        let one_against_eight = [vec![1.0; 8], vec![-1.0]].concat();
        assert!((p(&one_against_eight) - 0.039_062_5).abs() < 1e-12);
        // 0.5, 0.5, 1: sums 2, 1, 1, 0, 0, -1, -1, -2; two of eight are as far as 2.
        assert_eq!(p(&[0.5, 0.5, 1.0]), 0.25);
        assert_eq!(p(&[0.5, 0.5, -1.0]), 1.0);
        assert_eq!(PairedTest::of_differences(&[]), None);
    }

    /// `binomtest(10, 35).p` is 0.0167; the draws of signs are near it.
    #[test]
    fn many_scenarios_are_tested_by_draws() {
        let many = [vec![1.0; 10], vec![-1.0; 25]].concat();
        let found = PairedTest::of_differences(&many).unwrap();
        assert!(!found.exact);
        assert!((found.p - 0.0167).abs() < 0.004, "{found:?}");
        assert_eq!(PairedTest::of_differences(&many), Some(found));
        assert!(found.interval.is_some_and(|i| i.high < 0.0), "{found:?}");
        // 35 of 35 are discordant: 2.8016 · √(1/35).
        assert!((found.detectable.unwrap() - 0.473_554).abs() < 1e-4);
    }

    /// How often a difference is found at 5 %, of batches of 42 scenarios with two samples each.
    fn found(first: f64, second: f64, batches: u32) -> f64 {
        let mut random = SplitMix(7);
        let mut right = |share: f64| (random.draw() >> 11) as f64 / ((1_u64 << 53) as f64) < share;
        let mut mean = |share| (u8::from(right(share)) + u8::from(right(share))) as f64 / 2.0;
        let significant = (0..batches).filter(|_| {
            let differences: Vec<f64> = (0..42).map(|_| mean(first) - mean(second)).collect();
            p(&differences) < 0.05
        });
        significant.count() as f64 / f64::from(batches)
    }

    fn batches() -> u32 {
        let asked = std::env::var("NEARMISS_SIMULATED_BATCHES");
        asked.ok().and_then(|n| n.parse().ok()).unwrap_or(200)
    }

    #[test]
    fn equal_models_seldom_differ() {
        let n = batches();
        // Three standard errors of 5 %.
        let most = 0.05 + 3.0 * (0.05 * 0.95 / f64::from(n)).sqrt();
        let share = found(0.8, 0.8, n);
        assert!(share <= most, "{share} of {n}");
    }

    #[test]
    fn eight_against_thirty_per_cent_of_noise_are_told_apart() {
        let (n, share) = (batches(), found(0.92, 0.70, batches()));
        assert!(share >= 0.8, "{share} of {n}");
    }
}
