//! What is true about stored answers, gathered once for reports and the results screen, and how they were asked.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use nearmiss_formats::{EgoSelection, Entry};
use nearmiss_scene::judge::{self, judge_under};
use nearmiss_scene::metrics::{RiskConvention, Thresholds};
use nearmiss_scene::scenario::{Scene, Transform, Window, obstacle_taken};
use nearmiss_scene::verdict::{Task, Verdict};
use nearmiss_store::{BatchId, Outcome, RunId, Store, StoreError};
use nearmiss_study::evaluation::batch::{self, Spec, TruthSource};
use nearmiss_study::evaluation::report::{
    AskedAs, BatchTruth, QuestionKey, RecordedScene, ScoreKey, Truth,
};
use nearmiss_study::evaluation::{Case, CriticalMoments, Label, Labelled};
use rayon::prelude::*;

use super::{OpenRequest, StandIn, open};

/// What answers are compared with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum TruthChoice {
    /// Labels, and where there are none the exact geometry of recordings: what reports use, too.
    #[default]
    Usual,
    /// Labels alone.
    Labels,
    /// The exact geometry of whole recordings alone.
    Recorded,
    /// The risk score of time and distance to a collision: what is of extreme risk is critical.
    Score(RiskConvention),
    /// The built-in judge's verdict on the same question: for the safety task a prediction.
    Judge,
}

impl TruthChoice {
    /// In a few words.
    #[must_use]
    pub fn label(self) -> &'static str {
        match self {
            Self::Score(RiskConvention::Exact) => "risk score of TTC and MDC, exact",
            Self::Score(RiskConvention::Paper) => "risk score of TTC and MDC, the paper's",
            Self::Usual => "labels, else recordings",
            Self::Labels => "labels",
            Self::Recorded => "recordings (exact geometry)",
            Self::Judge => "built-in judge's verdict",
        }
    }
}

/// Where the truth about stored answers is looked for.
#[derive(Debug, Clone, Copy)]
pub struct TruthSearch<'a> {
    /// The answers.
    pub outcomes: &'a [Outcome],
    /// Files that may be their scenarios.
    pub entries: &'a [Entry],
    /// The ego of scenarios, where an answer is not about an obstacle taken as the ego.
    pub ego: &'a EgoSelection,
    /// Thresholds of the built-in judge.
    pub thresholds: &'a Thresholds,
}

/// Files that may hold a scene, and answers about it.
type AskedScene<'a> = (Vec<&'a Entry>, Vec<&'a Outcome>);

/// Truths from batches, by run.
type BatchTruths = HashMap<RunId, BatchTruth>;

/// What batches say is true about their runs.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct BatchLabels {
    /// Of runs about windows that were drawn: no other truth counts for these.
    pub windows: BatchTruths,
    /// Of all runs.
    pub all: BatchTruths,
    /// Those of them that are not worked out by geometry.
    pub declared: BatchTruths,
}

/// What batches say is true about their runs.
///
/// # Errors
/// The store cannot be read.
pub fn batch_labels(store: &Store) -> Result<BatchLabels, StoreError> {
    let batches = store.batches()?.into_iter();
    let sources: HashMap<String, TruthSource> = batches
        .filter_map(|(batch, _)| {
            let spec = Spec::from_json(&batch.spec).ok()?;
            Some((batch.id.to_string(), spec.truth().clone()))
        })
        .collect();
    let mut labels = BatchLabels::default();
    for one in store.truths()? {
        let label = if one.collides {
            Label::Collision(one.obstacle)
        } else {
            Label::Safe
        };
        let batch = one.batch.to_string();
        let source = sources.get(&batch);
        let computed = matches!(source, Some(TruthSource::Geometry | TruthSource::Score(_)));
        let truth = BatchTruth {
            batch,
            label,
            critical: batch::critical_obstacles(label, one.facts.as_ref()),
            by_score: source.is_some_and(|source| source.is_score(one.task)),
        };
        if one.drawn {
            labels.windows.insert(one.run, truth.clone());
        }
        if !computed {
            labels.declared.insert(one.run, truth.clone());
        }
        labels.all.insert(one.run, truth);
    }
    Ok(labels)
}

impl TruthSearch<'_> {
    /// What is known without opening a scenario, and the choices that make sense: the built-in judge's prediction is
    /// not offered where there are labels.
    ///
    /// # Errors
    /// The store cannot be read.
    pub fn stored(
        &self,
        store: &Store,
        choice: TruthChoice,
    ) -> Result<(Truth, Vec<TruthChoice>), StoreError> {
        use TruthChoice::{Judge, Labels, Recorded, Score, Usual};
        let BatchLabels {
            windows,
            all,
            declared,
        } = batch_labels(store)?;
        let layout = self.layout();
        let labelled = !layout.is_empty()
            || self
                .outcomes
                .iter()
                .any(|one| declared.contains_key(&one.run));
        let mut choices = if labelled {
            vec![Usual, Labels, Recorded]
        } else {
            vec![Usual, Recorded, Judge]
        };
        choices.extend([RiskConvention::Exact, RiskConvention::Paper].map(Score));
        let mut truth = Truth {
            windows,
            asked: asked_as(store)?,
            ..Truth::default()
        };
        match choice {
            Usual => (truth.of_batches, truth.layout) = (all, layout),
            Labels => (truth.of_batches, truth.layout) = (declared, layout),
            Recorded => {}
            Judge => truth.judge = Some(self.judged()),
            Score(_) => truth.scores = Some(HashMap::new()),
        }
        if matches!(choice, Usual | Recorded) {
            truth.add_stored_geometry(self.outcomes);
        }
        Ok((truth, choices))
    }

    /// The labels of the folders that the scenarios of the answers lie in.
    #[must_use]
    pub fn layout(&self) -> BTreeMap<String, Label> {
        let asked: BTreeSet<&str> = self.outcomes.iter().map(unchanged_name).collect();
        let entries = self.entries.iter();
        let entries: Vec<Entry> = entries
            .filter(|entry| asked.contains(entry.name.as_str()))
            .cloned()
            .collect();
        let Ok((labels, _)) = batch::Truth::open(&TruthSource::Layout, &entries) else {
            return BTreeMap::new();
        };
        let label = |entry: &Entry| Some((entry.name.clone(), labels.label(entry, None)?));
        entries.iter().filter_map(label).collect()
    }

    /// The built-in judge's stored verdicts, the newest of each question.
    fn judged(&self) -> HashMap<QuestionKey, Verdict> {
        let runs = self.outcomes.iter().filter(|one| one.model == judge::MODEL);
        let verdict = |one: &Outcome| {
            let verdict = serde_json::from_str(one.verdict.as_deref()?).ok()?;
            Some((QuestionKey::from(one), verdict))
        };
        runs.filter_map(verdict).collect()
    }

    /// Opens the scenarios of answers about which nothing is known yet and adds what is true about them; `on_progress`
    /// hears how many of how many are done. Ends early, with `false`, when told to stop.
    #[must_use]
    pub fn complete(
        &self,
        choice: TruthChoice,
        truth: &mut Truth,
        stop: &AtomicBool,
        on_progress: &(dyn Fn(usize, usize) + Sync),
    ) -> bool {
        if choice == TruthChoice::Labels {
            return true;
        }
        let wanted = self.wanted(truth);
        let known = &*truth;
        let (done, of) = (AtomicUsize::new(0), wanted.len());
        let found: Vec<_> = wanted
            .into_par_iter()
            .flat_map_iter(|(files, asked)| {
                let found = if stop.load(Ordering::Relaxed) {
                    Vec::new()
                } else {
                    match choice {
                        TruthChoice::Judge => self.verdicts(&files, &asked),
                        TruthChoice::Score(convention) => {
                            self.scores(convention, &files, &asked, known)
                        }
                        _ => self.recorded(&files, &asked),
                    }
                };
                on_progress(done.fetch_add(1, Ordering::Relaxed) + 1, of);
                found
            })
            .collect();
        for one in found {
            match one {
                Found::Scene(Task::Recording, name, scene) => {
                    truth.risks.entry(name).or_default().push(scene);
                }
                Found::Scene(_, name, scene) => {
                    truth.recorded.entry(name).or_default().push(scene);
                }
                Found::Verdict(key, verdict) => {
                    truth.judge.get_or_insert_default().insert(key, verdict);
                }
                Found::Score(key, told) => {
                    truth.scores.get_or_insert_default().insert(key, told);
                }
            }
        }
        !stop.load(Ordering::Relaxed)
    }

    /// One answer of each question without a truth, by scene.
    fn wanted(&self, truth: &Truth) -> Vec<AskedScene<'_>> {
        let mut files: HashMap<&str, Vec<&Entry>> = HashMap::new();
        for entry in self.entries {
            files.entry(entry.name.as_str()).or_default().push(entry);
        }
        let mut seen = BTreeSet::new();
        let mut scenes: BTreeMap<(&str, &str), AskedScene<'_>> = BTreeMap::new();
        for one in self.outcomes {
            let whose_own = truth.judge.is_some() && one.model == judge::MODEL;
            if whose_own || !Task::VERDICTS.contains(&one.task) || truth.label(one).is_some() {
                continue;
            }
            let Some(files) = files.get(unchanged_name(one)) else {
                continue;
            };
            let hash = one.scenario_hash.as_deref();
            let each = truth.judge.is_some() || truth.scores.is_some();
            if truth.scores.is_some() && truth.score_key(one).is_none() {
                // How far it looks ahead is not known.
                continue;
            }
            let ahead = truth.asked_as(one.run).horizon.map(f64::to_bits);
            let question = each.then_some((one.task.name(), one.window, ahead));
            let whole = one.task == Task::Recording;
            if seen.insert((&one.scenario, hash, &one.ego, whole, question)) {
                let scene = scenes.entry((&one.scenario, &one.ego));
                let (_, asked) = scene.or_insert_with(|| (files.clone(), Vec::new()));
                asked.push(one);
            }
        }
        scenes.into_values().collect()
    }

    /// The exact geometry of a scene as it is, for each of these answers whose scenario one of the files holds.
    fn recorded(&self, files: &[&Entry], asked: &[&Outcome]) -> Vec<Found> {
        let mut found = Vec::new();
        for one in asked {
            let unchanged = StoredQuestion {
                scenario: unchanged_name(one),
                ..StoredQuestion::from(*one)
            };
            let mut scenes = files
                .iter()
                .filter_map(|entry| unchanged.scene(entry, self.ego));
            if let Some(scene) = scenes.next() {
                let (label, critical) = match one.task {
                    Task::Recording => {
                        CriticalMoments::exact(&scene, self.thresholds).of_recording()
                    }
                    _ => alone(Labelled::new(&scene, None).label),
                };
                let known = RecordedScene {
                    scenario_hash: Some(scene.scenario.hash.to_string()),
                    ego: scene.ego.to_string(),
                    label,
                    critical,
                };
                found.push(Found::Scene(one.task, unchanged_name(one).into(), known));
            }
        }
        found
    }

    /// What risk scores say about questions about one scene, changed as it was; empty if no file holds it.
    fn scores(
        &self,
        convention: RiskConvention,
        files: &[&Entry],
        asked: &[&Outcome],
        known: &Truth,
    ) -> Vec<Found> {
        let Some(first) = asked.first().map(|one| StoredQuestion::from(*one)) else {
            return Vec::new();
        };
        let mut scenes = files
            .iter()
            .filter_map(|entry| first.scene(entry, self.ego));
        let Some(scene) = scenes.next() else {
            return Vec::new();
        };
        let moments = CriticalMoments::new(convention, &scene, self.thresholds);
        let told = |one: &&Outcome| {
            let (key, moments) = (known.score_key(one)?, moments.as_ref().ok());
            let told = match (one.task, one.window) {
                (Task::Recording, _) => moments?.of_recording(),
                (Task::Safety, Some((_, last))) => {
                    let window = Window::ending_at(&scene, last, 1);
                    let horizon = known.asked_as(one.run).horizon?;
                    moments?.after(&window, horizon, scene.scenario.dt())
                }
                // Contact is the lowest score by exact geometry.
                (Task::Collision, _) => alone(Labelled::new(&scene, None).label),
                _ => return None,
            };
            Some(Found::Score(key, told))
        };
        asked.iter().filter_map(told).collect()
    }

    /// The built-in judge's answers to questions about one scene; empty if no file holds it.
    fn verdicts(&self, files: &[&Entry], asked: &[&Outcome]) -> Vec<Found> {
        let Some(first) = asked.first().map(|one| StoredQuestion::from(*one)) else {
            return Vec::new();
        };
        let mut scenes = files
            .iter()
            .filter_map(|entry| first.scene(entry, self.ego));
        let Some(scene) = scenes.next() else {
            return Vec::new();
        };
        let verdict = |one: &&Outcome| {
            let verdict = StoredQuestion::from(*one).judged(&scene, self.thresholds)?;
            Some(Found::Verdict(QuestionKey::from(*one), verdict))
        };
        asked.iter().filter_map(verdict).collect()
    }
}

/// What was found out about a scene.
enum Found {
    /// For which task, and the scenario's name.
    Scene(Task, String, RecordedScene),
    Verdict(QuestionKey, Verdict),
    Score(ScoreKey, (Label, Vec<i64>)),
}

/// A label with the obstacle that it tells.
fn alone(label: Label) -> (Label, Vec<i64>) {
    (label, label.critical())
}

/// The name of an answer's scenario without a change of the scene.
fn unchanged_name(outcome: &Outcome) -> &str {
    Transform::of_name(&outcome.scenario).0
}

/// How the runs of batches were asked, where that is not the usual way.
///
/// # Errors
/// The store cannot be read.
pub fn asked_as(store: &Store) -> Result<HashMap<RunId, AskedAs>, StoreError> {
    let mut known: HashMap<BatchId, AskedAs> = HashMap::new();
    for (batch, _) in store.batches()? {
        if let Ok(spec) = Spec::from_json(&batch.spec) {
            let asked = AskedAs {
                horizon: Some(spec.experiment.within.unwrap_or(Case::HORIZON)),
                measures: spec.experiment.measures(),
            };
            known.insert(batch.id, asked);
        }
    }
    let unknown = AskedAs {
        horizon: None,
        measures: None,
    };
    let of_runs = store.run_batches()?.into_iter().filter_map(|(run, batch)| {
        // Other words are no batches: these runs were asked one by one.
        let batch: BatchId = batch.parse().ok()?;
        Some((run, known.get(&batch).copied().unwrap_or(unknown)))
    });
    Ok(of_runs
        .filter(|(_, asked)| *asked != AskedAs::default())
        .collect())
}

/// As much of a stored question as decides what the built-in judge says to it.
#[derive(Debug, Clone, Copy)]
pub struct StoredQuestion<'a> {
    /// The task.
    pub task: Task,
    /// Name of the scenario, with a change of the scene in brackets if there was one.
    pub scenario: &'a str,
    /// SHA-256 of its file; `None` if only its name is known.
    pub scenario_hash: Option<&'a str>,
    /// The ego, and where its motion comes from; `None` where that is not known, as of imported answers.
    pub ego: Option<&'a str>,
    /// First and last time step of the window, where known.
    pub window: Option<(i64, i64)>,
}

impl<'a> From<&'a Outcome> for StoredQuestion<'a> {
    fn from(one: &'a Outcome) -> Self {
        let imported = one.origin == nearmiss_store::Origin::Recorded;
        Self {
            task: one.task,
            scenario: &one.scenario,
            scenario_hash: one.scenario_hash.as_deref(),
            ego: (!imported).then_some(one.ego.as_str()),
            window: one.window,
        }
    }
}

impl StoredQuestion<'_> {
    /// The scene that was asked about, changed as it was, if this file is its scenario.
    #[must_use]
    pub fn scene(&self, entry: &Entry, ego: &EgoSelection) -> Option<Arc<Scene>> {
        let (_, transform) = Transform::of_name(self.scenario);
        let taken = self
            .ego
            .and_then(obstacle_taken)
            .map(EgoSelection::Obstacle);
        let request = OpenRequest {
            entry,
            ego: taken.as_ref().unwrap_or(ego),
            transform,
            strict: false,
            stand_in: StandIn::None,
        };
        let scene = open(&request).ok()?.scene.ok()?;
        let hash = scene.scenario.hash.to_string();
        let same_file = self.scenario_hash.is_none_or(|asked| asked == hash);
        let same_ego = self.ego.is_none_or(|asked| asked == scene.ego.to_string());
        (same_file && same_ego).then_some(scene)
    }

    /// The built-in judge's answer to the question about its scene.
    #[must_use]
    pub fn judged(&self, scene: &Scene, thresholds: &Thresholds) -> Option<Verdict> {
        let (first, last) = match (self.window, self.task) {
            (Some(window), _) => window,
            // What is true of these does not depend on the window.
            (None, task) if task.is_about_all_steps() => (scene.last_step(), scene.last_step()),
            (None, _) => return None,
        };
        let history = usize::try_from(last.saturating_sub(first).saturating_add(1)).unwrap_or(1);
        let window = Window::ending_at(scene, last, history);
        Some(judge_under(scene, self.task, &window, thresholds).verdict)
    }
}
