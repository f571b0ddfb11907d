//! Money spent on questions: what is known, what is bounded, and what is unknown, each counted apart.

use nearmiss_store::Consumed;

/// One attempt at a question, as far as it was paid for.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Attempt {
    /// Time, tokens and cost.
    pub consumed: Consumed,
    /// The most that it can have cost, US dollars, where that was known when it was asked.
    pub most_usd: Option<f64>,
}

/// A sum of costs.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Spending {
    /// Attempts whose cost is known.
    pub known: u32,
    /// Their cost, US dollars.
    pub usd: f64,
    /// Attempts whose cost is not known, and what they can have cost at most is.
    pub bounded: u32,
    /// That, US dollars.
    pub most_usd: f64,
    /// Attempts of which neither is known.
    pub unknown: u32,
}

impl Spending {
    /// Adds an attempt: its cost, else the most that it can have cost. What can have cost nothing did.
    pub fn add(&mut self, cost_usd: Option<f64>, most_usd: Option<f64>) {
        match (cost_usd, most_usd) {
            (Some(usd), _) => {
                self.known += 1;
                self.usd += usd;
            }
            (None, Some(most)) if most <= 0.0 => self.known += 1,
            (None, Some(most)) => {
                self.bounded += 1;
                self.most_usd += most;
            }
            (None, None) => self.unknown += 1,
        }
    }

    /// Adds another sum.
    pub fn join(&mut self, other: &Self) {
        self.known += other.known;
        self.usd += other.usd;
        self.bounded += other.bounded;
        self.most_usd += other.most_usd;
        self.unknown += other.unknown;
    }

    /// Attempts whose cost is not known, bounded or not.
    #[must_use]
    pub fn unpriced(&self) -> u32 {
        self.bounded + self.unknown
    }

    /// The cost that is known, US dollars; `None` if none is.
    #[must_use]
    pub fn cost(&self) -> Option<f64> {
        (self.known > 0).then_some(self.usd)
    }

    /// The most that the bounded attempts cost, US dollars; `None` if there is none.
    #[must_use]
    pub fn most(&self) -> Option<f64> {
        (self.bounded > 0).then_some(self.most_usd)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_bounded_and_unknown_costs_are_told_apart() {
        let mut sum = Spending::default();
        for (cost, most) in [
            (Some(0.25), Some(1.0)),
            (None, Some(0.5)),
            (None, None),
            (None, Some(0.0)),
        ] {
            sum.add(cost, most);
        }
        assert_eq!((sum.known, sum.cost()), (2, Some(0.25)));
        assert_eq!((sum.bounded, sum.most()), (1, Some(0.5)));
        assert_eq!((sum.unknown, sum.unpriced()), (1, 2));
        let mut twice = sum;
        twice.join(&sum);
        assert_eq!((twice.cost(), twice.unpriced()), (Some(0.5), 4));
        assert_eq!(Spending::default().cost(), None);
    }
}
