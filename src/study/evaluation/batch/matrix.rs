//! The matrix of an experiment: every combination of task, frame, techniques, model and sample, in one fixed order.

use std::collections::HashSet;

use super::experiment::Experiment;
use super::prepared::Ask;
use super::variant::Variant;
use super::windows::BatchWindows;
use crate::evaluation::{AxisValues, PromptConfig};
use nearmiss_scene::judge;
use nearmiss_scene::verdict::Task;

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
        let ways = lists
            .iter()
            .fold(1_usize, |ways, (_, size)| ways.saturating_mul(*size));
        if ways <= MOST_WAYS {
            return Ok(());
        }
        let of = lists.iter().map(|(name, size)| format!("{size} of {name}"));
        let of: Vec<String> = of.collect();
        Err(format!(
            "{ways} ways of asking ({}), and a batch has at most {MOST_WAYS}; name fewer values, or make several batches of them",
            of.join(" × ")
        ))
    }

    /// Every way of asking, each once: by task, frame, techniques, model and values of axes, as they were named. The built-in judge,
    /// which is not asked in words, stands once for each task.
    #[must_use]
    pub fn ways(&self) -> Vec<PromptConfig> {
        let settings = self.axis_values();
        let (mut ways, mut known) = (Vec::new(), HashSet::new());
        for &task in &self.tasks {
            for &frame in &self.frames {
                for &techniques in &self.techniques {
                    for model in &self.models {
                        let in_words = model != judge::MODEL;
                        for settings in &settings {
                            let way = PromptConfig {
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
                            if known.insert(way.clone()) {
                                ways.push(way);
                            }
                        }
                    }
                }
            }
        }
        ways
    }

    /// Whether windows are drawn, so that dangerous and safe ones are alike.
    #[must_use]
    pub fn draws_windows(&self) -> bool {
        let drawn = |task: &Task| matches!(task, Task::Safety | Task::Collision);
        self.within.is_some() && self.tasks.iter().any(drawn)
    }

    /// How many answers are wanted of a way of asking: the built-in judge always says the same.
    #[must_use]
    pub fn samples_of(&self, way: &PromptConfig) -> u32 {
        if way.model == judge::MODEL {
            1
        } else {
            self.samples()
        }
    }

    /// The variants of a scenario's question: the unchanged scene with the first lead, then with each other one, then
    /// the changed scenes. Only the safety task has leads.
    #[must_use]
    pub fn variants(&self, way: &PromptConfig) -> Vec<Variant> {
        let timed = way.task == Task::Safety;
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
        for way in self.ways() {
            let samples: Vec<u32> = (0..self.samples_of(&way)).collect();
            for variant in self.variants(&way) {
                let ask = |variant, truth| Ask {
                    samples: samples.clone(),
                    way: way.clone(),
                    variant,
                    truth,
                };
                match windows.of(&way, variant.lead, path) {
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
