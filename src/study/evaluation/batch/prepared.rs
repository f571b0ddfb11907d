//! The questions about a scenario as a batch stores them, which are answered already, and estimates of what the rest takes.

use std::collections::HashMap;
use std::sync::Arc;

use jiff::Zoned;
use nearmiss_formats::Entry;
use nearmiss_scene::scenario::Window;
use nearmiss_scene::verdict::Task;
use nearmiss_store::{NewItem, Store, StoreError};

use super::question_builder::{QuestionBuilder, Variant, obstacle, question_key, stored_path};
use super::truth::Truth;
use super::windows::{AskedWindow, RuleValues, facts};
use crate::evaluation::ask_model::most_usd;
use crate::evaluation::judges::has_answer;
use crate::evaluation::{AxisValues, Judge, Judges, Label, LabelError, PromptConfig, Question};

/// A way of asking and the answers that are wanted of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Ask {
    /// How it is asked.
    pub configuration: PromptConfig,
    /// With which lead, and about which change of the scene.
    pub variant: Variant,
    /// What is true about its window, where that was drawn; else the label of the scenario counts.
    pub truth: Option<AskedWindow>,
    /// Which of several answers.
    pub samples: Vec<u32>,
}

/// The questions about a scenario.
#[derive(Debug, Default)]
pub struct PreparedQuestions {
    /// The questions about it, and what asking them takes; `None` for those that cannot be asked.
    pub items: Vec<(NewItem, Option<Size>)>,
    /// Whether its truth is unknown; nothing is asked then.
    pub unlabelled: bool,
    /// A label that cannot be of this scenario; nothing is asked then.
    pub wrong: Option<LabelError>,
    /// Warnings about it.
    pub doubts: Vec<String>,
    /// For each model and values of axes the first question that would be sent to it.
    pub first: Vec<(String, AxisValues, Arc<Question>)>,
}

/// What is true of a window, and which obstacles are critical in it; `None` where that is unknown.
type KnownTruth = Option<(Label, Vec<i64>)>;

impl QuestionBuilder {
    /// Makes the questions about a scenario, and sees which answers the store has.
    ///
    /// # Errors
    /// The store cannot be read.
    pub fn prepare(
        &self,
        entry: &Entry,
        asks: &[Ask],
        truth: &Truth,
        judges: &Judges,
        store: &Store,
    ) -> Result<PreparedQuestions, StoreError> {
        let mut prepared = PreparedQuestions::default();
        let opened = self.open(entry);
        let scene = opened.as_ref().ok().map(|reading| &*reading.scene);
        if let Err(wrong) = truth.fits(entry, scene) {
            prepared.wrong = Some(wrong);
            return Ok(prepared);
        }
        let label = truth.label(entry, scene);
        if label.is_none() && truth.leaves_out() {
            prepared.unlabelled = true;
            return Ok(prepared);
        }
        if let Ok(reading) = &opened {
            prepared.doubts.clone_from(&reading.doubts);
            let scored = |ask: &Ask| ask.configuration.task != Task::Collision;
            if asks.iter().any(scored) {
                let why = truth.not_scored(&reading.scene, &self.thresholds);
                prepared.doubts.extend(why);
            }
        }
        // Many ways ask about the same steps.
        let mut known: HashMap<(Task, Window), KnownTruth> = HashMap::new();
        let mut values: HashMap<Window, RuleValues> = HashMap::new();
        for ask in asks {
            let label = ask.truth.as_ref().map_or(label, |truth| Some(truth.label));
            // Windows of safe scenarios are the same at every lead: one is enough.
            let another = ask.variant.transform.is_none()
                && ask.variant.window.is_none()
                && ask.variant.lead.is_some()
                && ask.variant.lead != self.experiment.lead();
            if another && label == Some(Label::Safe) {
                continue;
            }
            let question = self.question(entry, &ask.configuration, &ask.variant, label);
            let judge = &*judges[&ask.configuration.model].under(&ask.configuration.settings);
            let (key, size) = match &question {
                Ok(question) => (
                    question_key(question, judge)?,
                    Some(Size::estimate(question, judge)),
                ),
                Err(_) => (None, None),
            };
            let (lead, transform) = ask.variant.stored();
            let told = match (&ask.truth, &question) {
                (Some(truth), _) => Some((truth.label, truth.critical.clone())),
                (None, Ok(question)) => {
                    let (task, window) = (ask.configuration.task, question.case.window);
                    let told = || {
                        let about = (entry, scene);
                        truth.of_question(task, about, (&window, self.horizon()), &self.thresholds)
                    };
                    known.entry((task, window)).or_insert_with(told).clone()
                }
                (None, Err(_)) => label.map(|label| (label, label.critical())),
            };
            let (label, critical) = told.unzip();
            let critical = critical.unwrap_or_default();
            let facts = question.as_ref().ok().map(|question| {
                let case = &question.case;
                // Changes of the scene leave distances and times as they are.
                let values = values
                    .entry(case.window)
                    .or_insert_with(|| RuleValues::new(&case.scene, &case.window));
                facts(question, critical, *values)
            });
            for &sample in &ask.samples {
                let known = match &question {
                    Ok(question) => has_answer(question, (judge, key.as_ref()), sample, store)?,
                    Err(why) => Err(why.clone()),
                };
                let (stored, unaskable) = (known == Ok(true), known.err());
                if let (Ok(question), false, None) = (&question, stored, &unaskable)
                    && !prepared.first.iter().any(|(model, settings, _)| {
                        *model == ask.configuration.model && *settings == ask.configuration.settings
                    })
                {
                    let (model, settings) =
                        (ask.configuration.model.clone(), ask.configuration.settings);
                    prepared.first.push((model, settings, Arc::clone(question)));
                }
                let item = NewItem {
                    path: stored_path(entry),
                    scenario: entry.name.clone(),
                    scenario_hash: scene.map(|scene| scene.scenario.hash.to_string()),
                    ego: scene.map(|scene| scene.ego.to_string()),
                    task: ask.configuration.task,
                    frame: ask
                        .configuration
                        .frame
                        .map(|frame| frame.name().to_string()),
                    techniques: ask
                        .configuration
                        .techniques
                        .map(|techniques| techniques.to_string()),
                    model: ask.configuration.model.clone(),
                    sample,
                    lead: lead.clone(),
                    transform: transform.clone(),
                    window: ask.variant.window,
                    facts: facts.clone(),
                    scene: None,
                    key: key.clone(),
                    collides: label.map(Label::collides),
                    obstacle: obstacle(label),
                    unaskable: unaskable.clone(),
                    settings: ask.configuration.settings.to_stored(),
                    split: None,
                };
                let size = size.clone().filter(|_| unaskable.is_none());
                let size = size.map(|size| Size { stored, ..size });
                prepared.items.push((item, size));
            }
        }
        Ok(prepared)
    }
}

/// Estimated size of one question.
#[derive(Debug, Clone, PartialEq)]
pub struct Size {
    /// Tokens of the question, estimated.
    pub tokens: u64,
    /// Whether the store has a whole answer.
    pub stored: bool,
    /// Its price.
    pub price: Price,
    /// What the bound counts beyond listed prices, in words.
    pub bound: Option<String>,
    /// Rounds of tools that it may take at most; 0 without tools.
    pub rounds: u32,
}

/// Price of one question, US dollars.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Price {
    /// Free: the built-in judge, or recorded answers.
    Free,
    /// At most this, the answer included.
    AtMost(f64),
    /// The question alone, and a million tokens of the answer, which nothing bounds.
    Question {
        /// The question.
        usd: f64,
        /// A million tokens of the answer.
        million: f64,
    },
    /// No price is known.
    Unknown,
}

impl Size {
    /// Estimates a question.
    #[must_use]
    pub fn estimate(question: &Question, judge: &Judge) -> Self {
        let tokens = question.tokens();
        let pricing = match judge {
            Judge::Reference | Judge::Recorded(_) => None,
            Judge::Model(model) => {
                let prices = &model.endpoint.prices;
                prices.pricing_for(&model.name, Zoned::now().date())
            }
        };
        let price = match judge {
            Judge::Reference | Judge::Recorded(_) => Price::Free,
            Judge::Model(model) => most_usd(question, model).map_or_else(
                || {
                    let tokens = u32::try_from(tokens).unwrap_or(u32::MAX);
                    let alone = pricing.as_ref().and_then(|pricing| {
                        let usd = pricing.at_most(tokens, 0)?;
                        let million = pricing.at_most(tokens, 1_000_000)? - usd;
                        Some(Price::Question { usd, million })
                    });
                    alone.unwrap_or(Price::Unknown)
                },
                Price::AtMost,
            ),
        };
        Self {
            tokens: tokens as u64,
            stored: false,
            price,
            bound: pricing.and_then(|pricing| pricing.bound_note()),
            rounds: match judge {
                Judge::Model(model) => model.parameters.tools.map_or(0, |limits| limits.rounds),
                Judge::Reference | Judge::Recorded(_) => 0,
            },
        }
    }
}

/// Estimated total of all questions.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Estimate {
    /// Requests that would be sent; those to the built-in judge, and for recorded answers, are none.
    pub requests: u64,
    /// Questions that the built-in judge answers.
    pub free: u64,
    /// Questions whose answers the store has.
    pub stored: u64,
    /// Questions whose request is that of another one of the batch: one answer is for both.
    pub repeated: u64,
    /// Questions that cannot be asked.
    pub unaskable: u64,
    /// Why, each reason once, with how many questions it holds for.
    pub why: Vec<(String, u64)>,
    /// Tokens of the requests, estimated.
    pub tokens: u64,
    /// US dollars that are known: the most of requests with a bound, the question alone of those without.
    pub usd: f64,
    /// Requests whose answers nothing bounds.
    pub unbounded: u64,
    /// The most that a million tokens of these answers cost, US dollars.
    pub million: f64,
    /// Rounds of tools that one of these may take at most, which the dollars do not count; 0 without tools.
    pub uncounted_rounds: u32,
    /// Requests without a known price.
    pub unpriced: u64,
    /// What the bounds count beyond listed prices, in words, each once.
    pub bounds: Vec<String>,
}

/// Tokens of an answer that the total is given for where nothing bounds answers.
const ASSUMED_ANSWER: u64 = 1000;

impl Estimate {
    /// The most that all requests cost, US dollars; nothing where that of one is unknown.
    #[must_use]
    pub fn most_usd(&self) -> Option<f64> {
        (self.unbounded == 0 && self.unpriced == 0).then_some(self.usd)
    }

    /// All questions.
    #[must_use]
    pub fn questions(&self) -> u64 {
        self.requests + self.free + self.stored + self.repeated + self.unaskable
    }

    /// Adds a question; `size` is missing where it cannot be asked, for this reason.
    pub fn add(&mut self, size: Option<Size>, why: Option<&str>) {
        let Some(size) = size else {
            self.unaskable += 1;
            let why = why.unwrap_or("no question can be built from it");
            match self.why.iter_mut().find(|(known, _)| known == why) {
                Some((_, count)) => *count += 1,
                None => self.why.push((why.to_string(), 1)),
            }
            return;
        };
        if size.stored {
            self.stored += 1;
            return;
        }
        if size.price == Price::Free {
            self.free += 1;
            return;
        }
        self.requests += 1;
        self.tokens += size.tokens;
        let bound = size.bound.filter(|words| !self.bounds.contains(words));
        self.bounds.extend(bound);
        match size.price {
            Price::AtMost(usd) => self.usd += usd,
            Price::Question { usd, million } => {
                self.usd += usd;
                self.million = self.million.max(million);
                self.unbounded += 1;
                self.uncounted_rounds = self.uncounted_rounds.max(size.rounds);
            }
            Price::Unknown => self.unpriced += 1,
            Price::Free => {}
        }
    }

    /// The total cost in words: a bound, or where nothing bounds the answers an estimate for short ones.
    #[must_use]
    pub fn price(&self) -> String {
        let all = self.requests;
        if all == 0 {
            return "free".into();
        }
        if self.usd == 0.0 && self.unbounded == 0 && self.unpriced == 0 {
            return "free: nothing is paid for these models".into();
        }
        if self.unpriced == all {
            return "no price known; [[provider.NAME.prices]] in config.toml states one".into();
        }
        let mut words = match self.unbounded {
            0 => format!("at most ${:.4}", self.usd),
            n => {
                let answers = self.million * (n * ASSUMED_ANSWER) as f64 / 1e6;
                let rounds = match self.uncounted_rounds {
                    0 => String::new(),
                    n => format!(", without up to {n} rounds of tools each"),
                };
                format!(
                    "${:.4} for the questions, ${:.4} in all if answers take {ASSUMED_ANSWER} tokens each{rounds}; max_tokens sets a limit",
                    self.usd,
                    self.usd + answers
                )
            }
        };
        if self.unpriced > 0 {
            words.push_str(&format!(", without {} of unknown price", self.unpriced));
        }
        words
    }
}
