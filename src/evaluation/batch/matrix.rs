//! The matrix of a batch: every combination of task, frame, techniques, model and sample, in one fixed order.

use super::question_builder::Ask;
use super::variant::Variant;
use crate::description::Frame;
use crate::evaluation::{Lead, PromptConfig, Settings};
use crate::judge;
use crate::llm::{Effort, Parameters};
use crate::prompts::Techniques;
use crate::scenario::Transform;
use crate::verdict::Task;

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
    /// Sampling temperature.
    pub temperature: Option<f64>,
    /// Most tokens of an answer.
    pub max_tokens: Option<u32>,
    /// How much the models are to reason.
    pub effort: Option<Effort>,
}

impl RequestSettings {
    /// The settings that determine a scene's description.
    #[must_use]
    pub fn settings(&self, techniques: Option<Techniques>) -> Settings {
        Settings {
            history: self.history,
            radius: self.radius,
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
            seed: None,
            effort: self.effort,
        }
    }
}

impl Matrix {
    /// Every way of asking, each once: by task, frame, techniques and model, as they were named. The built-in judge,
    /// which is not asked in words, stands once for each task.
    #[must_use]
    pub fn ways(&self) -> Vec<PromptConfig> {
        let mut ways = Vec::new();
        for &task in &self.tasks {
            for &frame in &self.frames {
                for &techniques in &self.techniques {
                    for model in &self.models {
                        let in_words = model != judge::MODEL;
                        let way = PromptConfig {
                            task,
                            frame: in_words.then_some(frame),
                            techniques: in_words.then_some(techniques),
                            model: model.clone(),
                            template: None,
                        };
                        if !ways.contains(&way) {
                            ways.push(way);
                        }
                    }
                }
            }
        }
        ways
    }

    /// How many answers are wanted of a way of asking: the built-in judge always says the same.
    #[must_use]
    pub fn samples_of(&self, way: &PromptConfig) -> u32 {
        match way.model == judge::MODEL {
            true => 1,
            false => self.samples,
        }
    }

    /// The variants of a scenario's question: the unchanged scene with the first lead, then with each other one, then
    /// the changed scenes. Only the safety task has leads.
    #[must_use]
    pub fn variants(&self, way: &PromptConfig) -> Vec<Variant> {
        let timed = way.task == Task::Safety && !self.more_leads.is_empty();
        let first = Variant {
            lead: self.request.lead.filter(|_| timed),
            transform: None,
        };
        let more = self.more_leads.iter().filter(|_| timed);
        let leads = more.map(|lead| Variant {
            lead: Some(*lead),
            transform: None,
        });
        let changes = self.transforms.iter().map(|change| Variant {
            transform: Some(*change),
            ..first
        });
        std::iter::once(first).chain(leads).chain(changes).collect()
    }

    /// Everything that is asked about one scenario.
    #[must_use]
    pub fn asks(&self) -> Vec<Ask> {
        let asks = self.ways().into_iter().flat_map(|way| {
            let samples: Vec<u32> = (0..self.samples_of(&way)).collect();
            let variants = self.variants(&way).into_iter();
            variants.map(move |variant| Ask {
                samples: samples.clone(),
                way: way.clone(),
                variant,
            })
        });
        asks.collect()
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
