//! A proportion of answers, with its interval for a small number of scenarios.

use std::collections::BTreeSet;

use super::statistics::wilson_of_share;

/// A proportion: a count out of a total.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Share {
    /// Those that are meant.
    pub hits: u32,
    /// All.
    pub of: u32,
    /// Scenarios that they are about: several answers about one are not independent.
    pub scenarios: u32,
}

/// Counts a share, answer by answer.
#[derive(Debug, Clone, Default)]
pub(super) struct Tally<'a> {
    hits: u32,
    of: u32,
    scenarios: BTreeSet<&'a str>,
}

impl<'a> Tally<'a> {
    /// Counts one more answer, about this scenario.
    pub fn count(&mut self, scenario: &'a str, hit: bool) {
        self.hits += u32::from(hit);
        self.of += 1;
        self.scenarios.insert(scenario);
    }

    /// The counted proportion.
    pub fn share(&self) -> Share {
        Share {
            hits: self.hits,
            of: self.of,
            scenarios: self.scenarios.len() as u32,
        }
    }
}

impl Share {
    /// From 0 to 1; nothing of nothing.
    #[must_use]
    pub fn value(&self) -> Option<f64> {
        (self.of > 0).then(|| f64::from(self.hits) / f64::from(self.of))
    }

    /// The interval of 95 %: Wilson's, with as many observations as there are scenarios, see [`wilson_of_share`]. So
    /// more samples of the same scenarios do not make it narrower.
    #[must_use]
    pub fn interval(&self) -> Option<(f64, f64)> {
        let interval = wilson_of_share(self.value()?, self.scenarios);
        interval.map(|interval| (interval.low, interval.high))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn of_each(hits: usize, scenarios: &[String], samples: usize) -> Share {
        let mut tally = Tally::default();
        for (i, scenario) in scenarios.iter().enumerate() {
            (0..samples).for_each(|_| tally.count(scenario, i < hits));
        }
        tally.share()
    }

    fn names(n: usize) -> Vec<String> {
        (0..n).map(|i| format!("S-{i}")).collect()
    }

    #[test]
    fn intervals_are_those_worked_out_elsewhere() {
        // The formula in Python, to seven digits.
        let cases = [
            ((8, 10), (0.490_162_5, 0.943_317_8)),
            ((1, 20), (0.008_881_4, 0.236_131_2)),
            ((0, 10), (0.0, 0.277_532_8)),
            ((5, 5), (0.565_517_5, 1.0)),
        ];
        for ((hits, of), (low, high)) in cases {
            let (a, b) = of_each(hits, &names(of), 1).interval().unwrap();
            assert!(
                (a - low).abs() < 1e-6 && (b - high).abs() < 1e-6,
                "{hits}/{of}: {a} {b}"
            );
        }
        assert_eq!(Share::default().interval(), None);
    }

    #[test]
    fn more_samples_of_the_same_scenarios_are_no_more_scenarios() {
        let (once, twice) = (of_each(3, &names(8), 1), of_each(3, &names(8), 2));
        assert_eq!((twice.hits, twice.of, twice.scenarios), (6, 16, 8));
        assert_eq!(once.interval(), twice.interval());
        let more = of_each(6, &names(16), 1).interval().unwrap();
        let (low, high) = once.interval().unwrap();
        assert!(more.0 > low && more.1 < high, "more scenarios say more");
    }
}
