//! Stored answers by prompt configuration: a matrix whose cells link to the answers.

use std::collections::{BTreeMap, HashMap, HashSet};

use rayon::prelude::*;

use super::named_obstacles;
use super::statistics::{Interval, f1_interval};
use super::{AnswerStatus, Confusion, PromptConfig, Scored};
use crate::description::Frame;
use crate::prompts::Techniques;
use crate::store::{RunId, RunState, StoredOutcome};
use crate::verdict::Task;

/// Outcome of one question, compared with the ground truth.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Outcome {
    /// AnswerStatus yes, and it is.
    TruePositive,
    /// AnswerStatus yes, and it is not.
    FalsePositive,
    /// AnswerStatus no, and it is.
    FalseNegative,
    /// AnswerStatus no, and it is not.
    TrueNegative,
    /// There is a verdict, and the truth is unknown.
    Open,
    /// An answer came, and no verdict could be read in it.
    Unparsed,
    /// No whole answer came.
    Failed,
}

/// An answer of a prompt configuration.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct AnswerOutcome {
    /// The run in the store; `None` if a question of a batch came to none.
    pub run: Option<RunId>,
    /// Name of the scenario, with the change in brackets where the scene was changed.
    pub scenario: String,
    /// Which of several answers to the same question.
    pub sample: u32,
    /// Its outcome.
    pub outcome: Outcome,
    /// Of a false negative, whether it says yes and names another obstacle than the dangerous one.
    pub named_another: bool,
}

/// The answers of one way of asking.
#[derive(Debug, Clone, PartialEq)]
pub struct Results {
    /// How it was asked.
    pub way: PromptConfig,
    /// The answers, by scenario and sample.
    pub answers: Vec<AnswerOutcome>,
    /// The bootstrap interval of F1, over scenarios; `None` before [`with_intervals`] worked it out.
    pub f1: Option<Interval>,
    /// How many answers came to each outcome, in their order.
    counts: [u32; Outcome::ALL.len()],
}

/// Ground truth of a question.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct GroundTruth {
    /// Whether yes is right.
    pub dangerous: bool,
    /// Who is dangerous, where that is known: in the safety task a yes has to name one of them.
    pub obstacles: Vec<i64>,
}

/// The worst score of an obstacle that the built-in judge calls critical.
const CRITICAL: u8 = 2;

impl GroundTruth {
    /// The built-in judge's verdict as ground truth, with the obstacles it rates critical.
    #[must_use]
    pub fn judged(dangerous: bool, obstacles: impl IntoIterator<Item = (i64, u8)>) -> Self {
        let critical = obstacles
            .into_iter()
            .filter(|(_, score)| *score <= CRITICAL);
        Self {
            dangerous,
            obstacles: critical.map(|(id, _)| id).collect(),
        }
    }
}

impl Outcome {
    /// Every outcome, in the order of columns.
    pub const ALL: [Self; 7] = [
        Self::TruePositive,
        Self::FalsePositive,
        Self::FalseNegative,
        Self::TrueNegative,
        Self::Open,
        Self::Unparsed,
        Self::Failed,
    ];

    /// Compares a stored outcome with the ground truth. In the safety task a yes about a dangerous scene must name an
    /// obstacle that is dangerous, see [`named_obstacles`]; else it counts as no, as in the paper.
    #[must_use]
    pub fn classify(stored: &StoredOutcome, truth: Option<&GroundTruth>) -> Self {
        let names = |known: &GroundTruth| {
            let named =
                named_obstacles(stored.dangerous == Some(true), stored.named.iter().copied());
            named.iter().any(|id| known.obstacles.contains(id))
        };
        let right = |known: &GroundTruth| {
            stored.task != Task::Safety || known.obstacles.is_empty() || names(known)
        };
        let said = match (stored.dangerous, truth) {
            (Some(true), Some(known)) if known.dangerous => Some(right(known)),
            (said, _) => said,
        };
        match (said, truth.map(|known| known.dangerous), stored.state) {
            (Some(true), Some(true), _) => Self::TruePositive,
            (Some(true), Some(false), _) => Self::FalsePositive,
            (Some(false), Some(true), _) => Self::FalseNegative,
            (Some(false), Some(false), _) => Self::TrueNegative,
            (Some(_), None, _) => Self::Open,
            (None, _, RunState::Answered | RunState::Truncated) => Self::Unparsed,
            (None, ..) => Self::Failed,
        }
    }

    /// Compares the outcome of a batch question with the batch's ground truth; `None` if it was not asked.
    #[must_use]
    pub fn of_scored(scored: &Scored) -> Option<Self> {
        Some(
            match (&scored.status, scored.positive(), scored.is_collision()) {
                (AnswerStatus::Unasked(_), ..) => return None,
                (AnswerStatus::Failed(_), ..) => Self::Failed,
                (AnswerStatus::Unparsed(_), ..) | (_, None, _) => Self::Unparsed,
                (_, Some(true), Some(true)) => Self::TruePositive,
                (_, Some(true), Some(false)) => Self::FalsePositive,
                (_, Some(false), Some(true)) => Self::FalseNegative,
                (_, Some(false), Some(false)) => Self::TrueNegative,
                (_, Some(_), None) => Self::Open,
            },
        )
    }

    /// Whether a yes or no that came to this says yes about a dangerous scene and does not name who is dangerous.
    fn names_another(self, said: Option<bool>) -> bool {
        self == Self::FalseNegative && said == Some(true)
    }

    /// Whether the answer was right; `None` if there is no verdict or no truth.
    #[must_use]
    pub fn is_right(self) -> Option<bool> {
        match self {
            Self::TruePositive | Self::TrueNegative => Some(true),
            Self::FalsePositive | Self::FalseNegative => Some(false),
            Self::Open | Self::Unparsed | Self::Failed => None,
        }
    }
}

impl AnswerOutcome {
    /// An answer of a batch, compared with the batch's ground truth; `None` if the question was not asked.
    #[must_use]
    pub fn of_scored(scored: &Scored) -> Option<Self> {
        let outcome = Outcome::of_scored(scored)?;
        let said = match &scored.status {
            AnswerStatus::Verdict(verdict) => Some(verdict.dangerous),
            AnswerStatus::Unparsed(_) | AnswerStatus::Failed(_) | AnswerStatus::Unasked(_) => None,
        };
        Some(Self {
            run: scored.run,
            scenario: scored.scenario.clone(),
            sample: scored.sample,
            outcome,
            named_another: outcome.names_another(said),
        })
    }
}

impl Results {
    /// The answers of a way, in any order.
    #[must_use]
    pub fn new(way: PromptConfig, mut answers: Vec<AnswerOutcome>) -> Self {
        answers.sort_by(|a, b| (&a.scenario, a.sample, a.run).cmp(&(&b.scenario, b.sample, b.run)));
        let count = |outcome| answers.iter().filter(|a| a.outcome == outcome).count() as u32;
        Self {
            counts: Outcome::ALL.map(count),
            way,
            answers,
            f1: None,
        }
    }

    /// How many answers came to this.
    #[must_use]
    pub fn count(&self, outcome: Outcome) -> u32 {
        let mut all = Outcome::ALL.iter().zip(self.counts);
        all.find(|(o, _)| **o == outcome).map_or(0, |(_, n)| n)
    }

    /// How many of the false negatives say yes and name another obstacle.
    #[must_use]
    pub fn named_another(&self) -> usize {
        self.answers.iter().filter(|a| a.named_another).count()
    }

    /// The counts of those with a verdict and a truth.
    #[must_use]
    pub fn confusion(&self) -> Confusion {
        Confusion {
            true_positives: self.count(Outcome::TruePositive),
            false_positives: self.count(Outcome::FalsePositive),
            false_negatives: self.count(Outcome::FalseNegative),
            true_negatives: self.count(Outcome::TrueNegative),
        }
    }

    /// The same of each scenario, by their names.
    fn by_scenario(&self) -> Vec<Confusion> {
        let mut found: BTreeMap<&str, Confusion> = BTreeMap::new();
        for answer in &self.answers {
            let counts = found.entry(&answer.scenario).or_default();
            match answer.outcome {
                Outcome::TruePositive => counts.true_positives += 1,
                Outcome::FalsePositive => counts.false_positives += 1,
                Outcome::FalseNegative => counts.false_negatives += 1,
                Outcome::TrueNegative => counts.true_negatives += 1,
                Outcome::Open | Outcome::Unparsed | Outcome::Failed => {}
            }
        }
        found.into_values().collect()
    }
}

/// The rows with the intervals of their F1, as reports have them.
#[must_use]
pub fn with_intervals(mut rows: Vec<Results>) -> Vec<Results> {
    rows.par_iter_mut()
        .for_each(|row| row.f1 = f1_interval(&row.by_scenario()));
    rows
}

/// Counts stored outcomes, the newest first, each with the truth about it. Of several runs of one way about the same
/// scenario, ego and window with the same sample number the newest counts.
#[must_use]
pub fn results<'a>(
    stored: impl IntoIterator<Item = (&'a StoredOutcome, Option<&'a GroundTruth>)>,
) -> Vec<Results> {
    // The words of a way are read once, not for each of a hundred thousand runs.
    let mut words: HashMap<(Task, [&str; 3]), usize> = HashMap::new();
    let mut ways: BTreeMap<PromptConfig, usize> = BTreeMap::new();
    let mut answers: Vec<Vec<AnswerOutcome>> = Vec::new();
    let mut seen = HashSet::new();
    for (stored, truth) in stored {
        let asked = [&stored.frame, &stored.techniques, &stored.model].map(String::as_str);
        let place = *words.entry((stored.task, asked)).or_insert_with(|| {
            let way = PromptConfig {
                task: stored.task,
                frame: Frame::parse(&stored.frame),
                techniques: Techniques::parse(&stored.techniques).ok(),
                model: stored.model.clone(),
            };
            *ways.entry(way).or_insert_with(|| {
                answers.push(Vec::new());
                answers.len() - 1
            })
        });
        let scenario = stored.scenario_hash.as_ref().unwrap_or(&stored.scenario);
        let about = (place, scenario, &stored.ego, stored.window, stored.sample);
        if seen.insert(about) {
            let outcome = Outcome::classify(stored, truth);
            answers[place].push(AnswerOutcome {
                run: Some(stored.run),
                scenario: stored.scenario.clone(),
                sample: stored.sample,
                outcome,
                named_another: outcome.names_another(stored.dangerous),
            });
        }
    }
    let by_way = |(way, place): (PromptConfig, usize)| {
        Results::new(way, std::mem::take(&mut answers[place]))
    };
    ways.into_iter().map(by_way).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn stored(run: i64, scenario: &str, dangerous: Option<bool>, state: RunState) -> StoredOutcome {
        StoredOutcome {
            run: RunId(run),
            scenario_hash: None,
            scenario: scenario.into(),
            ego: "1".into(),
            task: Task::Collision,
            frame: "ego".into(),
            techniques: "cp".into(),
            model: "m/x".into(),
            sample: 0,
            window: None,
            state,
            dangerous,
            named: Vec::new(),
        }
    }

    #[test]
    fn a_yes_of_the_safety_task_names_somebody_dangerous() {
        let truth = GroundTruth::judged(true, [(7, 1), (8, 2), (9, 3)]);
        assert_eq!(truth.obstacles, [7, 8]);
        let of = |task, named: &[(i64, u8)], truth: &GroundTruth| {
            let answer = StoredOutcome {
                task,
                named: named.to_vec(),
                ..stored(1, "a", Some(true), RunState::Answered)
            };
            Outcome::classify(&answer, Some(truth))
        };
        use Outcome::{FalseNegative, FalsePositive, TruePositive};
        assert_eq!(of(Task::Safety, &[(8, 1)], &truth), TruePositive);
        // Score 2 names an obstacle where none is graver.
        assert_eq!(of(Task::Safety, &[(8, 2)], &truth), TruePositive);
        assert_eq!(of(Task::Safety, &[(9, 1), (8, 2)], &truth), FalseNegative);
        assert_eq!(of(Task::Safety, &[(8, 3)], &truth), FalseNegative);
        assert_eq!(of(Task::Safety, &[(9, 0)], &truth), FalseNegative);
        assert_eq!(of(Task::Safety, &[], &truth), FalseNegative);
        assert_eq!(of(Task::Collision, &[], &truth), TruePositive);
        // Where no obstacle is known, yes is enough; where none is dangerous, yes is wrong whichever it names.
        let unnamed = GroundTruth::judged(true, []);
        assert_eq!(of(Task::Safety, &[], &unnamed), TruePositive);
        let safe = GroundTruth::judged(false, [(8, 3)]);
        assert_eq!(of(Task::Safety, &[(8, 0)], &safe), FalsePositive);
    }

    #[test]
    fn every_outcome_has_its_cell_and_of_the_same_question_the_newest_counts() {
        use RunState::{Answered, Failed, Interrupted, Truncated};
        let all = [
            (stored(9, "a", Some(true), Answered), Some(true)),
            (stored(8, "a", Some(false), Answered), Some(true)),
            (stored(7, "b", Some(true), Answered), Some(false)),
            (stored(6, "c", Some(false), Answered), Some(true)),
            (stored(5, "d", Some(false), Truncated), Some(false)),
            (stored(4, "e", Some(true), Answered), None),
            (stored(3, "f", None, Answered), Some(true)),
            (stored(2, "g", None, Failed), None),
            (stored(1, "h", None, Interrupted), Some(true)),
        ];
        let known = |dangerous| GroundTruth {
            dangerous,
            obstacles: Vec::new(),
        };
        let all = all.map(|(said, truth)| (said, truth.map(known)));
        let found = with_intervals(results(all.iter().map(|(said, t)| (said, t.as_ref()))));
        assert_eq!(found.len(), 1);
        let counts = Outcome::ALL.map(|outcome| found[0].count(outcome));
        assert_eq!(counts, [1, 1, 1, 1, 1, 1, 2]);
        assert_eq!(found[0].answers[0].run, Some(RunId(9)));
        assert_eq!(found[0].confusion().f1(), Some(0.5));
        // Of four scenarios with a truth, a draw may hold only what is right, or only what is wrong.
        let interval = found[0].f1.unwrap();
        assert_eq!((interval.low, interval.high), (0.0, 1.0));
    }
}
