//! The questions about a scenario, as a batch stores them, and which of them are answered already.

use std::collections::HashMap;
use std::sync::Arc;

use super::estimate::Size;
use super::question_builder::{QuestionBuilder, obstacle, path_of, question_key};
use super::truth::Truth;
use super::variant::Variant;
use super::window_facts::{RuleValues, facts};
use super::windows::AskedWindow;
use crate::evaluation::recorded_answer::has_answer;
use crate::evaluation::{AxisValues, Judges, Label, LabelError, PromptConfig, Question};
use nearmiss_formats::Entry;
use nearmiss_scene::scenario::Window;
use nearmiss_scene::verdict::Task;
use nearmiss_store::{NewItem, Store, StoreError};

/// A way of asking and the answers that are wanted of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Ask {
    /// How it is asked.
    pub way: PromptConfig,
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
            let scored = |ask: &Ask| ask.way.task != Task::Collision;
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
            let question = self.question(entry, &ask.way, &ask.variant, label);
            let judge = &*judges[&ask.way.model].under(&ask.way.settings);
            let (key, size) = match &question {
                Ok(question) => (
                    question_key(question, judge)?,
                    Some(Size::estimate(question, judge)),
                ),
                Err(_) => (None, None),
            };
            let (lead, transform) = ask.variant.words();
            let told = match (&ask.truth, &question) {
                (Some(truth), _) => Some((truth.label, truth.critical.clone())),
                (None, Ok(question)) => {
                    let (task, window) = (ask.way.task, question.case.window);
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
                        *model == ask.way.model && *settings == ask.way.settings
                    })
                {
                    let (model, settings) = (ask.way.model.clone(), ask.way.settings);
                    prepared.first.push((model, settings, Arc::clone(question)));
                }
                let item = NewItem {
                    path: path_of(entry),
                    scenario: entry.name.clone(),
                    scenario_hash: scene.map(|scene| scene.scenario.hash.to_string()),
                    ego: scene.map(|scene| scene.ego.to_string()),
                    task: ask.way.task,
                    frame: ask.way.frame.map(|frame| frame.name().to_string()),
                    techniques: ask.way.techniques.map(|techniques| techniques.to_string()),
                    model: ask.way.model.clone(),
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
                    settings: ask.way.settings.words(),
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
