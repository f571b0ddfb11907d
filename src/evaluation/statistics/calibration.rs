//! Calibration of risk scores.

use serde::Serialize;

/// The answers of one risk score.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct Bin {
    /// Answers whose gravest obstacle has this score.
    pub n: u32,
    /// Of them those about true collisions.
    pub collisions: u32,
}

/// The scores 0 (collision) to 5 (negligible) beside what is true.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize)]
pub struct Calibration {
    /// By score.
    pub bins: [Bin; 6],
}

impl Calibration {
    /// The probability of a collision that a score stands for: 1 − score/5, so 0 is certain and 5 impossible.
    ///
    /// The paper gives its scores no probabilities; this is the straight line between both ends, and as such a
    /// convention.
    #[must_use]
    pub fn probability(score: u8) -> f64 {
        1.0 - f64::from(score.min(5)) / 5.0
    }

    /// Counts an answer by the score of its gravest obstacle.
    pub fn count(&mut self, score: u8, collides: bool) {
        let bin = &mut self.bins[usize::from(score.min(5))];
        bin.n += 1;
        bin.collisions += u32::from(collides);
    }

    /// Answers counted.
    #[must_use]
    pub fn n(&self) -> u32 {
        self.bins.iter().map(|bin| bin.n).sum()
    }

    /// The mean of (p − y)², p by [`Self::probability`] and y 1 for a collision, else 0; nothing of nothing.
    ///
    /// G. W. Brier, "Verification of forecasts expressed in terms of probability", Monthly Weather Review 78 (1950).
    #[must_use]
    pub fn brier(&self) -> Option<f64> {
        self.mean(|p, bin| {
            let (hits, others) = (f64::from(bin.collisions), f64::from(bin.n - bin.collisions));
            hits * (1.0 - p) * (1.0 - p) + others * p * p
        })
    }

    /// The expected calibration error Σ nₖ/n·|pₖ − share of collisions|, a bin for each score; nothing of nothing.
    ///
    /// M. P. Naeini, G. F. Cooper and M. Hauskrecht, "Obtaining well calibrated probabilities using Bayesian
    /// binning", AAAI (2015).
    #[must_use]
    pub fn error(&self) -> Option<f64> {
        self.mean(|p, bin| (p * f64::from(bin.n) - f64::from(bin.collisions)).abs())
    }

    fn mean(&self, of: impl Fn(f64, &Bin) -> f64) -> Option<f64> {
        let bins = (0_u8..).zip(&self.bins);
        let sum: f64 = bins
            .map(|(score, bin)| of(Self::probability(score), bin))
            .sum();
        (self.n() > 0).then(|| sum / f64::from(self.n()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// numpy 2.4, p = 1 − s/5: `mean((p − y)²)` = 0.22, and Σ |mean p − mean y|·share over the scores = 0.3.
    #[test]
    fn as_numpy_has_it() {
        let mut scores = Calibration::default();
        for (score, collides) in [0, 0, 1, 2, 5, 5, 3, 0]
            .into_iter()
            .zip([1, 1, 1, 0, 0, 0, 1, 0])
        {
            scores.count(score, collides == 1);
        }
        assert_eq!(
            scores.bins[0],
            Bin {
                n: 3,
                collisions: 2
            }
        );
        assert!(scores.brier().is_some_and(|b| (b - 0.22).abs() < 1e-12));
        assert!(scores.error().is_some_and(|e| (e - 0.3).abs() < 1e-12));
        assert_eq!(Calibration::default().brier(), None);
    }
}
