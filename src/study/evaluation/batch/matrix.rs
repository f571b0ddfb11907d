//! The matrix of a batch: every combination of task, frame, techniques, model and sample, in one fixed order.

use std::collections::HashSet;

use super::prepared::Ask;
use super::variant::Variant;
use super::windows::BatchWindows;
use crate::evaluation::windows::{LEAD, WITHIN};
use crate::evaluation::{Axes, AxisValues, Lead, PAPER_STEPS, PromptConfig, Protocol, Settings};
use nearmiss_ask::llm::{Effort, Parameters, ToolLimits};
use nearmiss_ask::prompts::{Pack, Techniques};
use nearmiss_scene::description::{EgoAxes, Form, Frame};
use nearmiss_scene::judge;
use nearmiss_scene::metrics::MeasureList;
use nearmiss_scene::scenario::Transform;
use nearmiss_scene::verdict::Task;

/// All questions about every scenario.
#[derive(Debug, Clone, PartialEq)]
pub struct Matrix {
    /// The tasks.
    pub tasks: Vec<Task>,
    /// From where scenes are described.
    pub frames: Vec<Frame>,
    /// The combinations of prompting techniques.
    pub techniques: Vec<Techniques>,
    /// The models asked, as `provider/model`.
    pub models: Vec<String>,
    /// Answers to each request, at least one.
    pub samples: u32,
    /// Leads that the safety task is asked with beside that of `request`.
    pub more_leads: Vec<Lead>,
    /// Changes of the scene under each of which everything is asked once more, with the first lead.
    pub transforms: Vec<Transform>,
    /// Settings in several values, under each of which everything is asked once more.
    pub axes: Axes,
    /// How all of them are asked.
    pub request: RequestSettings,
}

/// Request settings of a batch; unset ones are the template's, else the program's or the server's.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct RequestSettings {
    /// Steps in a window.
    pub history: Option<usize>,
    /// Obstacles farther from the ego are left out, metres.
    pub radius: Option<f64>,
    /// Where windows of the safety task end; `None` for the usual one, two steps before the last recorded one.
    pub lead: Option<Lead>,
    /// How far after its last step the truth of a window looks, seconds, where windows are drawn so that dangerous and
    /// safe ones are alike; `None` for the ends of recordings.
    pub within: Option<f64>,
    /// By which rules windows are chosen and answers counted; with [`Protocol::Paper`] there are no `lead` and `within`.
    pub protocol: Protocol,
    /// Whether windows are drawn of every safe scenario, also where no dangerous window is left for it.
    pub every_scenario: bool,
    /// Sampling temperature.
    pub temperature: Option<f64>,
    /// Most tokens of an answer.
    pub max_tokens: Option<u32>,
    /// How much the models are to reason.
    pub effort: Option<Effort>,
    /// Whether log probabilities are asked for.
    pub log_probabilities: bool,
    /// Whether models may call tools, and how often; where that is an axis, how often.
    pub tools: Option<ToolLimits>,
    /// Form of the description.
    pub form: Option<Form>,
    /// Steps between described ones.
    pub stride: Option<usize>,
    /// Whether the Cartesian frame describes the road.
    pub road: Option<bool>,
    /// What the ego frame measures along and across.
    pub axes: Option<EgoAxes>,
    /// The measures of the metrics frame.
    pub measures: Option<MeasureList>,
    /// The templates that are asked with.
    pub pack: Pack,
    /// Seed of the sampling.
    pub seed: Option<u64>,
}

impl RequestSettings {
    /// The same for these tasks with windows drawn as the protocol says: by default dangerous ones and safe ones like
    /// them.
    #[must_use]
    pub fn drawn(self, tasks: &[Task]) -> Self {
        if self.protocol == Protocol::Paper {
            return Self {
                lead: None,
                within: None,
                history: self.history.or(Some(PAPER_STEPS)),
                ..self
            };
        }
        let timed = tasks.contains(&Task::Safety);
        Self {
            lead: self.lead.or(timed.then_some(LEAD)),
            within: self.within.or(Some(WITHIN)),
            ..self
        }
    }

    /// The settings that determine a scene's description.
    #[must_use]
    pub fn settings(&self, techniques: Option<Techniques>) -> Settings {
        Settings {
            history: self.history,
            radius: self.radius,
            form: self.form,
            stride: self.stride,
            road: self.road,
            axes: self.axes,
            measures: self.measures,
            techniques,
            ..Settings::default()
        }
    }

    /// The parameters sent beside the messages.
    #[must_use]
    pub fn parameters(&self) -> Parameters {
        Parameters {
            temperature: self.temperature,
            max_tokens: self.max_tokens,
            seed: self.seed,
            effort: self.effort,
            log_probabilities: self.log_probabilities,
            tools: self.tools,
        }
    }
}

/// Ways of asking that a matrix has at most.
const MOST_WAYS: usize = 100_000;

impl Matrix {
    /// Checks that there are not too many combinations, without making them.
    ///
    /// # Errors
    /// In words: how many there are, and of what.
    pub fn check_size(&self) -> Result<(), String> {
        let lists = [
            ("task", self.tasks.len()),
            ("frame", self.frames.len()),
            ("technique", self.techniques.len()),
            ("model", self.models.len()),
        ]
        .into_iter()
        .chain(self.axes.sizes());
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
        let settings = self.axes.values();
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
        self.request.within.is_some() && self.tasks.iter().any(drawn)
    }

    /// How many answers are wanted of a way of asking: the built-in judge always says the same.
    #[must_use]
    pub fn samples_of(&self, way: &PromptConfig) -> u32 {
        if way.model == judge::MODEL {
            1
        } else {
            self.samples
        }
    }

    /// The variants of a scenario's question: the unchanged scene with the first lead, then with each other one, then
    /// the changed scenes. Only the safety task has leads.
    #[must_use]
    pub fn variants(&self, way: &PromptConfig) -> Vec<Variant> {
        let timed = way.task == Task::Safety;
        let first = Variant {
            lead: self.request.lead.filter(|_| timed),
            ..Variant::default()
        };
        let more = self.more_leads.iter().filter(|_| timed);
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

    /// Adds what is not there yet.
    pub fn extend(&mut self, more: &MatrixAdditions) {
        add(&mut self.models, &more.models);
        add(&mut self.techniques, &more.techniques);
        let first = self.request.lead;
        let leads = more.leads.iter().filter(|lead| Some(**lead) != first);
        add(&mut self.more_leads, leads);
        add(&mut self.transforms, &more.transforms);
        self.samples = self.samples.max(more.samples.unwrap_or(0));
    }
}

/// Additions to a batch's matrix.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MatrixAdditions {
    /// Models, as `provider/model`.
    pub models: Vec<String>,
    /// Combinations of prompting techniques.
    pub techniques: Vec<Techniques>,
    /// Leads of the safety task.
    pub leads: Vec<Lead>,
    /// Changes of the scene.
    pub transforms: Vec<Transform>,
    /// Answers to each request that there shall be then.
    pub samples: Option<u32>,
}

impl MatrixAdditions {
    /// Whether anything is added.
    #[must_use]
    pub fn any(&self) -> bool {
        *self != Self::default()
    }
}

fn add<'a, T: Clone + PartialEq + 'a>(to: &mut Vec<T>, more: impl IntoIterator<Item = &'a T>) {
    for one in more {
        if !to.contains(one) {
            to.push(one.clone());
        }
    }
}
