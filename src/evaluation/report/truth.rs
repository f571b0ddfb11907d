//! What is true about a stored answer: labels, recordings, or the built-in judge.

use std::collections::{BTreeMap, HashMap};

use super::super::{Label, Labels, named_obstacles};
use crate::judge;
use crate::scenario::{Transform, obstacle_taken};
use crate::store::{Origin, Outcome, RunId};
use crate::verdict::{Task, Verdict};

/// Ground truth from several sources; the first that covers an answer counts, in the order of the fields.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Truth {
    /// Labels of CSV files.
    pub labels: Labels,
    /// Labels from batches, by run, with the name of the batch.
    pub of_batches: HashMap<RunId, (String, Label)>,
    /// Labels of the folders that scenarios lie in, by scenario.
    pub layout: BTreeMap<String, Label>,
    /// The exact geometry of whole recordings, by scenario.
    pub recorded: BTreeMap<String, Vec<RecordedScene>>,
    /// The built-in judge's verdicts on the same questions, where these are the truth, prediction included.
    pub judge: Option<HashMap<QuestionKey, Verdict>>,
}

/// The exact geometry of one recording, and of whom.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordedScene {
    /// SHA-256 of the scenario's file; `None` if only its name is known.
    pub scenario_hash: Option<String>,
    /// The ego, and where its motion comes from.
    pub ego: String,
    /// Whether it collides, and with whom.
    pub label: Label,
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
    /// First and last time step; `None` for a collision, about which the judge looks at the whole recording.
    pub window: Option<(i64, i64)>,
}

impl From<&Outcome> for QuestionKey {
    fn from(outcome: &Outcome) -> Self {
        Self {
            scenario: outcome.scenario.clone(),
            scenario_hash: outcome.scenario_hash.clone().unwrap_or_default(),
            ego: outcome.ego.clone(),
            task: outcome.task,
            window: outcome.window.filter(|_| outcome.task != Task::Collision),
        }
    }
}

/// The worst score of an obstacle that the built-in judge calls critical.
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
    /// Adds the built-in judge's stored verdicts on the collision task: the exact geometry of whole recordings. Of
    /// several on the same recording the newest counts; `outcomes` are in the order in which they were asked.
    pub fn add_stored_geometry(&mut self, outcomes: &[Outcome]) {
        let judged = |outcome: &&Outcome| {
            outcome.model == judge::MODEL
                && outcome.task == Task::Collision
                && Transform::of_name(&outcome.scenario).1.is_none()
        };
        for outcome in outcomes.iter().filter(judged).rev() {
            let verdict = outcome.verdict.as_deref();
            let Some(verdict) = verdict.and_then(|json| serde_json::from_str::<Verdict>(json).ok())
            else {
                continue;
            };
            let label = match verdict.dangerous {
                true => Label::Collision(verdict.obstacles.first().map(|o| o.id)),
                false => Label::Safe,
            };
            let scenes = self.recorded.entry(outcome.scenario.clone()).or_default();
            scenes.push(RecordedScene {
                scenario_hash: outcome.scenario_hash.clone(),
                ego: outcome.ego.clone(),
                label,
            });
        }
    }

    /// What is true about an answer, which says `said`; `None` where it is not known.
    #[must_use]
    pub fn label(&self, outcome: &Outcome, said: Option<&Verdict>) -> Option<Label> {
        if let Some(verdicts) = &self.judge {
            let verdict = verdicts.get(&QuestionKey::from(outcome))?;
            return Some(judged(verdict, said));
        }
        let (name, _) = Transform::of_name(&outcome.scenario);
        let of_batch = || self.of_batches.get(&outcome.run).map(|(_, label)| *label);
        let recorded = || {
            let mut scenes = self.recorded.get(name)?.iter();
            Some(scenes.find(|scene| scene.fits(outcome))?.label)
        };
        self.labels
            .get(name)
            .or_else(of_batch)
            // A folder speaks of the recorded ego.
            .or_else(|| {
                let own = obstacle_taken(&outcome.ego).is_none();
                self.layout.get(name).copied().filter(|_| own)
            })
            .or_else(recorded)
    }

    /// The batch whose label counts for an answer.
    #[must_use]
    pub fn batch_of(&self, outcome: &Outcome) -> Option<&str> {
        if self.judge.is_some() || self.labels.get(&outcome.scenario).is_some() {
            return None;
        }
        let (batch, _) = self.of_batches.get(&outcome.run)?;
        Some(batch)
    }
}

/// The built-in judge's verdict as the truth about an answer: any of the obstacles that it calls critical is the right
/// one to name.
fn judged(verdict: &Verdict, said: Option<&Verdict>) -> Label {
    if !verdict.dangerous {
        return Label::Safe;
    }
    let all = verdict.obstacles.iter();
    let critical: Vec<i64> = all
        .filter(|o| o.risk_score <= CRITICAL)
        .map(|o| o.id)
        .collect();
    let named = said.map_or(Vec::new(), |said| {
        let scores = said.obstacles.iter().map(|o| (o.id, o.risk_score));
        named_obstacles(said.dangerous, scores)
    });
    let right = named.into_iter().find(|id| critical.contains(id));
    Label::Collision(right.or(critical.first().copied()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::verdict::ObstacleRisk;

    fn verdict(dangerous: bool, obstacles: &[(i64, u8)]) -> Verdict {
        let risk = |(id, risk_score): &(i64, u8)| ObstacleRisk {
            id: *id,
            risk_score: *risk_score,
            reason: String::new(),
        };
        Verdict {
            task: Task::Safety,
            dangerous,
            obstacles: obstacles.iter().map(risk).collect(),
            justification: String::new(),
        }
    }

    #[test]
    fn any_obstacle_that_the_judge_calls_critical_is_the_right_one_to_name() {
        let truth = verdict(true, &[(7, 1), (8, 2), (9, 3)]);
        let label = |named: &[(i64, u8)]| judged(&truth, Some(&verdict(true, named)));
        assert_eq!(label(&[(8, 1)]), Label::Collision(Some(8)));
        // Score 2 names an obstacle where none is graver.
        assert_eq!(label(&[(8, 2)]), Label::Collision(Some(8)));
        assert_eq!(label(&[(9, 1), (8, 2)]), Label::Collision(Some(7)));
        assert_eq!(judged(&truth, None), Label::Collision(Some(7)));
        let unnamed = judged(&verdict(true, &[]), Some(&verdict(true, &[(1, 0)])));
        assert_eq!(unnamed, Label::Collision(None));
        assert_eq!(judged(&verdict(false, &[(8, 3)]), None), Label::Safe);
    }
}
