//! Tests of two configurations on the same scenarios: permutation and McNemar's, and correction for many such tests.

use schemars::JsonSchema;
use serde::Serialize;

use super::interval::{SEED, SplitMix, mean_interval};
use super::{Interval, Z};

/// Random draws of signs where not all can be tried.
pub const DRAWS: usize = 10_000;

/// Up to this many scenarios that differ, all signs are tried: 2¹³ are fewer than [`DRAWS`].
pub const EXACT_UP_TO: usize = 13;

/// The most signs that are drawn, all draws together, and the fewest draws of very many scenarios.
const DRAWN: usize = 200_000_000;
const MIN_DRAWS: usize = 1000;

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
    pub fn if_enough(self, scenarios: u32) -> Self {
        let interval = super::if_enough(self.interval, scenarios);
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
    let draws = (DRAWN / differences.len()).clamp(MIN_DRAWS, DRAWS);
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

/// The two-sided p value of finding `hits` in `n` that were drawn without replacement from `all` with `marked` hits;
/// nothing where `n` is more than `all`, or `marked` is. It is 0 where that cannot be at all.
///
/// The sum of P(X = i) ≤ P(X = `hits`) over i, X hypergeometric: P(X = i) = C(marked, i)·C(all − marked, n − i) /
/// C(all, n); the two-sided rule of R. A. Fisher's exact test, J. O. Irwin, Metron 12 (1935).
#[must_use]
pub fn fisher_p_value(hits: u32, n: u32, marked: u32, all: u32) -> Option<f64> {
    if n > all || marked > all || hits > n {
        return None;
    }
    let log = |i: u32| choose(marked, i) + choose(all - marked, n - i) - choose(all, n);
    let possible = n.saturating_sub(all - marked)..=n.min(marked);
    if !possible.contains(&hits) {
        return Some(0.0);
    }
    // Equal probabilities may differ by rounding.
    let limit = log(hits) + 1e-9;
    let sum: f64 = possible
        .map(log)
        .filter(|l| *l <= limit)
        .map(f64::exp)
        .sum();
    Some(sum.min(1.0))
}

/// The logarithm of a binomial coefficient.
fn choose(n: u32, k: u32) -> f64 {
    let factorial = |n: u32| libm::lgamma(f64::from(n) + 1.0);
    factorial(n) - factorial(k) - factorial(n - k)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::{fisher_p_value, *};

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

    /// scipy 1.17, `hypergeom(100, marked, 30).pmf` summed over what is not likelier.
    #[test]
    fn as_scipy_has_it() {
        for (hits, marked, p) in [
            (10, 45, 0.187_754_991_189_258_26),
            (26, 84, 0.770_882_226_687_656_6),
            (1, 2, 0.512_121_212_121_212_2),
            (3, 4, 0.079_466_238_229_124_85),
            (20, 42, 0.00174751538667538),
            (5, 4, 0.0),
        ] {
            let found = fisher_p_value(hits, 30, marked, 100);
            assert!(
                found.is_some_and(|f| (f - p).abs() < 1e-9),
                "{hits} of {marked}: {found:?}"
            );
        }
        assert_eq!(fisher_p_value(1, 30, 1, 20), None);
    }
}
