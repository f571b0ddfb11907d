//! Builds a batch's questions: from an entry and its settings to the request and the store's record.

use std::sync::Arc;

use super::experiment::Experiment;
use super::recent::Recent;
use super::variant::Variant;
use super::windows::{default_window, too_short};
use crate::evaluation::request::record;
use crate::evaluation::windows::{Moment, Recording};
use crate::evaluation::{
    AttackTerms, AxisValues, Case, EffectiveSettings, Judge, Label, Labelled, Lead, PromptConfig,
    Protocol, Question, RunOptions, default_frame, prepare, template,
};
use nearmiss_ask::prompts::{Library, Techniques};
use nearmiss_formats::{EgoSelection, Entry, EntryLocation};
use nearmiss_scene::judge;
use nearmiss_scene::metrics::Thresholds;
use nearmiss_scene::scenario::{Scene, Severity, Window};
use nearmiss_scene::verdict::{Task, Verdict};
use nearmiss_store::{Item, Key, StoreError};

/// Shared inputs of all questions in a batch.
pub struct QuestionBuilder {
    /// The templates.
    library: Library,
    /// Thresholds of the risk scores.
    pub(super) thresholds: Arc<Thresholds>,
    /// How all are asked.
    pub(super) experiment: Experiment,
    /// The ego of scenarios.
    ego: EgoSelection,
    scenes: Recent<String, Result<Reading, String>>,
    questions: Recent<QuestionId, Result<Arc<Question>, String>>,
}

/// Identity of a question: the scenario, the prompt configuration, the lead and the change.
type QuestionId = (String, PromptConfig, Variant);

/// A scenario that was opened, with its recorded ego.
#[derive(Debug, Clone)]
pub struct Reading {
    /// The scene.
    pub scene: Arc<Scene>,
    /// Warnings about its ego.
    pub doubts: Vec<String>,
}

/// Scenes that are kept in memory at once, and questions.
const KEPT: (usize, usize) = (8, 64);

impl QuestionBuilder {
    /// A builder with these templates.
    #[must_use]
    pub fn new(
        library: Library,
        thresholds: Arc<Thresholds>,
        experiment: Experiment,
        ego: EgoSelection,
    ) -> Self {
        Self {
            library,
            thresholds,
            experiment,
            ego,
            scenes: Recent::new(KEPT.0),
            questions: Recent::new(KEPT.1),
        }
    }

    /// Thresholds of the risk scores.
    #[must_use]
    pub fn thresholds(&self) -> &Thresholds {
        &self.thresholds
    }

    /// How far after a window its truth looks, seconds.
    pub(super) fn horizon(&self) -> f64 {
        self.experiment.within.unwrap_or(Case::HORIZON)
    }

    /// The scenario of an entry with its ego.
    ///
    /// # Errors
    /// In words: it, or its ego, cannot be read, or there is none.
    pub fn open(&self, entry: &Entry) -> Result<Reading, String> {
        self.scenes.get(&path_of(entry), || {
            let scenario = entry.read().map_err(|e| e.to_string())?;
            let ego = self
                .ego
                .resolve(entry, &scenario)
                .map_err(|e| e.to_string())?
                .ok_or_else(|| {
                    format!(
                        "{}: no recorded ego; put NAME.ego_trajectory.csv beside NAME.xml",
                        entry.display()
                    )
                })?;
            let doubts = ego
                .diagnostics
                .iter()
                .filter(|doubt| doubt.severity == Severity::Warning)
                .map(|doubt| format!("ego {}: {}", ego.source, doubt.message))
                .collect();
            Ok(Reading {
                scene: Arc::new(Scene::new(scenario, ego)),
                doubts,
            })
        })
    }

    /// The question about an entry, or a variant of it, that is asked this way; `label` is what is true about it, where
    /// leads count from.
    ///
    /// # Errors
    /// In words: it cannot be opened, or no prompt can be made of it.
    pub fn question(
        &self,
        entry: &Entry,
        way: &PromptConfig,
        variant: &Variant,
        label: Option<Label>,
    ) -> Result<Arc<Question>, String> {
        // Neither the recipient nor the parameters of the request change the question.
        let whose = PromptConfig {
            model: String::new(),
            settings: AxisValues {
                form: way.settings.form,
                stride: way.settings.stride,
                ..AxisValues::default()
            },
            ..way.clone()
        };
        self.questions.get(&(path_of(entry), whose, *variant), || {
            let scene = self.open(entry)?.scene;
            self.made(entry, scene, way, variant, label).map(Arc::new)
        })
    }

    fn made(
        &self,
        entry: &Entry,
        scene: Arc<Scene>,
        way: &PromptConfig,
        variant: &Variant,
        label: Option<Label>,
    ) -> Result<Question, String> {
        let frame = way
            .frame
            .unwrap_or_else(|| default_frame(&self.library, way.task));
        let techniques = way.techniques.unwrap_or(Techniques::ALL);
        let decided = self.decided(way)?;
        let window = self.window(entry, &scene, way, variant, label)?;
        let (name, scene) = match variant.transform {
            None => (entry.name.clone(), scene),
            Some(change) => {
                let changed = change.apply(&scene).scene;
                (change.name(&entry.name), Arc::new(changed))
            }
        };
        let case = Case {
            name,
            scene,
            task: way.task,
            frame,
            techniques,
            window,
            options: decided.options,
            thresholds: Arc::clone(&self.thresholds),
            horizon: self.horizon(),
            attack: AttackTerms::default(),
        };
        prepare(case, &self.library, None).map_err(|e| e.to_string())
    }

    /// How a way asks: as the batch says, else as its template does.
    fn decided(&self, way: &PromptConfig) -> Result<EffectiveSettings, String> {
        let frame = way
            .frame
            .unwrap_or_else(|| default_frame(&self.library, way.task));
        let techniques = way.techniques.unwrap_or(Techniques::ALL);
        let (_, chosen) = template(&self.library, way.task, frame).map_err(|e| e.to_string())?;
        let settings = self.experiment.settings(Some(techniques));
        let settings = way.settings.settings(settings);
        Ok(settings.with(&chosen.front.defaults))
    }

    /// Steps in a window of this way of asking, and how far around the ego it is described, metres.
    ///
    /// # Errors
    /// There is no template for it.
    pub fn span(&self, way: &PromptConfig) -> Result<(usize, f64), String> {
        let decided = self.decided(way)?;
        Ok((decided.history, decided.options.radius))
    }

    /// The steps that a question is about.
    fn window(
        &self,
        entry: &Entry,
        scene: &Scene,
        way: &PromptConfig,
        variant: &Variant,
        label: Option<Label>,
    ) -> Result<Window, String> {
        if let Some((first, last)) = variant.window {
            let steps = usize::try_from(last - first + 1).unwrap_or(1);
            return Ok(Window::ending_at(scene, last, steps));
        }
        let history = self.decided(way)?.history;
        if self.experiment.protocol == Protocol::Paper {
            let window = Labelled::new(scene, label).paper_window(way.task, history);
            return window.ok_or_else(|| too_short(entry, Lead::Paper));
        }
        match (way.task, variant.lead.or(self.experiment.lead())) {
            (Task::Safety, Some(lead)) => Labelled::new(scene, label)
                .window(lead, history)
                .ok_or_else(|| too_short(entry, lead)),
            _ => Ok(default_window(way.task, scene, history)),
        }
    }

    /// What is true about a drawn window where its scenario has this label; the label itself where it cannot be opened.
    pub(super) fn window_truth(
        &self,
        entry: &Entry,
        item: &Item,
        label: Label,
        (first, last): (i64, i64),
    ) -> (Label, Vec<i64>) {
        let (Ok(reading), Some(horizon)) = (self.open(entry), self.experiment.within) else {
            return (label, label.critical());
        };
        let scene = &reading.scene;
        let moment = match item.asked.task {
            Task::Collision => Moment::Contact,
            _ => Moment::Before(Lead::Seconds(0.0)),
        };
        let steps = usize::try_from(last - first + 1).unwrap_or(1);
        let window = Window::ending_at(scene, last, steps);
        let case = Labelled::new(scene, Some(label));
        let recording = Recording::new(&entry.name, &case, self.experiment.radius.unwrap_or(0.0));
        recording.truth(moment, &window, horizon)
    }

    /// The built-in judge's verdict on the same steps of the unchanged scene.
    ///
    /// # Errors
    /// In words: there is no template, or the recording is too short.
    pub(super) fn judged(
        &self,
        entry: &Entry,
        scene: &Scene,
        way: &PromptConfig,
        variant: &Variant,
        label: Option<Label>,
    ) -> Result<Verdict, String> {
        let window = self.window(entry, scene, way, variant, label)?;
        Ok(judge::judge_under(scene, way.task, &window, &self.thresholds).verdict)
    }
}

/// The key of the request that a question is to a judge; `None` if none is sent.
///
/// # Errors
/// Something cannot be written as JSON.
pub fn question_key(question: &Question, judge: &Judge) -> Result<Option<Key>, StoreError> {
    Ok(record(question, judge, &RunOptions::default())?.key())
}

/// The colliding obstacle, if a label names one.
pub(super) fn obstacle(label: Option<Label>) -> Option<i64> {
    match label {
        Some(Label::Collision(obstacle)) => obstacle,
        _ => None,
    }
}

/// The stored path of an entry: its file, or the name of a bundled scenario.
#[must_use]
pub fn path_of(entry: &Entry) -> String {
    match &entry.place {
        EntryLocation::File(path) => path.display().to_string(),
        EntryLocation::Bundled(_) => entry.name.clone(),
    }
}
