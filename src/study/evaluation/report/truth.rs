//! What is true about a stored answer: labels, recordings, risk scores, or the built-in judge.

use std::collections::{BTreeMap, HashMap};

use super::super::{Case, Label, Labels};
use nearmiss_scene::judge;
use nearmiss_scene::metrics::MeasureList;
use nearmiss_scene::scenario::{Transform, obstacle_taken};
use nearmiss_scene::verdict::{Task, Verdict};
use nearmiss_store::{Origin, Outcome, RunId};

/// Ground truth from several sources; the first that covers an answer counts, in the order of the fields.
///
/// A window that a batch drew has the truth that was drawn with it: all other sources speak of whole scenarios, in which
/// a window long before a collision is safe.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Truth {
    /// Truths of drawn windows, by run.
    pub windows: HashMap<RunId, BatchTruth>,
    /// Labels of CSV files.
    pub labels: Labels,
    /// Truths from batches, by run.
    pub of_batches: HashMap<RunId, BatchTruth>,
    /// Labels of the folders that scenarios lie in, by scenario.
    pub layout: BTreeMap<String, Label>,
    /// The exact geometry of whole recordings, by scenario: whether they collide.
    pub recorded: BTreeMap<String, Vec<RecordedScene>>,
    /// Whether whole recordings are of high risk, by scenario.
    pub risks: BTreeMap<String, Vec<RecordedScene>>,
    /// What risk scores say about questions, where these are the truth.
    pub scores: Option<HashMap<ScoreKey, (Label, Vec<i64>)>>,
    /// How runs were asked, where that is not the usual way.
    pub asked: HashMap<RunId, AskedAs>,
    /// The built-in judge's verdicts on the same questions, where these are the truth, prediction included.
    pub judge: Option<HashMap<QuestionKey, Verdict>>,
}

/// What a batch says is true about a run.
#[derive(Debug, Clone, PartialEq)]
pub struct BatchTruth {
    /// The batch.
    pub batch: String,
    /// Whether the ego collides, and with whom.
    pub label: Label,
    /// The obstacles that are truly critical.
    pub critical: Vec<i64>,
    /// Whether a risk score says so.
    pub by_score: bool,
}

/// A question with the look ahead that it was asked with, seconds as bits: what scores say about it.
pub type ScoreKey = (QuestionKey, u64);

/// How a run was asked, as far as its messages do not tell it apart.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AskedAs {
    /// The look ahead of the safety task, seconds; `None` where the batch is gone that knew it.
    pub horizon: Option<f64>,
    /// The measures chosen for the metrics frame, if any.
    pub measures: Option<MeasureList>,
}

impl Default for AskedAs {
    fn default() -> Self {
        Self {
            horizon: Some(Case::HORIZON),
            measures: None,
        }
    }
}

/// The exact geometry of one recording, and of whom.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordedScene {
    /// SHA-256 of the scenario's file; `None` if only its name is known.
    pub scenario_hash: Option<String>,
    /// The ego, and where its motion comes from.
    pub ego: String,
    /// Whether it collides, or is of high risk, and who it is.
    pub label: Label,
    /// Every obstacle that makes it so.
    pub critical: Vec<i64>,
}

/// A question as far as it decides what the built-in judge says to it.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct QuestionKey {
    /// Name of the scenario.
    pub scenario: String,
    /// SHA-256 of its file; empty if only its name is known.
    pub scenario_hash: String,
    /// The ego, and where its motion comes from.
    pub ego: String,
    /// The task.
    pub task: Task,
    /// First and last time step; `None` where the judge looks at the whole recording.
    pub window: Option<(i64, i64)>,
}

impl From<&Outcome> for QuestionKey {
    fn from(outcome: &Outcome) -> Self {
        Self {
            scenario: outcome.scenario.clone(),
            scenario_hash: outcome.scenario_hash.clone().unwrap_or_default(),
            ego: outcome.ego.clone(),
            task: outcome.task,
            window: Self::window(outcome.task, outcome.window),
        }
    }
}

impl QuestionKey {
    /// The window as far as it tells questions apart: what is true of some tasks does not depend on it.
    #[must_use]
    pub fn window(task: Task, window: Option<(i64, i64)>) -> Option<(i64, i64)> {
        window.filter(|_| !task.is_about_all_steps())
    }
}

/// The worst score of a critical obstacle in verdicts of the built-in judge that do not list these, as older versions
/// stored them.
const CRITICAL: u8 = 2;

impl RecordedScene {
    /// Whether an answer is about this recording. Of an imported answer neither file nor ego may be known.
    fn fits(&self, outcome: &Outcome) -> bool {
        let same_file = match (&outcome.scenario_hash, &self.scenario_hash) {
            (Some(asked), Some(known)) => asked == known,
            _ => true,
        };
        same_file && (outcome.origin == Origin::Recorded || outcome.ego == self.ego)
    }
}

impl Truth {
    /// Adds the built-in judge's stored verdicts on whole recordings: their exact geometry. Of several on the same
    /// recording the newest counts; `outcomes` are in the order in which they were asked.
    pub fn add_stored_geometry(&mut self, outcomes: &[Outcome]) {
        let judged = |outcome: &&Outcome| {
            outcome.model == judge::MODEL
                && outcome.task.is_about_all_steps()
                && Transform::of_name(&outcome.scenario).1.is_none()
        };
        for outcome in outcomes.iter().filter(judged).rev() {
            let verdict = outcome.verdict.as_deref();
            let Some(verdict) = verdict.and_then(|json| serde_json::from_str::<Verdict>(json).ok())
            else {
                continue;
            };
            let label = if verdict.dangerous {
                Label::Collision(verdict.obstacles.first().map(|o| o.id))
            } else {
                Label::Safe
            };
            let (known, critical) = match outcome.task {
                Task::Recording => (&mut self.risks, verdict.danger()),
                _ => (&mut self.recorded, label.critical()),
            };
            let scenes = known.entry(outcome.scenario.clone()).or_default();
            scenes.push(RecordedScene {
                scenario_hash: outcome.scenario_hash.clone(),
                ego: outcome.ego.clone(),
                label,
                critical,
            });
        }
    }

    /// What is true about an answer, and which obstacles are truly critical; `None` where it is not known.
    #[must_use]
    pub fn lookup(&self, outcome: &Outcome) -> Option<(Label, Vec<i64>)> {
        match (&self.judge, &self.scores) {
            (Some(verdicts), _) => Some(judged(verdicts.get(&QuestionKey::from(outcome))?)),
            (None, Some(scores)) => scores.get(&self.score_key(outcome)?).cloned(),
            (None, None) => {
                let (label, critical, _) = self.recorded_truth(outcome)?;
                Some((label, critical))
            }
        }
    }

    /// How a run was asked.
    #[must_use]
    pub fn asked_as(&self, run: RunId) -> AskedAs {
        self.asked.get(&run).copied().unwrap_or_default()
    }

    /// The question of an answer with its look ahead; `None` where it needs one that is not known.
    #[must_use]
    pub fn score_key(&self, outcome: &Outcome) -> Option<ScoreKey> {
        let horizon = match outcome.task {
            Task::Safety => self.asked_as(outcome.run).horizon?,
            _ => 0.0,
        };
        Some((QuestionKey::from(outcome), horizon.to_bits()))
    }

    /// Whether what is true about an answer is told by a risk score.
    #[must_use]
    pub fn is_score(&self, outcome: &Outcome) -> bool {
        match (&self.judge, &self.scores) {
            (Some(_), _) => false,
            (None, Some(_)) => outcome.task != Task::Collision && self.lookup(outcome).is_some(),
            (None, None) => self
                .recorded_truth(outcome)
                .is_some_and(|(.., by_score)| by_score),
        }
    }

    /// What is true about an answer; `None` where it is not known.
    #[must_use]
    pub fn label(&self, outcome: &Outcome) -> Option<Label> {
        self.lookup(outcome).map(|(label, _)| label)
    }

    /// What labels and recordings say is true about an answer, which obstacles are truly critical, and whether a risk score
    /// says so.
    fn recorded_truth(&self, outcome: &Outcome) -> Option<(Label, Vec<i64>, bool)> {
        let of = |truth: &BatchTruth| (truth.label, truth.critical.clone(), truth.by_score);
        if let Some(window) = self.windows.get(&outcome.run) {
            return Some(of(window));
        }
        let (name, _) = Transform::of_name(&outcome.scenario);
        let of_batch = || self.of_batches.get(&outcome.run).map(of);
        let alone = |label: Label| (label, label.critical(), false);
        let whole = outcome.task == Task::Recording;
        let known = if whole { &self.risks } else { &self.recorded };
        let recorded = || {
            let mut scenes = known.get(name)?.iter();
            let scene = scenes.find(|scene| scene.fits(outcome))?;
            Some((scene.label, scene.critical.clone(), whole))
        };
        let label = self.labels.get(name).map(alone);
        label
            .or_else(of_batch)
            // A folder speaks of the recorded ego.
            .or_else(|| {
                let own = obstacle_taken(&outcome.ego).is_none();
                // That it tells of no collision does not make a recording safe.
                self.layout
                    .get(name)
                    .filter(|label| own && (!whole || label.collides()))
                    .map(|label| alone(*label))
            })
            .or_else(recorded)
    }

    /// The batch whose truth counts for an answer.
    #[must_use]
    pub fn deciding_batch(&self, outcome: &Outcome) -> Option<&str> {
        let labelled = || self.labels.get(&outcome.scenario).is_some();
        let found = match self.windows.get(&outcome.run) {
            _ if self.judge.is_some() || self.scores.is_some() => None,
            Some(window) => Some(window),
            None if labelled() => None,
            None => self.of_batches.get(&outcome.run),
        };
        found.map(|truth| truth.batch.as_str())
    }
}

/// The built-in judge's verdict as the truth about an answer, with the obstacles that it calls critical.
fn judged(verdict: &Verdict) -> (Label, Vec<i64>) {
    if !verdict.dangerous {
        return (Label::Safe, Vec::new());
    }
    let by_score = || {
        let all = verdict.obstacles.iter();
        let grave = all.filter(|o| o.risk_score <= CRITICAL);
        grave.map(|o| o.id).collect()
    };
    let critical = match verdict.critical {
        Some(_) => verdict.danger(),
        None => by_score(),
    };
    (Label::Collision(critical.first().copied()), critical)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nearmiss_scene::verdict::{CriticalObstacle, ObstacleRisk};

    fn verdict(dangerous: bool, obstacles: &[(i64, u8)], critical: Option<&[i64]>) -> Verdict {
        let risk = |(id, risk_score): &(i64, u8)| ObstacleRisk {
            id: *id,
            risk_score: *risk_score,
            reason: String::new(),
            written_score: None,
        };
        let of = |ids: &[i64]| ids.iter().copied().map(CriticalObstacle::new).collect();
        Verdict {
            task: Task::Safety,
            dangerous,
            obstacles: obstacles.iter().map(risk).collect(),
            justification: String::new(),
            critical: critical.map(of),
            probability: None,
            token_probability: None,
            unknown: Vec::new(),
        }
    }

    #[test]
    fn the_critical_obstacles_of_the_judge_are_the_right_ones_to_name() {
        let scores = [(7, 4), (8, 1), (9, 3)];
        let told = |critical: Option<&[i64]>| judged(&verdict(true, &scores, critical));
        let hit = |id| Label::Collision(Some(id));
        assert_eq!(told(Some(&[9, 7])), (hit(9), vec![9, 7]));
        // As older versions stored it.
        assert_eq!(told(None), (hit(8), vec![8]));
        let unnamed = judged(&verdict(true, &[], None));
        assert_eq!(unnamed, (Label::Collision(None), Vec::new()));
        let safe = judged(&verdict(false, &[(8, 3)], None));
        assert_eq!(safe, (Label::Safe, Vec::new()));
    }
}
