//! The drawn windows of a batch's questions, and what is known of each beside its label.

use std::collections::{BTreeMap, BTreeSet};

use nearmiss_drive::planner::Cancel;
use nearmiss_formats::Entry;
use nearmiss_scene::description::Frame;
use nearmiss_scene::metrics::{Context, MEASURES, RiskConvention};
use nearmiss_scene::scenario::{Scene, Window};
use nearmiss_scene::verdict::Task;
use nearmiss_store::{Item, SplitPart, WindowFacts};
use rayon::prelude::*;

use super::experiment::Experiment;
use super::matrix::Split;
use super::question_builder::{QuestionBuilder, stored_path};
use super::scored::{configuration_of_item, label_of_item};
use super::truth::Truth;
use crate::evaluation::windows::{Moment, Recording, Sampling, Traffic};
use crate::evaluation::{CriticalMoments, Label, Labelled, Lead, PromptConfig, Question};

/// A window to ask about, and what is true about it.
#[derive(Debug, Clone, PartialEq)]
pub struct AskedWindow {
    /// First and last time step.
    pub steps: (i64, i64),
    /// Whether it is dangerous.
    pub label: Label,
    /// Obstacles that the ego touches in it or within the horizon after it, or those of extreme risk.
    pub critical: Vec<i64>,
}

impl AskedWindow {
    /// The drawn window of a stored question, where it has one and its truth is known.
    #[must_use]
    pub fn of_item(item: &Item) -> Option<Self> {
        let (steps, label) = (item.asked.window?, label_of_item(&item.asked)?);
        Some(Self {
            steps,
            label,
            critical: critical_obstacles(label, item.asked.facts.as_ref()),
        })
    }
}

/// What windows are drawn from.
pub struct WindowSource<'a> {
    /// What is asked.
    pub experiment: &'a Experiment,
    /// About which scenarios.
    pub entries: &'a [Entry],
    /// What opens them.
    pub builder: &'a QuestionBuilder,
    /// Windows are drawn for each part of this split alone.
    pub split: Option<Split>,
    /// A wish that it ends early.
    pub cancel: &'a Cancel,
}

/// Recordings, each with the path of its scenario.
type Recordings = Vec<(String, Recording)>;

/// What windows are drawn for: the frame matters, as its template may say how many steps a window has.
type Slot = (Task, Option<Frame>, Option<String>);

/// The windows of a batch, by slot and by path of the scenario.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct BatchWindows(BTreeMap<Slot, BTreeMap<String, Vec<AskedWindow>>>);

impl BatchWindows {
    /// Draws the windows of a matrix, and says what is left out; none where the matrix asks about the ends of recordings.
    /// Nothing where the source is cancelled; `on_read` hears how many of how many recordings are read.
    #[must_use]
    pub fn draw(
        source: &WindowSource<'_>,
        truth: &Truth,
        on_read: &mut dyn FnMut(usize, usize),
    ) -> Option<(Self, Option<String>)> {
        let mut drawn = Self::default();
        let left_out = drawn.add(source, truth, on_read)?;
        Some((drawn, left_out))
    }

    /// The windows that a stored batch has. Where windows were drawn for a task, a scenario without a question of it was
    /// left out, and stays so.
    ///
    /// # Errors
    /// A word that this version does not know.
    pub fn of_items(items: &[Item]) -> Result<Self, String> {
        let mut found = Self::default();
        let mut without_window: BTreeSet<(Slot, &str)> = BTreeSet::new();
        for item in items {
            let asked = &item.asked;
            let configuration = configuration_of_item(asked)?;
            let slot = (configuration.task, configuration.frame, asked.lead.clone());
            if asked.window.is_none() {
                without_window.insert((slot, &asked.path));
                continue;
            }
            // A window without a truth is asked about once more only when it has one.
            let Some(window) = AskedWindow::of_item(item) else {
                continue;
            };
            let of_slot = found.0.entry(slot).or_default();
            let of_path = of_slot.entry(asked.path.clone()).or_default();
            if !of_path.contains(&window) {
                of_path.push(window);
            }
        }
        let paths: BTreeSet<&str> = items.iter().map(|item| item.asked.path.as_str()).collect();
        for (slot, by_path) in &mut found.0 {
            for &path in &paths {
                if !without_window.contains(&(slot.clone(), path)) {
                    by_path.entry(path.to_string()).or_default();
                }
            }
        }
        Ok(found)
    }

    /// Draws what is missing for a matrix, as [`BatchWindows::draw`] does.
    pub fn add(
        &mut self,
        source: &WindowSource<'_>,
        truth: &Truth,
        on_read: &mut dyn FnMut(usize, usize),
    ) -> Option<Option<String>> {
        let experiment = source.experiment;
        let Some(horizon) = experiment.within else {
            return Some(None);
        };
        let wanted = self.wanted(source, truth.convention());
        let of = wanted.len() * source.entries.len();
        let mut without: BTreeSet<String> = BTreeSet::new();
        let mut not_scored: BTreeSet<String> = BTreeSet::new();
        for (round, ((history, radius, by_score), slots)) in wanted.into_iter().enumerate() {
            let before = round * source.entries.len();
            let radius = f64::from_bits(radius);
            let moments = truth.convention().filter(|_| by_score);
            let reading = (truth, moments, radius);
            let (recordings, unscored) =
                source.recordings(reading, &mut |done| on_read(before + done, of))?;
            not_scored.extend(unscored.iter().cloned());
            let parts = source.parts(recordings);
            for (slot, moment) in slots {
                if source.cancel.is_asked() {
                    return None;
                }
                let sampling = Sampling {
                    moment,
                    history,
                    horizon,
                    every_recording: experiment.every_scenario,
                };
                let mut by_path: BTreeMap<String, Vec<AskedWindow>> = BTreeMap::new();
                for (paths, known) in &parts {
                    for (path, recording) in paths.iter().zip(known) {
                        // A collision that begins too late for its lead is asked about all the same, to say why it
                        // cannot.
                        if !recording.collides() {
                            by_path.entry(path.clone()).or_default();
                        }
                    }
                    for one in sampling.draw(known) {
                        let of_path = by_path.entry(paths[one.recording].clone());
                        of_path.or_default().push(AskedWindow {
                            steps: (one.window.first(), one.window.last()),
                            label: one.label,
                            critical: one.critical,
                        });
                    }
                }
                let empty = by_path.iter().filter(|(_, windows)| windows.is_empty());
                without.extend(empty.map(|(path, _)| path.clone()));
                // A window whose truth cannot be known is not worth an answer.
                by_path.extend(unscored.iter().map(|path| (path.clone(), Vec::new())));
                self.0.insert(slot, by_path);
            }
        }
        let asked = |path: &String| {
            let mut slots = self.0.values();
            slots.any(|by_path| by_path.get(path).is_some_and(|windows| !windows.is_empty()))
        };
        without.retain(|path| !asked(path));
        let words = [
            left_out(without.len(), experiment),
            without_score(&not_scored),
        ];
        let words: Vec<String> = words.into_iter().flatten().collect();
        Some((!words.is_empty()).then(|| words.join("; ")))
    }

    /// The slots without windows, by number of steps, radius, and whether a risk score tells what is dangerous.
    fn wanted(
        &self,
        source: &WindowSource<'_>,
        score: Option<RiskConvention>,
    ) -> BTreeMap<(usize, u64, bool), Vec<(Slot, Moment)>> {
        let mut wanted: BTreeMap<(usize, u64, bool), Vec<(Slot, Moment)>> = BTreeMap::new();
        for configuration in source.experiment.configurations() {
            let Ok((history, radius)) = source.builder.span(&configuration) else {
                continue;
            };
            for (slot, moment) in slots(source.experiment, &configuration) {
                // Contact is contact by any score.
                let by_score = score.is_some() && moment != Moment::Contact;
                let span = (history, radius.to_bits(), by_score);
                let of_span = wanted.entry(span).or_default();
                if !self.0.contains_key(&slot) && of_span.iter().all(|(other, _)| *other != slot) {
                    of_span.push((slot, moment));
                }
            }
        }
        wanted.retain(|_, slots| !slots.is_empty());
        wanted
    }

    /// The windows of a scenario for a way of asking at a lead; `None` where none are drawn, and the window is that of
    /// task and lead.
    #[must_use]
    pub fn get(
        &self,
        configuration: &PromptConfig,
        lead: Option<Lead>,
        path: &str,
    ) -> Option<&[AskedWindow]> {
        let slot = (
            configuration.task,
            configuration.frame,
            lead.map(Lead::stored),
        );
        self.0.get(&slot)?.get(path).map(Vec::as_slice)
    }
}

/// What is asked about with a way.
fn slots(experiment: &Experiment, configuration: &PromptConfig) -> Vec<(Slot, Moment)> {
    match configuration.task {
        Task::Safety => {
            let slot = |lead: &Lead| {
                (
                    (configuration.task, configuration.frame, Some(lead.stored())),
                    Moment::Before(*lead),
                )
            };
            experiment.leads.iter().map(slot).collect()
        }
        Task::Collision => vec![(
            (configuration.task, configuration.frame, None),
            Moment::Contact,
        )],
        // The window is the whole recording.
        Task::Recording | Task::Attacker | Task::Trajectory => Vec::new(),
    }
}

/// How many safe scenarios have no window, and why.
fn left_out(scenarios: usize, experiment: &Experiment) -> Option<String> {
    let horizon = experiment.within?;
    let unlike = if experiment.every_scenario {
        ""
    } else {
        ", or unlike the dangerous windows; --set every_scenario=on asks about those, too"
    };
    let are = match scenarios {
        0 => return None,
        1 => "1 safe scenario is".to_string(),
        n => format!("{n} safe scenarios are"),
    };
    Some(format!(
        "{are} not asked about: too short for a window and the {horizon} s after it{unlike}"
    ))
}

/// Which scenarios have no risk score.
fn without_score(paths: &BTreeSet<String>) -> Option<String> {
    let first = paths.first()?;
    let are = match paths.len() {
        1 => "1 scenario is".to_string(),
        n => format!("{n} scenarios are"),
    };
    Some(format!(
        "{are} not asked about: numbers too large for the paper's risk score ({first}{})",
        if paths.len() > 1 { ", …" } else { "" }
    ))
}

/// Recordings that are read between two looks at whether to go on, for each core.
const AT_ONCE: usize = 4;

impl WindowSource<'_> {
    /// The recordings and their paths by part of the split: safe windows of one part are never matched to dangerous
    /// ones of the other.
    fn parts(&self, recordings: Vec<(String, Recording)>) -> Vec<(Vec<String>, Vec<Recording>)> {
        let Some(split) = self.split else {
            return vec![recordings.into_iter().unzip()];
        };
        let of_path = self.entries.iter();
        let of_path: BTreeMap<String, SplitPart> = of_path
            .map(|entry| (stored_path(entry), split.part(&entry.name)))
            .collect();
        let (dev, test): (Vec<_>, Vec<_>) = recordings
            .into_iter()
            .partition(|(path, _)| of_path.get(path) == Some(&SplitPart::Dev));
        [dev, test]
            .map(|part| part.into_iter().unzip())
            .into_iter()
            .collect()
    }

    /// The recordings with a label, by path, and the paths of those without the risk score that is the truth; those that
    /// cannot be opened are left out. Nothing where it is cancelled.
    fn recordings(
        &self,
        (truth, score, radius): (&Truth, Option<RiskConvention>, f64),
        on_read: &mut dyn FnMut(usize),
    ) -> Option<(Recordings, Vec<String>)> {
        let of = |entry: &Entry| {
            let scene = self.builder.open(entry).ok()?.scene;
            let recording = match score {
                Some(convention) => {
                    let moments =
                        CriticalMoments::new(convention, &scene, self.builder.thresholds());
                    let Ok(moments) = moments else {
                        return Some((stored_path(entry), None));
                    };
                    moments.recording(&entry.name, &scene, radius)
                }
                None => {
                    let label = truth.label(entry, Some(&scene))?;
                    let case = Labelled::new(&scene, Some(label));
                    Recording::new(&entry.name, &case, radius)
                }
            };
            Some((stored_path(entry), Some(recording)))
        };
        let mut found: Vec<(String, Option<Recording>)> = Vec::with_capacity(self.entries.len());
        let mut done = 0;
        for part in self.entries.chunks(AT_ONCE * rayon::current_num_threads()) {
            if self.cancel.is_asked() {
                return None;
            }
            found.par_extend(part.par_iter().filter_map(of));
            done += part.len();
            on_read(done);
        }
        let unscored = found
            .iter()
            .filter(|(_, recording)| recording.is_none())
            .map(|(path, _)| path.clone())
            .collect();
        let scored = found
            .into_iter()
            .filter_map(|(path, recording)| Some((path, recording?)));
        Some((scored.collect(), unscored))
    }
}

/// Whom the ego touches in truth: as the question knows it, or where the label names another obstacle, that.
#[must_use]
pub fn critical_obstacles(label: Label, facts: Option<&WindowFacts>) -> Vec<i64> {
    let touched = facts.map_or(&[][..], |facts| &facts.critical);
    match label {
        Label::Safe => Vec::new(),
        Label::Collision(Some(id)) if !touched.contains(&id) => vec![id],
        Label::Collision(_) => touched.to_vec(),
    }
}

/// The window of a task by default, of so many steps: the end of the recording, for the safety task
/// [`Window::AFTER_SAFETY`] steps before it.
pub(super) fn default_window(task: Task, scene: &Scene, history: usize) -> Window {
    let last = match task {
        Task::Recording => return Window::full(scene),
        Task::Collision => scene.last_step(),
        Task::Safety | Task::Attacker | Task::Trajectory => {
            scene.last_step() - Window::AFTER_SAFETY
        }
    };
    Window::ending_at(scene, last, history)
}

/// Why a window of this lead cannot be asked about.
pub(super) fn too_short(entry: &Entry, lead: Lead) -> String {
    format!(
        "{}: the recording begins later than {lead} s before the collision",
        entry.display()
    )
}

/// What trivial rules look at in a window.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct RuleValues {
    nearest: Option<f64>,
    ttc: Option<f64>,
}

impl RuleValues {
    /// Least distance in a window, metres, and least time to collision at its end, seconds.
    pub fn new(scene: &Scene, window: &Window) -> Self {
        let context = Context::new(scene);
        let least = |id: &str, steps: std::ops::RangeInclusive<i64>| {
            let measure = MEASURES.iter().find(|measure| measure.id == id)?;
            let pairs = (0..context.participants().len())
                .flat_map(|place| steps.clone().map(move |step| (place, step)));
            let values = pairs.filter_map(|(place, step)| {
                measure.evaluate(&context.encounter(place, step)?).value()
            });
            values.min_by(f64::total_cmp)
        };
        Self {
            nearest: least("distance", window.first()..=window.last()),
            ttc: least("ttc", window.last()..=window.last()),
        }
    }
}

/// What is known of a question's window.
pub(super) fn facts(question: &Question, critical: Vec<i64>, values: RuleValues) -> WindowFacts {
    let case = &question.case;
    let traffic = Traffic::in_window(&case.scene, &case.window, case.options.radius);
    WindowFacts {
        steps: (case.window.first(), case.window.last()),
        critical,
        obstacles: traffic.obstacles as u64,
        speed: traffic.speed,
        nearest: values.nearest,
        ttc: values.ttc,
        tokens: question.tokens() as u64,
        template_hash: question.template_hash.clone(),
    }
}
