//! A proportion of answers, with its interval over scenarios.

use std::collections::BTreeMap;

use super::statistics::{Interval, scenario_interval};

/// A proportion: a count out of a total.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Share {
    /// Those that are meant.
    pub hits: u32,
    /// All.
    pub of: u32,
    /// Scenarios that they are about: several answers about one are not independent.
    pub scenarios: u32,
    /// The interval of 95 %, with the scenario as the unit, see [`scenario_interval`].
    pub interval: Option<Interval>,
}

/// Counts a share, answer by answer.
#[derive(Debug, Clone, Default)]
pub(super) struct Tally<'a> {
    /// Hits and all answers of each scenario.
    scenarios: BTreeMap<&'a str, (u32, u32)>,
}

impl<'a> Tally<'a> {
    /// Counts one more answer, about this scenario.
    pub fn count(&mut self, scenario: &'a str, hit: bool) {
        self.add(scenario, u32::from(hit), 1);
    }

    /// Counts more answers about this scenario.
    pub fn add(&mut self, scenario: &'a str, hits: u32, of: u32) {
        let (of_scenario, all) = self.scenarios.entry(scenario).or_default();
        *of_scenario += hits;
        *all += of;
    }

    /// The counted proportion.
    pub fn share(&self) -> Share {
        let counts: Vec<(u32, u32)> = self.scenarios.values().copied().collect();
        Share {
            hits: counts.iter().map(|(hits, _)| hits).sum(),
            of: counts.iter().map(|(_, of)| of).sum(),
            scenarios: counts.iter().filter(|(_, of)| *of > 0).count() as u32,
            interval: scenario_interval(&counts),
        }
    }
}

impl Share {
    /// From 0 to 1; nothing of nothing.
    #[must_use]
    pub fn value(&self) -> Option<f64> {
        (self.of > 0).then(|| f64::from(self.hits) / f64::from(self.of))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn answers_are_counted_by_scenario() {
        let names: Vec<String> = (0..12).map(|n| format!("S-{n}")).collect();
        let counted = |samples: usize| {
            let mut tally = Tally::default();
            for (at, name) in names.iter().enumerate() {
                (0..samples).for_each(|_| tally.count(name, at < 4));
            }
            tally.share()
        };
        let (once, thrice) = (counted(1), counted(3));
        assert_eq!((once.hits, once.of, once.scenarios), (4, 12, 12));
        assert_eq!((thrice.hits, thrice.of, thrice.scenarios), (12, 36, 12));
        assert_eq!(once.value(), thrice.value());
        // Wilson's with one answer each, else the bootstrap, which more samples do not narrow.
        let (low, high) = once.interval.map(|i| (i.low, i.high)).unwrap();
        assert!((low - 0.138_119).abs() < 1e-5 && (high - 0.609_378).abs() < 1e-5);
        assert_eq!(thrice.interval, counted(9).interval);
        assert_eq!(Tally::default().share(), Share::default());
    }
}
