//! Answers with their ground truth: the input of every figure in a report.

use super::{Confusion, Label, TemplateVersion};
use crate::description::Frame;
use crate::prompts::Techniques;
use crate::store::{Consumed, RunId};
use crate::verdict::{Task, Verdict};

/// A prompt configuration: a row of a table.
#[derive(Debug, Clone, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct PromptConfig {
    /// The task.
    pub task: Task,
    /// The frame of the description; `None` for a judge without a prompt.
    pub frame: Option<Frame>,
    /// The prompting techniques; `None` for a judge without a prompt.
    pub techniques: Option<Techniques>,
    /// Who is asked, as `provider/model`.
    pub model: String,
    /// The version of the prompt template; `None` for a judge without a prompt, for imported answers, and in plans,
    /// whose templates the batch pins.
    pub template: Option<TemplateVersion>,
}

/// Status of a question.
#[derive(Debug, Clone, PartialEq)]
pub enum AnswerStatus {
    /// A verdict was read.
    Verdict(Verdict),
    /// An answer came, and no verdict could be read in it: why.
    Unparsed(String),
    /// It was asked, and no whole answer came: why.
    Failed(String),
    /// It was not asked, or not yet, or its answer is still with a provider: why.
    Unasked(String),
}

impl AnswerStatus {
    /// The verdict, where one was read.
    #[must_use]
    pub fn verdict(&self) -> Option<&Verdict> {
        match self {
            Self::Verdict(verdict) => Some(verdict),
            Self::Unparsed(_) | Self::Failed(_) | Self::Unasked(_) => None,
        }
    }
}

/// An answer, or its absence, for one scenario.
#[derive(Debug, Clone, PartialEq)]
pub struct Scored {
    /// Name of the scenario, without folders and ending.
    pub scenario: String,
    /// How it was asked.
    pub way: PromptConfig,
    /// Which of several answers to the same question, from 0.
    pub sample: u32,
    /// Its label; `None` if unknown.
    pub truth: Option<Label>,
    /// Its status.
    pub status: AnswerStatus,
    /// The built-in judge's verdict on the same question, where it was worked out.
    pub reference: Option<Verdict>,
    /// Time, tokens and cost.
    pub consumed: Consumed,
    /// The run in the store.
    pub run: Option<RunId>,
}

impl Scored {
    /// Whether it says yes; `None` if it holds no verdict.
    ///
    /// In the safety task a yes about a scenario whose truth names an obstacle has to name that obstacle as the danger,
    /// see [`named_obstacles`]; else it is a no.
    #[must_use]
    pub fn positive(&self) -> Option<bool> {
        let AnswerStatus::Verdict(verdict) = &self.status else {
            return None;
        };
        Some(match (self.way.task, self.truth) {
            (Task::Safety, Some(Label::Collision(Some(obstacle)))) => {
                verdict.dangerous && names_obstacle(verdict, obstacle)
            }
            _ => verdict.dangerous,
        })
    }

    /// Whether it says yes, whichever obstacle it names; `None` if it holds no verdict.
    #[must_use]
    pub fn dangerous(&self) -> Option<bool> {
        match &self.status {
            AnswerStatus::Verdict(verdict) => Some(verdict.dangerous),
            _ => None,
        }
    }

    /// The answer of a built-in predictor, which is asked without a prompt.
    #[must_use]
    pub fn built_in(scenario: &str, model: &str, truth: Option<Label>, verdict: Verdict) -> Self {
        Self {
            scenario: scenario.into(),
            way: PromptConfig {
                task: verdict.task,
                frame: None,
                techniques: None,
                model: model.into(),
                template: None,
            },
            sample: 0,
            truth,
            status: AnswerStatus::Verdict(verdict),
            reference: None,
            consumed: Consumed::default(),
            run: None,
        }
    }

    /// Whether it is true that it collides.
    #[must_use]
    pub fn is_collision(&self) -> Option<bool> {
        self.truth.map(|label| label.collides())
    }
}

impl Confusion {
    /// Counts the answers for which both `yes` and the truth are known.
    #[must_use]
    pub fn from_scored<'a>(
        scored: impl IntoIterator<Item = &'a Scored>,
        yes: impl Fn(&Scored) -> Option<bool>,
    ) -> Self {
        let mut counts = Self::default();
        for one in scored {
            if let (Some(yes), Some(truth)) = (yes(one), one.is_collision()) {
                counts.count(yes, truth);
            }
        }
        counts
    }
}

/// Whether a verdict names an obstacle as the danger; see [`named_obstacles`].
#[must_use]
pub fn names_obstacle(verdict: &Verdict, obstacle: i64) -> bool {
    let scores = verdict.obstacles.iter().map(|o| (o.id, o.risk_score));
    named_obstacles(verdict.dangerous, scores).contains(&obstacle)
}

/// The obstacles that a verdict with these risk scores names as the danger.
///
/// Those that collide or are of extreme risk, the scores 0 and 1: so the paper counts the obstacles that a model found.
/// Where a yes gives no obstacle so low a score, as for a collision that is predicted for later, those with the
/// lowest one, 2 at most.
#[must_use]
pub fn named_obstacles(
    dangerous: bool,
    scores: impl Iterator<Item = (i64, u8)> + Clone,
) -> Vec<i64> {
    let lowest = scores.clone().map(|(_, score)| score).min();
    let most = match lowest {
        Some(PREDICTED) if dangerous => PREDICTED,
        _ => EXTREME,
    };
    let named = scores.filter(|(_, score)| *score <= most);
    named.map(|(id, _)| id).collect()
}

/// The risk scores of extreme risk, and the highest one of a collision that is only predicted.
const EXTREME: u8 = 1;
const PREDICTED: u8 = 2;
