//! The Bradley–Terry model: strengths of answers from pairwise comparisons.
//!
//! Bradley and Terry, *Rank analysis of incomplete block designs: I. The method of paired comparisons*, Biometrika 39
//! (1952): i beats j with probability pᵢ / (pᵢ + pⱼ). The strengths are those of the greatest likelihood, found by the
//! MM algorithm of Hunter, *MM algorithms for generalized Bradley–Terry models*, Annals of Statistics 32 (2004). A tie
//! counts as half a win of each. Intervals are those of Wald, from the inverse of the observed information.

use nalgebra::DMatrix;

/// The result of many comparisons of some things, by their places.
#[derive(Debug, Clone, PartialEq)]
pub struct Comparisons {
    /// How often the first beat the second; ties are halves.
    wins: DMatrix<f64>,
}

/// The strength of a thing: the logarithm of p, with mean 0 over all, and the ends of its interval of 95 %.
///
/// A difference of 1 means that the stronger wins about 73 of 100.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Strength {
    /// The estimate.
    pub log: f64,
    /// Its standard error.
    pub error: f64,
}

/// Why there are no strengths.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum NoStrengths {
    /// Fewer than two items.
    #[error("fewer than two to compare")]
    TooFew,
    /// Some are never beaten by the others, or never met them: the likelihood has no greatest value.
    #[error("not all are connected by wins; more ratings are needed")]
    Unbounded,
}

/// Standard errors to either side of an estimate that hold 95 % of a normal distribution.
const WALD: f64 = 1.959_963_984_540_054;

/// Smaller changes of every strength end the search.
const SMALLEST: f64 = 1e-12;

impl Strength {
    /// The interval of 95 %.
    #[must_use]
    pub fn interval(&self) -> (f64, f64) {
        (self.log - WALD * self.error, self.log + WALD * self.error)
    }
}

impl Comparisons {
    /// Without results, for this many players.
    #[must_use]
    pub fn new(count: usize) -> Self {
        Self {
            wins: DMatrix::zeros(count, count),
        }
    }

    /// One beat another.
    ///
    /// # Panics
    /// The index is out of range.
    pub fn win(&mut self, winner: usize, loser: usize) {
        self.wins[(winner, loser)] += 1.0;
    }

    /// Two were equally good.
    ///
    /// # Panics
    /// The index is out of range.
    pub fn tie(&mut self, one: usize, other: usize) {
        self.wins[(one, other)] += 0.5;
        self.wins[(other, one)] += 0.5;
    }

    fn count(&self) -> usize {
        self.wins.nrows()
    }

    fn met(&self, i: usize, j: usize) -> f64 {
        self.wins[(i, j)] + self.wins[(j, i)]
    }

    /// The strengths, by place.
    ///
    /// # Errors
    /// The likelihood has no maximum: that needs a chain of wins from each item to each other one.
    pub fn strengths(&self) -> Result<Vec<Strength>, NoStrengths> {
        let count = self.count();
        if count < 2 {
            return Err(NoStrengths::TooFew);
        }
        if !self.is_connected() {
            return Err(NoStrengths::Unbounded);
        }
        let mut p = vec![1.0; count];
        // It grows with every step; the bound is there for what rounding might do.
        for _ in 0..100_000 {
            let next = self.improved(&p);
            let change = next.iter().zip(&p).map(|(a, b)| (a.ln() - b.ln()).abs());
            let most = change.fold(0.0, f64::max);
            p = next;
            if most < SMALLEST {
                break;
            }
        }
        let errors = self.errors(&p).ok_or(NoStrengths::Unbounded)?;
        let strength = |(p, error): (&f64, f64)| Strength { log: p.ln(), error };
        Ok(p.iter().zip(errors).map(strength).collect())
    }

    /// A step of the MM algorithm, with the geometric mean 1.
    fn improved(&self, p: &[f64]) -> Vec<f64> {
        let everyone = 0..self.count();
        let mut next: Vec<f64> = everyone
            .clone()
            .map(|i| {
                let won: f64 = self.wins.row(i).sum();
                let met: f64 = everyone
                    .clone()
                    .filter(|&j| j != i)
                    .map(|j| self.met(i, j) / (p[i] + p[j]))
                    .sum();
                won / met
            })
            .collect();
        let mean = next.iter().map(|p| p.ln()).sum::<f64>() / next.len() as f64;
        next.iter_mut().for_each(|p| *p /= mean.exp());
        next
    }

    /// Standard errors of the logarithms under the condition that their mean is 0.
    fn errors(&self, p: &[f64]) -> Option<Vec<f64>> {
        let count = self.count();
        let mut information = DMatrix::zeros(count, count);
        for i in 0..count {
            for j in (0..count).filter(|&j| j != i) {
                let weight = self.met(i, j) * p[i] * p[j] / (p[i] + p[j]).powi(2);
                information[(i, i)] += weight;
                information[(i, j)] -= weight;
            }
        }
        // The information says nothing about the mean. With that direction filled in it can be inverted, and what
        // was filled in is taken out again: the inverse on the plane where the mean is 0.
        let mean = DMatrix::from_element(count, count, 1.0 / count as f64);
        let covariance = (information + &mean).try_inverse()? - mean;
        let errors = (0..count).map(|i| covariance[(i, i)].max(0.0).sqrt());
        Some(errors.collect())
    }

    /// Whether a chain of wins leads from each item to each other one.
    fn is_connected(&self) -> bool {
        let reaches_all = |wins: &dyn Fn(usize, usize) -> bool| {
            let mut reached = vec![false; self.count()];
            let mut next = vec![0];
            while let Some(i) = next.pop() {
                if !std::mem::replace(&mut reached[i], true) {
                    next.extend((0..self.count()).filter(|&j| wins(i, j)));
                }
            }
            reached.into_iter().all(|there| there)
        };
        reaches_all(&|i, j| self.wins[(i, j)] > 0.0) && reaches_all(&|i, j| self.wins[(j, i)] > 0.0)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn of(count: usize, results: &[(usize, usize, usize)]) -> Comparisons {
        let mut all = Comparisons::new(count);
        for &(winner, loser, times) in results {
            (0..times).for_each(|_| all.win(winner, loser));
        }
        all
    }

    #[test]
    fn two_by_hand() {
        // 7 to 3: the odds are 7/3, so the logarithms are ± ln(7/3)/2. The information of their difference is
        // n·p·q = 10·0.7·0.3 = 2.1; each is half of it, with a standard error of sqrt(1/2.1)/2.
        let all = of(2, &[(0, 1, 7), (1, 0, 3)]).strengths().unwrap();
        assert!((all[0].log - (7.0_f64 / 3.0).ln() / 2.0).abs() < 1e-9);
        assert!((all[1].log + all[0].log).abs() < 1e-9);
        let error = (1.0_f64 / 2.1).sqrt() / 2.0;
        assert!((all[0].error - error).abs() < 1e-9 && (all[1].error - error).abs() < 1e-9);
        let (low, high) = all[0].interval();
        assert!((high - low - 2.0 * 1.959_964 * error).abs() < 1e-5);
    }

    #[test]
    fn ties_are_half_wins() {
        let mut tied = of(2, &[(0, 1, 3), (1, 0, 1)]);
        (0..2).for_each(|_| tied.tie(0, 1));
        let plain = of(2, &[(0, 1, 4), (1, 0, 2)]);
        assert_eq!(tied, plain);
        let mut even = Comparisons::new(2);
        even.tie(0, 1);
        assert!(even.strengths().unwrap()[0].log.abs() < 1e-12);
    }

    #[test]
    fn three_against_newtons_method() {
        // Computed elsewhere (Python) by Newton's method on the log-likelihood with the first strength fixed,
        // centred afterwards, the errors by the delta method: wins 12:5, 9:3 and 7.5:6.5, the half from a tie.
        let results = [
            (0, 1, 12),
            (1, 0, 5),
            (0, 2, 9),
            (2, 0, 3),
            (1, 2, 7),
            (2, 1, 6),
        ];
        let mut all = of(3, &results);
        all.tie(1, 2);
        let found = all.strengths().unwrap();
        let logs = [0.653_917_993_869, -0.244_049_728_181, -0.409_868_265_688];
        let errors = [0.278_955_998_661, 0.252_472_297_164, 0.279_390_207_881];
        for ((strength, log), error) in found.iter().zip(logs).zip(errors) {
            assert!((strength.log - log).abs() < 1e-9, "{found:?}");
            assert!((strength.error - error).abs() < 1e-9, "{found:?}");
        }
    }

    #[test]
    fn without_a_chain_of_wins_there_are_none() {
        let none = |all: Comparisons| all.strengths().unwrap_err();
        assert_eq!(
            none(of(2, &[(0, 1, 5)])),
            NoStrengths::Unbounded,
            "never beaten"
        );
        assert_eq!(
            none(of(4, &[(0, 1, 1), (1, 0, 1), (2, 3, 1), (3, 2, 1)])),
            NoStrengths::Unbounded,
            "two islands"
        );
        assert_eq!(none(of(1, &[])), NoStrengths::TooFew);
        assert_eq!(none(of(0, &[])), NoStrengths::TooFew);
    }
}
