//! Tests whether a few recorded answers can be a random sample of many published ones.

/// The two-sided p value of finding `hits` in `n` that were drawn without replacement from `all` with `marked` hits;
/// nothing where `n` is more than `all`, or `marked` is. It is 0 where that cannot be at all.
///
/// The sum of P(X = i) ≤ P(X = `hits`) over i, X hypergeometric: P(X = i) = C(marked, i)·C(all − marked, n − i) /
/// C(all, n); the two-sided rule of R. A. Fisher's exact test, J. O. Irwin, Metron 12 (1935).
#[must_use]
pub fn part_of(hits: u32, n: u32, marked: u32, all: u32) -> Option<f64> {
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
    use super::part_of;

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
            let found = part_of(hits, 30, marked, 100);
            assert!(
                found.is_some_and(|f| (f - p).abs() < 1e-9),
                "{hits} of {marked}: {found:?}"
            );
        }
        assert_eq!(part_of(1, 30, 1, 20), None);
    }
}
