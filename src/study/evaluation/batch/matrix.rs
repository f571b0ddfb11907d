//! The matrix of an experiment in one fixed order, and parts of its scenarios: dev and test, and shards.

use std::collections::HashSet;

use nearmiss_formats::Entry;
use nearmiss_scene::judge;
use nearmiss_scene::scenario::identity;
use nearmiss_scene::verdict::Task;
use nearmiss_store::SplitPart;
use sha2::{Digest, Sha256};

use super::experiment::Experiment;
use super::prepared::Ask;
use super::question_builder::Variant;
use super::windows::BatchWindows;
use crate::evaluation::{AxisValues, PromptConfig};

/// Ways of asking that a matrix has at most.
const MOST_WAYS: usize = 100_000;

impl Experiment {
    /// Checks that there are not too many combinations, without making them.
    ///
    /// # Errors
    /// In words: how many there are, and of what.
    pub fn check_size(&self) -> Result<(), String> {
        let several = self.several().map(|(key, values)| (key, values.len()));
        let lists = [
            ("task", self.tasks.len()),
            ("frame", self.frames.len()),
            ("technique", self.techniques.len()),
            ("model", self.models.len()),
        ]
        .into_iter()
        .chain(several);
        let lists: Vec<(&str, usize)> = lists.filter(|(_, size)| *size > 1).collect();
        let configurations = lists.iter().fold(1_usize, |configurations, (_, size)| {
            configurations.saturating_mul(*size)
        });
        if configurations <= MOST_WAYS {
            return Ok(());
        }
        let of = lists.iter().map(|(name, size)| format!("{size} of {name}"));
        let of: Vec<String> = of.collect();
        Err(format!(
            "{configurations} ways of asking ({}), and a batch has at most {MOST_WAYS}; name fewer values, or make several batches of them",
            of.join(" × ")
        ))
    }

    /// Every way of asking, each once: by task, frame, techniques, model and values of axes, as they were named. The built-in judge,
    /// which is not asked in words, stands once for each task.
    #[must_use]
    pub fn configurations(&self) -> Vec<PromptConfig> {
        let settings = self.axis_values();
        let (mut configurations, mut known) = (Vec::new(), HashSet::new());
        for &task in &self.tasks {
            for &frame in &self.frames {
                for &techniques in &self.techniques {
                    for model in &self.models {
                        let in_words = model != judge::MODEL;
                        for settings in &settings {
                            let configuration = PromptConfig {
                                task,
                                frame: in_words.then_some(frame),
                                techniques: in_words.then_some(techniques),
                                model: model.clone(),
                                settings: if in_words {
                                    *settings
                                } else {
                                    AxisValues::default()
                                },
                                template: None,
                            };
                            if known.insert(configuration.clone()) {
                                configurations.push(configuration);
                            }
                        }
                    }
                }
            }
        }
        configurations
    }

    /// Whether windows are drawn, so that dangerous and safe ones are alike.
    #[must_use]
    pub fn draws_windows(&self) -> bool {
        let drawn = |task: &Task| matches!(task, Task::Safety | Task::Collision);
        self.within.is_some() && self.tasks.iter().any(drawn)
    }

    /// How many answers are wanted of a way of asking: the built-in judge always says the same.
    #[must_use]
    pub fn samples_for(&self, configuration: &PromptConfig) -> u32 {
        if configuration.model == judge::MODEL {
            1
        } else {
            self.samples()
        }
    }

    /// The variants of a scenario's question: the unchanged scene with the first lead, then with each other one, then
    /// the changed scenes. Only the safety task has leads.
    #[must_use]
    pub fn variants(&self, configuration: &PromptConfig) -> Vec<Variant> {
        let timed = configuration.task == Task::Safety;
        let first = Variant {
            lead: self.lead().filter(|_| timed),
            ..Variant::default()
        };
        let more = self.more_leads().iter().filter(|_| timed);
        let leads = more.map(|lead| Variant {
            lead: Some(*lead),
            ..Variant::default()
        });
        let changes = self.transforms.iter().map(|change| Variant {
            transform: Some(*change),
            ..first
        });
        std::iter::once(first).chain(leads).chain(changes).collect()
    }

    /// Everything that is asked about the scenario with this path.
    #[must_use]
    pub fn asks(&self, windows: &BatchWindows, path: &str) -> Vec<Ask> {
        let mut asks = Vec::new();
        for configuration in self.configurations() {
            let samples: Vec<u32> = (0..self.samples_for(&configuration)).collect();
            for variant in self.variants(&configuration) {
                let ask = |variant, truth| Ask {
                    samples: samples.clone(),
                    configuration: configuration.clone(),
                    variant,
                    truth,
                };
                match windows.get(&configuration, variant.lead, path) {
                    None => asks.push(ask(variant, None)),
                    Some(windows) => asks.extend(windows.iter().map(|window| {
                        let window = window.clone();
                        let steps = Some(window.steps);
                        ask(
                            Variant {
                                window: steps,
                                ..variant
                            },
                            Some(window),
                        )
                    })),
                }
            }
        }
        asks
    }
}

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

/// The part of the scenarios that one machine works on: its number from 1, and how many there are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shard {
    number: u32,
    of: u32,
}

impl Shard {
    /// Whether a scenario belongs to this part. It depends on the scenario's name alone, so that every machine comes to
    /// the same, whatever lies where.
    #[must_use]
    pub fn has(&self, scenario: &str) -> bool {
        spread(scenario) % u64::from(self.of) == u64::from(self.number - 1)
    }

    /// The whole, as one part.
    #[must_use]
    pub fn full() -> Self {
        Self { number: 1, of: 1 }
    }

    /// The part in names of files and folders: `2-of-8`.
    #[must_use]
    pub fn file_word(&self) -> String {
        format!("{}-of-{}", self.number, self.of)
    }
}

/// The first eight bytes of the SHA-256 of a name as a number: the same on every machine.
pub(super) fn spread(name: &str) -> u64 {
    let digest = Sha256::digest(name.as_bytes());
    let first = digest.iter().take(8);
    first.fold(0, |hash, byte| hash << 8 | u64::from(*byte))
}

impl std::fmt::Display for Shard {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}/{}", self.number, self.of)
    }
}

impl std::str::FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parts = text
            .split_once('/')
            .and_then(|(n, of)| Some((n.parse().ok()?, of.parse().ok()?)));
        match parts {
            Some((number, of)) if (1..=of).contains(&number) => Ok(Self { number, of }),
            _ => Err("expected a part I/N, from 1/N to N/N, such as 2/8".into()),
        }
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
