//! The split of scenarios into dev and test.

use super::shard::spread;
use nearmiss_formats::Entry;
use nearmiss_scene::scenario::identity;
use nearmiss_store::SplitPart;

nearmiss_record::fields! {
    /// A split of scenarios into dev and test. Which part a scenario is in depends on its name and the seed alone.
    #[derive(Copy)]
    pub struct Split {
        "split" {
            /// Share of the families of scenarios that are in the test part.
            test [required]: f64, Takes::Between(0.0, 1.0);
            /// Another seed gives another split; by default 1.
            seed: u64 = Split::SEED;
        }
    }
}

impl Split {
    /// The seed where none is named.
    pub const SEED: u64 = 1;

    /// The part that a scenario is in. Scenarios of one map, such as `DEU_Bremen-7_12_T-1` and `DEU_Bremen-7_23_T-1`,
    /// are a family and never in different parts.
    #[must_use]
    pub fn part(&self, scenario: &str) -> SplitPart {
        let text = format!("{}:{}", self.seed, identity::family(scenario));
        // A number from 0 to below 1, evenly spread.
        if (spread(&text) as f64 / 2_f64.powi(64)) < self.test {
            SplitPart::Test
        } else {
            SplitPart::Dev
        }
    }

    /// The part without a scenario, if there is one.
    #[must_use]
    pub fn empty_part(&self, entries: &[Entry]) -> Option<SplitPart> {
        let holds = |part: &SplitPart| entries.iter().any(|entry| self.part(&entry.name) == *part);
        SplitPart::ALL.iter().copied().find(|part| !holds(part))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn families_stay_together_and_the_seed_decides() {
        let split = Split { test: 0.5, seed: 7 };
        let map = |number: usize| format!("DEU_Bremen-{number}_1_T-1");
        for number in 1..200 {
            let part = split.part(&map(number));
            let neighbour = format!("DEU_Bremen-{number}_23_T-2");
            assert_eq!(split.part(&neighbour), part);
            assert_eq!(split.part(&format!("C-{neighbour}")), part);
        }
        let tests = |split: Split| {
            let all = (1..=1000).map(map);
            let tests = all.filter(|name| split.part(name) == SplitPart::Test);
            tests.collect::<Vec<_>>()
        };
        let half = tests(split);
        assert!((450..550).contains(&half.len()), "{}", half.len());
        assert_ne!(half, tests(Split { seed: 8, ..split }));
        let few = tests(Split { test: 0.1, ..split });
        assert!(
            few.iter().all(|name| half.contains(name)),
            "a smaller share is a part of a larger one"
        );
        assert!((60..140).contains(&few.len()), "{}", few.len());
    }
}
