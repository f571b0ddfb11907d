//! Stored answers by prompt configuration: a matrix whose cells link to the answers.

use std::collections::BTreeMap;

use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;
use strum::{IntoStaticStr, VariantArray};

use super::confusion::Tally;
use super::statistics::{Interval, f1_interval, if_enough};
use super::{AnswerStatus, Cluster, Confusion, Naming, PromptConfig, Scored, Spending};
use nearmiss_record::Record;
use nearmiss_store::{ClaimCounts, RunId};

/// Outcome of one question, compared with the ground truth; in the order of columns.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, IntoStaticStr, VariantArray)]
pub enum Outcome {
    /// It says yes, and it is.
    TruePositive,
    /// It says yes, and it is not.
    FalsePositive,
    /// It says no, and it is.
    FalseNegative,
    /// It says no, and it is not.
    TrueNegative,
    /// There is a verdict, and the truth is unknown.
    Open,
    /// An answer came, and no verdict could be read in it.
    Unparsed,
    /// No whole answer came.
    Failed,
}

nearmiss_record::named!(Outcome);

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
    /// Whether it is right, see [`Scored::is_right`].
    pub is_right: Option<bool>,
    /// The unit of intervals.
    pub cluster: Cluster,
    /// The obstacles that it names beside those that are truly critical.
    pub naming: Naming,
    /// Its claims about obstacles, where they were checked.
    pub claims: ClaimCounts,
}

/// The answers of one way of asking.
#[derive(Debug, Clone, PartialEq)]
pub struct Results {
    /// How it was asked.
    pub configuration: PromptConfig,
    /// The answers, by scenario and sample.
    pub answers: Vec<AnswerOutcome>,
    /// What was spent on the questions, every attempt included.
    pub spending: Spending,
    /// The interval of [`Self::right_of_all`], over units; `None` before [`with_intervals`] worked it out, and of few.
    pub right_interval: Option<Interval>,
    /// The bootstrap interval of F1, over units; `None` likewise.
    pub f1: Option<Interval>,
    /// How many answers came to each outcome, in their order.
    counts: [u32; Outcome::ALL.len()],
}

impl Outcome {
    /// Compares an answer with its ground truth; `None` if the question was not asked.
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
    /// An answer compared with its ground truth; `None` if the question was not asked.
    #[must_use]
    pub fn of_scored(scored: &Scored) -> Option<Self> {
        let outcome = Outcome::of_scored(scored)?;
        let mut naming = Naming::default();
        naming.count(scored);
        Some(Self {
            run: scored.run,
            scenario: scored.scenario.clone(),
            sample: scored.sample,
            outcome,
            is_right: scored.is_right(),
            cluster: scored.cluster,
            naming,
            claims: scored.claims,
        })
    }
}

impl Results {
    /// The answers of a way, in any order.
    #[must_use]
    pub fn new(
        configuration: PromptConfig,
        mut answers: Vec<AnswerOutcome>,
        spending: Spending,
    ) -> Self {
        answers.sort_by(|a, b| (&a.scenario, a.sample, a.run).cmp(&(&b.scenario, b.sample, b.run)));
        let count = |outcome| answers.iter().filter(|a| a.outcome == outcome).count() as u32;
        Self {
            counts: Outcome::ALL.map(count),
            configuration,
            answers,
            spending,
            right_interval: None,
            f1: None,
        }
    }

    /// How many answers came to this.
    #[must_use]
    pub fn count(&self, outcome: Outcome) -> u32 {
        let mut all = Outcome::ALL.iter().zip(self.counts);
        all.find(|(o, _)| **o == outcome).map_or(0, |(_, n)| n)
    }

    /// How often a truly critical obstacle is named, and only such.
    #[must_use]
    pub fn naming(&self) -> Naming {
        let mut all = Naming::default();
        self.answers.iter().for_each(|a| all.add(&a.naming));
        all
    }

    /// Right, wrong and open claims about obstacles of the answers that were checked, and how many these are.
    #[must_use]
    pub fn claims(&self) -> ([u32; 3], u32) {
        let known = self.answers.iter().filter_map(|a| a.claims.known());
        known.fold(([0; 3], 0), |(sum, answers), counts| {
            ([0, 1, 2].map(|i| sum[i] + counts[i]), answers + 1)
        })
    }

    /// The share of wrong claims of those that are right or wrong.
    #[must_use]
    pub fn wrong_claims(&self) -> Option<f64> {
        let ([right, wrong, _], _) = self.claims();
        (right + wrong > 0).then(|| f64::from(wrong) / f64::from(right + wrong))
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

    /// How many are right, and how many with a truth were asked.
    #[must_use]
    pub fn right(&self) -> (u32, u32) {
        let known = self.answers.iter().filter_map(|answer| answer.is_right);
        known.fold((0, 0), |(right, asked), is_right| {
            (right + u32::from(is_right), asked + 1)
        })
    }

    /// The share of the questions asked that is right: no verdict is not.
    #[must_use]
    pub fn right_of_all(&self) -> Option<f64> {
        let (right, asked) = self.right();
        (asked > 0).then(|| f64::from(right) / f64::from(asked))
    }

    /// The same counts of each unit.
    fn by_unit(&self) -> Vec<Confusion> {
        let mut found: BTreeMap<&str, Confusion> = BTreeMap::new();
        for answer in &self.answers {
            let counts = found
                .entry(answer.cluster.unit(&answer.scenario))
                .or_default();
            match answer.outcome {
                Outcome::TruePositive => counts.true_positives += 1,
                Outcome::FalsePositive => counts.false_positives += 1,
                Outcome::FalseNegative => counts.false_negatives += 1,
                Outcome::TrueNegative => counts.true_negatives += 1,
                Outcome::Open | Outcome::Unparsed | Outcome::Failed => {}
            }
        }
        found.into_values().filter(|c| c.answered() > 0).collect()
    }
}

/// The rows with the intervals of what is right and of F1, as reports have them.
#[must_use]
pub fn with_intervals(mut rows: Vec<Results>) -> Vec<Results> {
    rows.par_iter_mut().for_each(|row| {
        let counted: Vec<Confusion> = row.by_unit();
        let many = u32::try_from(counted.len()).unwrap_or(u32::MAX);
        row.f1 = if_enough(f1_interval(&counted), many);
        let mut right = Tally::default();
        for answer in &row.answers {
            let unit = answer.cluster.unit(&answer.scenario);
            let is_right = answer.is_right.into_iter();
            is_right.for_each(|is_right| right.count(unit, is_right));
        }
        row.right_interval = right.share().interval;
    });
    rows
}

/// A way of asking on the screen of results, with the names of reports.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct ResultsRow {
    /// How it was asked.
    #[serde(flatten)]
    pub configuration: PromptConfig,
    /// Questions that were asked.
    pub n: usize,
    /// Verdicts beside the truth.
    #[serde(flatten)]
    pub confusion: Confusion,
    /// Verdicts without a truth.
    pub unlabelled: u32,
    /// Answers without a verdict.
    pub unparsed: u32,
    /// Questions without a whole answer.
    pub failed: u32,
    /// The share of the questions asked that it is right about.
    pub right_of_all: Option<f64>,
    /// Its interval of 95 %.
    pub right_of_all_ci: Option<Interval>,
    /// tp / (tp + fp).
    pub precision: Option<f64>,
    /// tp / (tp + fn).
    pub recall: Option<f64>,
    /// Harmonic mean of precision and recall.
    pub f1: Option<f64>,
    /// Its interval of 95 %.
    pub f1_ci: Option<Interval>,
    /// The share of dangerous windows of which a critical obstacle is named.
    pub naming_recall: Option<f64>,
    /// The share of named obstacles that are critical.
    pub naming_precision: Option<f64>,
    /// Answers whose claims were checked.
    pub claims_of: u32,
    /// Claims that hold; null if none was checked.
    pub claims_right: Option<u32>,
    /// Claims that do not; null if none was checked.
    pub claims_wrong: Option<u32>,
    /// Claims that cannot be decided; null if none was checked.
    pub claims_open: Option<u32>,
    /// The share of wrong claims of those that are right or wrong.
    pub claims_wrong_share: Option<f64>,
    /// What the attempts of known cost cost, US dollars.
    pub cost_usd: Option<f64>,
    /// Attempts of unknown cost.
    pub cost_unknown: u32,
    /// What those of them cost at most that a price and a limit bound, US dollars.
    pub cost_unknown_most_usd: Option<f64>,
    /// The ground truth.
    pub truth: String,
}

impl Record for ResultsRow {
    const NAME: &'static str = "results";
    const TITLE: &'static str = "A way of asking on the screen of results";
}

impl Results {
    /// For programs, with what it is compared with.
    #[must_use]
    pub fn row(&self, truth: &str) -> ResultsRow {
        let (c, naming) = (self.confusion(), self.naming());
        let ([right, wrong, open], checked) = self.claims();
        let known = |count: u32| (checked > 0).then_some(count);
        ResultsRow {
            configuration: self.configuration.clone(),
            n: self.answers.len(),
            confusion: c,
            unlabelled: self.count(Outcome::Open),
            unparsed: self.count(Outcome::Unparsed),
            failed: self.count(Outcome::Failed),
            right_of_all: self.right_of_all(),
            right_of_all_ci: self.right_interval,
            precision: c.precision(),
            recall: c.recall(),
            f1: c.f1(),
            f1_ci: self.f1,
            naming_recall: naming.recall(),
            naming_precision: naming.precision(),
            claims_of: checked,
            claims_right: known(right),
            claims_wrong: known(wrong),
            claims_open: known(open),
            claims_wrong_share: self.wrong_claims(),
            cost_usd: self.spending.cost(),
            cost_unknown: self.spending.unpriced(),
            cost_unknown_most_usd: self.spending.most(),
            truth: truth.into(),
        }
    }
}

/// The answers of a way, as they are counted one by one.
#[derive(Debug, Default)]
pub(super) struct CountedWay {
    answers: Vec<AnswerOutcome>,
    spending: Spending,
}

impl CountedWay {
    /// Counts an answer; gives `false` where the question was not asked.
    pub fn take(&mut self, scored: &Scored) -> bool {
        self.spending.join(&scored.spending());
        let answer = AnswerOutcome::of_scored(scored);
        let asked = answer.is_some();
        self.answers.extend(answer);
        asked
    }

    /// What they come to; `None` if no question was asked.
    pub fn results(self, configuration: PromptConfig) -> Option<Results> {
        (!self.answers.is_empty()).then(|| Results::new(configuration, self.answers, self.spending))
    }
}

/// Answers by prompt configuration; questions that were not asked are left out.
#[must_use]
pub fn results<'a>(scored: impl IntoIterator<Item = &'a Scored>) -> Vec<Results> {
    let mut configurations: BTreeMap<&PromptConfig, CountedWay> = BTreeMap::new();
    for one in scored {
        configurations
            .entry(&one.configuration)
            .or_default()
            .take(one);
    }
    let by_way = configurations.into_iter();
    by_way
        .filter_map(|(configuration, counted)| counted.results(configuration.clone()))
        .collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::evaluation::{Label, TemplateVersion};
    use nearmiss_scene::verdict::{Task, Verdict};

    fn scored(scenario: &str, status: AnswerStatus, truth: Option<bool>) -> Scored {
        let label = |collides| {
            if collides {
                Label::Collision(None)
            } else {
                Label::Safe
            }
        };
        let truth = truth.map(label);
        Scored::built_in(scenario, "m/x", Task::Collision, truth, status)
    }

    fn said(dangerous: bool) -> AnswerStatus {
        AnswerStatus::Verdict(Verdict {
            task: Task::Collision,
            dangerous,
            obstacles: Vec::new(),
            justification: String::new(),
            critical: None,
            probability: None,
            token_probability: None,
            unknown: Vec::new(),
        })
    }

    #[test]
    fn every_outcome_has_its_cell_and_versions_of_a_prompt_are_rows_of_their_own() {
        let failed = || AnswerStatus::Failed(String::new());
        let mut all = vec![
            scored("a", said(true), Some(true)),
            scored("b", said(true), Some(false)),
            scored("c", said(false), Some(true)),
            scored("d", said(false), Some(false)),
            scored("e", said(true), None),
            scored("f", AnswerStatus::Unparsed(String::new()), Some(true)),
            scored("g", failed(), None),
            scored("h", failed(), Some(true)),
            scored("i", AnswerStatus::Unasked(String::new()), Some(true)),
        ];
        let found = with_intervals(results(&all));
        assert_eq!(found.len(), 1);
        let counts = Outcome::ALL.map(|outcome| found[0].count(outcome));
        assert_eq!(counts, [1, 1, 1, 1, 1, 1, 2]);
        assert_eq!(found[0].confusion().f1(), Some(0.5));
        assert_eq!(
            found[0].f1, None,
            "an interval of four scenarios says nothing"
        );
        // The same way with another text of the template is another row.
        let version = |hash: &str| TemplateVersion::new("mine.md", Some("3"), hash);
        for (one, hash) in all.iter_mut().zip(["11", "22", "11"]) {
            one.configuration.template = version(hash);
        }
        let found = results(&all);
        let rows: Vec<_> = found.iter().map(|row| row.answers.len()).collect();
        assert_eq!(rows, [5, 2, 1]);
    }
}
