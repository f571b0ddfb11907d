//! Answers with their ground truth, what their questions vary, and what makes them doubtful: the input of every figure.

use nearmiss_ask::prompts::Techniques;
use nearmiss_scene::description::Frame;
use nearmiss_scene::judge;
use nearmiss_scene::scenario::{Scenario, Transform};
use nearmiss_scene::verdict::{Parsed, Task, Verdict};
use nearmiss_store::{ClaimCounts, Consumed, RunId};
use schemars::JsonSchema;
use serde::Serialize;

use super::answer::{Answer, NOT_SENT};
use super::{
    Attempt, AxisValues, Cluster, Confusion, JudgeOutcome, Label, Lead, Spending, TemplateVersion,
};

/// A prompt configuration: a row of a table.
#[derive(Debug, Clone, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, JsonSchema)]
#[serde(into = "Way")]
#[schemars(with = "Way")]
pub struct PromptConfig {
    /// The task.
    pub task: Task,
    /// The frame of the description; `None` for a judge without a prompt.
    pub frame: Option<Frame>,
    /// The prompting techniques; `None` for a judge without a prompt.
    pub techniques: Option<Techniques>,
    /// Who is asked, as `provider/model`.
    pub model: String,
    /// The values of the axes of its batch.
    pub settings: AxisValues,
    /// The version of the prompt template; `None` for a judge without a prompt, for imported answers, and in plans,
    /// whose templates the batch pins.
    pub template: Option<TemplateVersion>,
}

/// A prompt configuration as every table and document has it.
#[derive(Serialize, JsonSchema)]
struct Way {
    /// The question: collision, safety or recording.
    #[schemars(title = "Task")]
    task: &'static str,
    /// Frame of the description; null for a judge without a prompt.
    #[schemars(title = "Frame")]
    frame: Option<&'static str>,
    /// Prompting techniques: cp, cot and icl joined by +, or base; null for a judge without a prompt.
    #[schemars(title = "Techniques")]
    techniques: Option<String>,
    /// Model asked, as provider/model.
    #[schemars(title = "Model")]
    model: String,
    /// The values of the axes of its batch, in words.
    #[schemars(title = "Settings", extend("rare" = true))]
    settings: Option<String>,
    /// The version of the template: its name with the letters that its hash begins with.
    #[schemars(title = "Template", extend("rare" = true))]
    template: Option<String>,
    /// SHA-256 of the text of the template.
    template_hash: Option<String>,
}

impl From<PromptConfig> for Way {
    fn from(configuration: PromptConfig) -> Self {
        Self {
            task: configuration.task.name(),
            frame: configuration.frame.map(|frame| frame.name()),
            techniques: configuration
                .techniques
                .map(|techniques| techniques.to_string()),
            settings: configuration.settings.to_stored(),
            template: configuration.template.as_ref().map(ToString::to_string),
            template_hash: configuration.template.map(|template| template.hash),
            model: configuration.model,
        }
    }
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
    pub configuration: PromptConfig,
    /// Which of several answers to the same question, from 0.
    pub sample: u32,
    /// Its label; `None` if unknown. Of a question about a drawn window, that of the window.
    pub truth: Option<Label>,
    /// The obstacles that are truly critical; empty where there are none or they are not known.
    pub critical: Vec<i64>,
    /// Its status.
    pub status: AnswerStatus,
    /// The built-in judge's verdict on the same question, where it was worked out.
    pub reference: Option<Verdict>,
    /// First and last time step of its window, where one scenario may have several; `None` where the question is
    /// about the whole recording, or was not asked.
    pub window: Option<(i64, i64)>,
    /// Time, tokens and cost.
    pub consumed: Consumed,
    /// The most that it can have cost, US dollars, where that was known when it was asked.
    pub most_usd: Option<f64>,
    /// Other attempts at the same question, in whose place this one counts: they were paid for, too.
    pub superseded: Vec<Attempt>,
    /// The run in the store.
    pub run: Option<RunId>,
    /// Its claims about obstacles, where they were checked.
    pub claims: ClaimCounts,
    /// What its unit of intervals and comparisons is.
    pub cluster: Cluster,
}

impl Scored {
    /// The unit of intervals and comparisons that it is of.
    #[must_use]
    pub fn unit(&self) -> &str {
        self.cluster.unit(&self.scenario)
    }

    /// Whether it says yes; `None` if it holds no verdict. Which obstacles it names is counted apart: see
    /// [`super::Naming`].
    #[must_use]
    pub fn positive(&self) -> Option<bool> {
        self.status.verdict().map(|verdict| verdict.dangerous)
    }

    /// Whether it is right: what was asked and has no verdict is not. Nothing without a truth, and of what was not asked.
    #[must_use]
    pub fn is_right(&self) -> Option<bool> {
        let truth = self.is_collision()?;
        match &self.status {
            AnswerStatus::Verdict(verdict) => Some(verdict.dangerous == truth),
            AnswerStatus::Unparsed(_) | AnswerStatus::Failed(_) => Some(false),
            AnswerStatus::Unasked(_) => None,
        }
    }

    /// Makes a yes of the safety task that does not name the obstacle that collides a no, as the paper counts; nothing
    /// where that obstacle is not known.
    pub fn require_naming(&mut self) {
        if let (Task::Safety, AnswerStatus::Verdict(verdict)) =
            (self.configuration.task, &mut self.status)
        {
            let named = verdict.danger();
            let known = !self.critical.is_empty();
            verdict.dangerous &= !known || named.iter().any(|id| self.critical.contains(id));
        }
    }

    /// Sets what is true: the label, and the obstacles that are truly critical.
    pub fn set_truth(&mut self, truth: Option<(Label, Vec<i64>)>) {
        let (label, critical) = truth.unzip();
        self.truth = label;
        self.critical = critical.unwrap_or_default();
    }

    /// What a built-in predictor says, which is asked without a prompt.
    #[must_use]
    pub fn built_in(
        scenario: &str,
        model: &str,
        task: Task,
        truth: Option<Label>,
        status: AnswerStatus,
    ) -> Self {
        Self {
            scenario: scenario.into(),
            configuration: PromptConfig {
                task,
                frame: None,
                techniques: None,
                model: model.into(),
                settings: AxisValues::default(),
                template: None,
            },
            sample: 0,
            truth,
            critical: truth.map(Label::critical).unwrap_or_default(),
            status,
            reference: None,
            window: None,
            consumed: Consumed::default(),
            most_usd: None,
            superseded: Vec::new(),
            run: None,
            claims: ClaimCounts::default(),
            cluster: Cluster::default(),
        }
    }

    /// What was spent on the question, all attempts together. The built-in judge, and what was not sent, cost nothing,
    /// which is known.
    #[must_use]
    pub fn spending(&self) -> Spending {
        let mut sum = Spending::default();
        let free = self.configuration.model == judge::MODEL || self.was_not_sent();
        if self.was_asked() {
            let cost = self.consumed.cost_usd.or(free.then_some(0.0));
            sum.add(cost, self.most_usd);
        }
        for attempt in &self.superseded {
            sum.add(attempt.consumed.cost_usd, attempt.most_usd);
        }
        sum
    }

    /// Whether there is a request behind it: what was cancelled or interrupted had one.
    fn was_asked(&self) -> bool {
        !matches!(self.status, AnswerStatus::Unasked(_)) || self.run.is_some()
    }

    /// Whether it is a failure without a request.
    fn was_not_sent(&self) -> bool {
        matches!(&self.status, AnswerStatus::Failed(why) if why.starts_with(NOT_SENT))
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

/// An answer, or its absence, and which variant of its scene it is about.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AnswerCase<'a> {
    /// The answer.
    pub scored: &'a Scored,
    /// The lead that its window was asked at; `None` where the batch names none, and outside of batches.
    pub lead: Option<Lead>,
}

impl<'a> AnswerCase<'a> {
    /// Answers about scenes without named leads.
    pub fn all(scored: &'a [Scored]) -> Vec<Self> {
        let case = |scored| Self { scored, lead: None };
        scored.iter().map(case).collect()
    }

    /// Name of the scenario as it was before a transform.
    #[must_use]
    pub fn scenario(&self) -> &'a str {
        Transform::of_name(&self.scored.scenario).0
    }

    /// The transform of its scene; `None` for the scene as it is.
    #[must_use]
    pub fn transform(&self) -> Option<Transform> {
        Transform::of_name(&self.scored.scenario).1
    }

    /// The lead in words: `1 s`, or `end`; `None` without one.
    #[must_use]
    pub fn lead_label(&self) -> Option<String> {
        self.lead.map(|lead| match lead {
            Lead::Paper => "end".into(),
            Lead::Seconds(_) => format!("{lead} s"),
        })
    }
}

impl Answer {
    /// Ids in the verdict that no obstacle of the scenario has, each once.
    #[must_use]
    pub fn unknown_obstacles(&self, scenario: &Scenario) -> Vec<i64> {
        let mut named: Vec<i64> = match &self.judged {
            JudgeOutcome::Verdict(Parsed { verdict, .. }) => {
                let critical = verdict.critical.iter().flatten().map(|o| o.id);
                critical
                    .chain(verdict.obstacles.iter().map(|o| o.id))
                    .collect()
            }
            JudgeOutcome::Other(reading) => reading.said.named(),
            JudgeOutcome::Missing(_) => Vec::new(),
        };
        named.retain(|id| scenario.obstacle(*id).is_none());
        named.sort_unstable();
        named.dedup();
        named
    }

    /// What makes it doubtful, in words: contradictions, and obstacles that it names twice or that the scene does not have.
    #[must_use]
    pub fn flags(&self, scenario: &Scenario) -> Vec<String> {
        let unknown = self.unknown_obstacles(scenario);
        match self.verdict() {
            Some(_) if self.model == judge::MODEL => Vec::new(),
            Some(verdict) => {
                let known = Verdict {
                    unknown,
                    ..verdict.clone()
                };
                known.flags()
            }
            None => unknown.into_iter().map(Verdict::names_unknown).collect(),
        }
    }

    /// Keeps with its verdict which obstacles the scene does not have.
    pub(super) fn note_unknown(&mut self, scenario: &Scenario) {
        let unknown = self.unknown_obstacles(scenario);
        if let JudgeOutcome::Verdict(parsed) = &mut self.judged {
            parsed.verdict.unknown = unknown;
        }
    }
}
