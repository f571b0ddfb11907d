//! The area under the receiver operating characteristic.

/// The probability that a value of a positive is above that of a negative, ties counted half; `None` if either is
/// missing.
///
/// (R − n(n + 1)/2) / (n·m) with the sum R of the mid-ranks of the n positives among all n + m: J. A. Hanley and B. J.
/// McNeil, "The meaning and use of the area under a receiver operating characteristic (ROC) curve", Radiology 143
/// (1982).
#[must_use]
pub fn auc(values: &[(f64, bool)]) -> Option<f64> {
    let positives = values.iter().filter(|(_, positive)| *positive).count();
    let negatives = values.len() - positives;
    if positives == 0 || negatives == 0 {
        return None;
    }
    let mut sorted = values.to_vec();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut ranks = 0.0;
    let mut start = 0;
    while start < sorted.len() {
        let same = sorted[start..]
            .iter()
            .take_while(|v| v.0 == sorted[start].0);
        let end = start + same.count();
        // Ranks from 1; equal values share their mean.
        let rank = (start + 1 + end) as f64 / 2.0;
        let hits = sorted[start..end].iter().filter(|(_, positive)| *positive);
        ranks += rank * hits.count() as f64;
        start = end;
    }
    let (n, m) = (positives as f64, negatives as f64);
    Some((ranks - n * (n + 1.0) / 2.0) / (n * m))
}

#[cfg(test)]
mod tests {
    use super::auc;

    #[test]
    fn ties_count_half() {
        assert_eq!(auc(&[(1.0, false), (2.0, true)]), Some(1.0));
        assert_eq!(auc(&[(2.0, false), (1.0, true)]), Some(0.0));
        assert_eq!(auc(&[(1.0, false), (1.0, true)]), Some(0.5));
        // Of the four pairs two are right, one is wrong and one is a tie.
        let four = [(1.0, false), (2.0, true), (3.0, false), (3.0, true)];
        assert_eq!(auc(&four), Some(0.625));
        assert_eq!(auc(&[(1.0, true)]), None);
    }
}
