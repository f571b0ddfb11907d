//! Quantiles.

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
    use super::quantile;

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
