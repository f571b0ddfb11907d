//! Calibration of probabilities, and how well they rank: the area under the ROC curve.

use schemars::JsonSchema;
use serde::Serialize;

/// The answers whose probabilities are in one tenth of the scale.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, JsonSchema)]
pub struct Bin {
    /// Answers with such a probability.
    pub n: u32,
    /// Of them those about what is truly a yes.
    pub yes: u32,
    /// The mean of their probabilities; `None` of nothing.
    pub mean: Option<f64>,
}

/// Probabilities beside the truth.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Calibration {
    values: Vec<(f64, bool)>,
}

/// Bins of the same width.
const BINS: usize = 10;

impl Calibration {
    /// Counts a probability from 0 to 1, and whether it is a yes in truth.
    pub fn count(&mut self, probability: f64, truth: bool) {
        self.values.push((probability.clamp(0.0, 1.0), truth));
    }

    /// Probabilities counted.
    #[must_use]
    pub fn n(&self) -> u32 {
        u32::try_from(self.values.len()).unwrap_or(u32::MAX)
    }

    /// The reliability of the probabilities, by tenths; 1 is in the last one.
    #[must_use]
    pub fn bins(&self) -> [Bin; BINS] {
        let mut bins = [Bin::default(); BINS];
        let mut sums = [0.0; BINS];
        for (p, truth) in &self.values {
            let at = ((p * BINS as f64) as usize).min(BINS - 1);
            bins[at].n += 1;
            bins[at].yes += u32::from(*truth);
            sums[at] += p;
        }
        for (bin, sum) in bins.iter_mut().zip(sums) {
            bin.mean = (bin.n > 0).then(|| sum / f64::from(bin.n));
        }
        bins
    }

    /// The mean of (p − y)², y 1 for a yes, else 0; nothing of nothing.
    ///
    /// G. W. Brier, "Verification of forecasts expressed in terms of probability", Monthly Weather Review 78 (1950).
    #[must_use]
    pub fn brier(&self) -> Option<f64> {
        let squares = self.values.iter().map(|(p, truth)| {
            let miss = p - f64::from(u8::from(*truth));
            miss * miss
        });
        (self.n() > 0).then(|| squares.sum::<f64>() / f64::from(self.n()))
    }

    /// The expected calibration error Σ nₖ/n·|mean of pₖ − share of yes| over the bins; nothing of nothing.
    ///
    /// M. P. Naeini, G. F. Cooper and M. Hauskrecht, "Obtaining well calibrated probabilities using Bayesian
    /// binning", AAAI (2015).
    #[must_use]
    pub fn error(&self) -> Option<f64> {
        let bins = self.bins();
        let off = bins.iter().filter_map(|bin| {
            let sum = bin.mean? * f64::from(bin.n);
            Some((sum - f64::from(bin.yes)).abs())
        });
        (self.n() > 0).then(|| off.sum::<f64>() / f64::from(self.n()))
    }

    /// How well the probabilities tell yes from no: see [`auc`].
    #[must_use]
    pub fn auroc(&self) -> Option<f64> {
        auc(&self.values)
    }
}

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
    use super::{auc, *};

    /// numpy 2.4: `mean((p − y)²)` = 0.22, and Σ |mean p − mean y|·share over the bins = 0.3.
    #[test]
    fn as_numpy_has_it() {
        let mut all = Calibration::default();
        let values = [1.0, 1.0, 0.8, 0.6, 0.0, 0.0, 0.4, 1.0];
        for (p, yes) in values.into_iter().zip([1, 1, 1, 0, 0, 0, 1, 0]) {
            all.count(p, yes == 1);
        }
        let bins = all.bins();
        assert_eq!((bins[9].n, bins[9].yes, bins[9].mean), (3, 2, Some(1.0)));
        assert_eq!((bins[0].n, bins[1].n, bins[1].mean), (2, 0, None));
        assert!(all.brier().is_some_and(|b| (b - 0.22).abs() < 1e-12));
        assert!(all.error().is_some_and(|e| (e - 0.3).abs() < 1e-12));
        // Of 16 pairs 11 are right and two are ties.
        assert_eq!(all.auroc(), Some(0.75));
        let none = Calibration::default();
        assert_eq!(
            (none.brier(), none.error(), none.auroc()),
            (None, None, None)
        );
    }

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
