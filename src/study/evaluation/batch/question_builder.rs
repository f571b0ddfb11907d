//! Builds a batch's questions: from an entry, its settings and variant to the request and the store's record, or a line.

use std::collections::{BTreeSet, VecDeque};
use std::path::Path;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use nearmiss_ask::prompts::{Library, Techniques};
use nearmiss_formats::{EgoSelection, Entry, EntryLocation};
use nearmiss_scene::judge;
use nearmiss_scene::metrics::Thresholds;
use nearmiss_scene::scenario::{Scene, Severity, Transform, Window};
use nearmiss_scene::verdict::{Task, Verdict};
use nearmiss_store::{Item, Key, NewItem, StoreError};
use schemars::JsonSchema;
use serde::Serialize;

use super::experiment::Experiment;
use super::scored::{configuration_of_item, label_of_item};
use super::windows::{default_window, too_short};
use crate::evaluation::ask_model::record;
use crate::evaluation::windows::{Moment, Recording};
use crate::evaluation::{
    AttackTerms, AxisValues, Case, EffectiveSettings, Judge, Label, Labelled, Lead, PromptConfig,
    Protocol, Question, RunOptions, default_frame, prepare, template,
};

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
const CACHE_SIZES: (usize, usize) = (8, 64);

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
            scenes: Recent::new(CACHE_SIZES.0),
            questions: Recent::new(CACHE_SIZES.1),
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
        self.scenes.get(&stored_path(entry), || {
            let scenario = entry.read().map_err(|e| e.to_string())?;
            let ego = self
                .ego
                .resolve(entry, &scenario)
                .map_err(|e| e.to_string())?
                .ok_or(
                    "no recorded ego: add --ego planner, or put NAME.ego_trajectory.csv beside NAME.xml",
                )?;
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
        configuration: &PromptConfig,
        variant: &Variant,
        label: Option<Label>,
    ) -> Result<Arc<Question>, String> {
        // Neither the recipient nor the parameters of the request change the question.
        let whose = PromptConfig {
            model: String::new(),
            settings: AxisValues {
                form: configuration.settings.form,
                stride: configuration.settings.stride,
                ..AxisValues::default()
            },
            ..configuration.clone()
        };
        self.questions
            .get(&(stored_path(entry), whose, *variant), || {
                let scene = self.open(entry)?.scene;
                self.build(entry, scene, configuration, variant, label)
                    .map(Arc::new)
            })
    }

    /// The question of a stored item, and how it is asked.
    ///
    /// # Errors
    /// As [`Self::question`], or a word that this version does not know.
    pub fn question_of_item(
        &self,
        asked: &NewItem,
    ) -> Result<(PromptConfig, Arc<Question>), String> {
        let entry = Entry::of_argument(Path::new(&asked.path));
        let (configuration, variant) = (configuration_of_item(asked)?, Variant::from_item(asked)?);
        let question = self.question(&entry, &configuration, &variant, label_of_item(asked))?;
        Ok((configuration, question))
    }

    fn build(
        &self,
        entry: &Entry,
        scene: Arc<Scene>,
        configuration: &PromptConfig,
        variant: &Variant,
        label: Option<Label>,
    ) -> Result<Question, String> {
        let frame = configuration
            .frame
            .unwrap_or_else(|| default_frame(&self.library, configuration.task));
        let techniques = configuration.techniques.unwrap_or(Techniques::ALL);
        let decided = self.decided(configuration)?;
        let window = self.window(entry, &scene, configuration, variant, label)?;
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
            task: configuration.task,
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
    fn decided(&self, configuration: &PromptConfig) -> Result<EffectiveSettings, String> {
        let frame = configuration
            .frame
            .unwrap_or_else(|| default_frame(&self.library, configuration.task));
        let techniques = configuration.techniques.unwrap_or(Techniques::ALL);
        let (_, chosen) =
            template(&self.library, configuration.task, frame).map_err(|e| e.to_string())?;
        let settings = self.experiment.settings(Some(techniques));
        let settings = configuration.settings.settings(settings);
        Ok(settings.with(&chosen.front.defaults))
    }

    /// Steps in a window of this way of asking, and how far around the ego it is described, metres.
    ///
    /// # Errors
    /// There is no template for it.
    pub fn span(&self, configuration: &PromptConfig) -> Result<(usize, f64), String> {
        let decided = self.decided(configuration)?;
        Ok((decided.history, decided.options.radius))
    }

    /// The steps that a question is about.
    fn window(
        &self,
        entry: &Entry,
        scene: &Scene,
        configuration: &PromptConfig,
        variant: &Variant,
        label: Option<Label>,
    ) -> Result<Window, String> {
        if let Some((first, last)) = variant.window {
            let steps = usize::try_from(last - first + 1).unwrap_or(1);
            return Ok(Window::ending_at(scene, last, steps));
        }
        let history = self.decided(configuration)?.history;
        if self.experiment.protocol == Protocol::Paper {
            let window = Labelled::new(scene, label).paper_window(configuration.task, history);
            return window.ok_or_else(|| too_short(entry, Lead::Paper));
        }
        match (configuration.task, variant.lead.or(self.experiment.lead())) {
            (Task::Safety, Some(lead)) => Labelled::new(scene, label)
                .window(lead, history)
                .ok_or_else(|| too_short(entry, lead)),
            _ => Ok(default_window(configuration.task, scene, history)),
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
        configuration: &PromptConfig,
        variant: &Variant,
        label: Option<Label>,
    ) -> Result<Verdict, String> {
        let window = self.window(entry, scene, configuration, variant, label)?;
        Ok(judge::judge_under(scene, configuration.task, &window, &self.thresholds).verdict)
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
pub fn stored_path(entry: &Entry) -> String {
    match &entry.place {
        EntryLocation::File(path) => path.display().to_string(),
        EntryLocation::Bundled(_) => entry.name.clone(),
    }
}

/// Distinguishes questions about one scenario under the same prompt configuration.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Variant {
    /// End of the window; `None` for the batch's common end.
    pub lead: Option<Lead>,
    /// Change of the scene; `None` if unchanged.
    pub transform: Option<Transform>,
    /// First and last step of the window, where it was drawn; `None` for the one that task and lead give.
    pub window: Option<(i64, i64)>,
}

impl Variant {
    /// The variant of a question of a batch.
    ///
    /// # Errors
    /// A value written by an unknown version.
    pub fn from_item(asked: &NewItem) -> Result<Self, String> {
        let lead = asked.lead.as_deref().map(|word| {
            word.parse()
                .map_err(|why| format!("the lead {word} is not known to this version: {why}"))
        });
        let transform = asked.transform.as_deref().map(|word| {
            word.parse()
                .map_err(|why: nearmiss_scene::scenario::TransformError| why.to_string())
        });
        Ok(Self {
            lead: lead.transpose()?,
            transform: transform.transpose()?,
            window: asked.window,
        })
    }

    /// The lead and the change as stored.
    #[must_use]
    pub fn stored(&self) -> (Option<String>, Option<String>) {
        let lead = self.lead.map(Lead::stored);
        (lead, self.transform.map(|change| change.to_string()))
    }
}

/// The results that were wanted last; what is wanted by several at once is made once.
pub struct Recent<K, V> {
    most: usize,
    kept: Mutex<VecDeque<(K, Arc<OnceLock<V>>)>>,
}

impl<K: PartialEq + Clone, V: Clone> Recent<K, V> {
    /// Keeps at most `most` results.
    pub fn new(most: usize) -> Self {
        Self {
            most,
            kept: Mutex::default(),
        }
    }

    /// The result for `key`, made by `make` where it is not there; others who want the same wait for it.
    pub fn get(&self, key: &K, make: impl FnOnce() -> V) -> V {
        let place = {
            let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
            match kept.iter().position(|(known, _)| known == key) {
                Some(at) => Arc::clone(&kept[at].1),
                None => {
                    let place = Arc::new(OnceLock::new());
                    kept.push_back((key.clone(), Arc::clone(&place)));
                    if kept.len() > self.most {
                        kept.pop_front();
                    }
                    place
                }
            }
        };
        place.get_or_init(make).clone()
    }
}

/// A question.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct QuestionLine {
    /// Name of the scenario.
    pub scenario: String,
    /// File of the scenario, or the name of a bundled one.
    pub file: String,
    /// First 12 digits of the SHA-256 of its content; null where it was not read.
    pub hash: Option<String>,
    /// Where the ego's motion is from; null where it was not read.
    pub ego: Option<String>,
    /// The task.
    pub task: String,
    /// The frame of the description; null for the built-in judge.
    pub frame: Option<String>,
    /// The prompting techniques; null for the built-in judge.
    pub techniques: Option<String>,
    /// Seconds from the end of the window to the contact, `end` for the paper's windows; null without a lead. Of a safe
    /// window, those of the dangerous one that it is like.
    pub lead: serde_json::Value,
    /// Values of the axes of the batch, such as `form compact`; null without axes.
    pub settings: Option<String>,
    /// What is changed about the scene; null for the scene as it is.
    pub transform: Option<String>,
    /// What is true: `dangerous` or `safe`; null where that is unknown.
    pub label: Option<&'static str>,
    /// Obstacles that the ego touches in the window or within the horizon after it, the first one first.
    pub critical: Vec<i64>,
    /// First time step of the window in the recording.
    pub first_step: i64,
    /// Its last one.
    pub last_step: i64,
    /// Obstacles near the ego at one of its steps.
    pub obstacles: u64,
    /// The ego's speed at its end, m/s.
    pub ego_speed: f64,
    /// Tokens of the question, estimated.
    pub tokens: u64,
    /// SHA-256 of the template and its fragments.
    pub template_hash: String,
}

impl QuestionLine {
    /// Every question once, however many models are asked and however often; those that cannot be asked are left out.
    #[must_use]
    pub fn of_items(items: &[NewItem]) -> Vec<Self> {
        let mut once = BTreeSet::new();
        let mut lines = Vec::new();
        for item in items {
            let Some(facts) = &item.facts else { continue };
            let how = (item.frame.as_deref(), item.techniques.as_deref());
            let which = (
                item.settings.as_deref(),
                item.lead.as_deref(),
                item.transform.as_deref(),
                facts.steps,
            );
            if !once.insert((&item.path, item.task, how, which)) {
                continue;
            }
            lines.push(Self {
                scenario: item.scenario.clone(),
                file: item.path.clone(),
                hash: item
                    .scenario_hash
                    .as_ref()
                    .map(|hash| hash.chars().take(12).collect()),
                ego: item.ego.clone(),
                task: item.task.name().into(),
                frame: item.frame.clone(),
                techniques: item.techniques.clone(),
                lead: lead(item.lead.as_deref()),
                settings: item.settings.clone(),
                transform: item.transform.clone(),
                label: item
                    .collides
                    .map(|collides| if collides { "dangerous" } else { "safe" }),
                critical: match item.collides {
                    Some(true) => facts.critical.clone(),
                    _ => Vec::new(),
                },
                first_step: facts.steps.0,
                last_step: facts.steps.1,
                obstacles: facts.obstacles,
                ego_speed: facts.speed,
                tokens: facts.tokens,
                template_hash: facts.template_hash.clone(),
            });
        }
        lines
    }
}

/// A number of seconds, or the word.
fn lead(stored: Option<&str>) -> serde_json::Value {
    match stored.map(str::parse::<Lead>) {
        Some(Ok(Lead::Seconds(seconds))) => seconds.into(),
        Some(Ok(lead)) => lead.to_string().into(),
        _ => serde_json::Value::Null,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_wanted_lately_is_made_once() {
        let recent = Recent::new(2);
        let made = std::cell::Cell::new(0);
        let get = |key: u8| {
            recent.get(&key, || {
                made.set(made.get() + 1);
                key * 10
            })
        };
        assert_eq!([get(1), get(2), get(1)], [10, 20, 10]);
        assert_eq!(made.get(), 2);
        assert_eq!(
            [get(3), get(1)],
            [30, 10],
            "1 was there longest, and is gone"
        );
        assert_eq!(made.get(), 4);
    }
}
