//! Agreement of persons who choose among several categories.

use std::collections::BTreeMap;

/// Cohen's kappa of two persons, from their choices about the same things; `None` without any, or where chance alone
/// makes both agree always.
///
/// κ = (p₀ − pₑ)/(1 − pₑ) with the observed agreement p₀ and that of chance pₑ, from each person's own shares. J. Cohen,
/// "A coefficient of agreement for nominal scales", Educational and Psychological Measurement 20 (1960).
#[must_use]
pub fn cohen<C: Ord>(choices: &[(C, C)]) -> Option<f64> {
    let n = choices.len() as f64;
    let mut shares: BTreeMap<&C, [f64; 2]> = BTreeMap::new();
    for (first, second) in choices {
        shares.entry(first).or_default()[0] += 1.0 / n;
        shares.entry(second).or_default()[1] += 1.0 / n;
    }
    let same = choices.iter().filter(|(a, b)| a == b).count() as f64 / n;
    let chance: f64 = shares.values().map(|[a, b]| a * b).sum();
    beyond_chance(same, chance)
}

/// Fleiss' kappa of several persons, from the choices about each thing; things with one choice say nothing and are left
/// out. `None` as for [`cohen`].
///
/// The observed agreement is the mean over things of the share of pairs of choices that agree, that of chance Σ pⱼ² of
/// the shares of all choices. J. L. Fleiss, "Measuring nominal scale agreement among many raters", Psychological
/// Bulletin 76 (1971); things may have different numbers of choices.
#[must_use]
pub fn fleiss<C: Ord>(things: &[Vec<C>]) -> Option<f64> {
    let (mut observed, mut n, mut all) = (0.0, 0.0, 0.0);
    let mut totals: BTreeMap<&C, f64> = BTreeMap::new();
    for choices in things.iter().filter(|choices| choices.len() > 1) {
        let mut counts: BTreeMap<&C, f64> = BTreeMap::new();
        for choice in choices {
            *counts.entry(choice).or_default() += 1.0;
            *totals.entry(choice).or_default() += 1.0;
        }
        let m = choices.len() as f64;
        observed += counts.values().map(|k| k * (k - 1.0)).sum::<f64>() / (m * (m - 1.0));
        n += 1.0;
        all += m;
    }
    let chance: f64 = totals.values().map(|k| (k / all).powi(2)).sum();
    beyond_chance(observed / n, chance)
}

fn beyond_chance(observed: f64, chance: f64) -> Option<f64> {
    // Of nothing both are not numbers.
    (observed.is_finite() && chance < 1.0 - 1e-12).then(|| (observed - chance) / (1.0 - chance))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(found: Option<f64>, wanted: f64) {
        assert!(
            found.is_some_and(|k| (k - wanted).abs() < 1e-3),
            "{found:?}"
        );
    }

    /// scikit-learn 1.7, `cohen_kappa_score([0,0,1,2,2,1], [0,1,1,2,2,0])` = 0.5.
    #[test]
    fn two_persons_as_scikit_learn_has_it() {
        near(
            cohen(&[(0, 0), (0, 1), (1, 1), (2, 2), (2, 2), (1, 0)]),
            0.5,
        );
        assert_eq!(cohen::<u8>(&[]), None);
        assert_eq!(cohen(&[(1, 1), (1, 1)]), None);
    }

    /// The example of Wikipedia's page on Fleiss' kappa: ten things, 14 raters, κ = 0.210.
    #[test]
    fn several_persons_as_published() {
        let counts = [
            [0, 0, 0, 0, 14],
            [0, 2, 6, 4, 2],
            [0, 0, 3, 5, 6],
            [0, 3, 9, 2, 0],
            [2, 2, 8, 1, 1],
            [7, 7, 0, 0, 0],
            [3, 2, 6, 3, 0],
            [2, 5, 3, 2, 2],
            [6, 5, 2, 1, 0],
            [0, 2, 2, 3, 7],
        ];
        let things: Vec<Vec<usize>> = counts
            .iter()
            .map(|row| {
                let each = row.iter().enumerate();
                each.flat_map(|(category, n)| vec![category; *n]).collect()
            })
            .collect();
        near(fleiss(&things), 0.210);
        assert_eq!(fleiss(&[vec![1]]), None, "one choice says nothing");
    }
}
