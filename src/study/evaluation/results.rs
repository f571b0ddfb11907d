//! Stored answers by prompt configuration: a matrix whose cells link to the answers.

use std::collections::BTreeMap;

use rayon::prelude::*;
use serde_json::{Value, json};

use super::share::Tally;
use super::statistics::{Interval, f1_interval, shown};
use super::{AnswerStatus, Cluster, Confusion, Naming, PromptConfig, Scored, Spending, report};
use nearmiss_store::{ClaimCounts, RunId};

/// Outcome of one question, compared with the ground truth.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
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
    pub way: PromptConfig,
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
    pub fn new(way: PromptConfig, mut answers: Vec<AnswerOutcome>, spending: Spending) -> Self {
        answers.sort_by(|a, b| (&a.scenario, a.sample, a.run).cmp(&(&b.scenario, b.sample, b.run)));
        let count = |outcome| answers.iter().filter(|a| a.outcome == outcome).count() as u32;
        Self {
            counts: Outcome::ALL.map(count),
            way,
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
                .entry(answer.cluster.of(&answer.scenario))
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
        row.f1 = shown(f1_interval(&counted), many);
        let mut right = Tally::default();
        for answer in &row.answers {
            let unit = answer.cluster.of(&answer.scenario);
            let is_right = answer.is_right.into_iter();
            is_right.for_each(|is_right| right.count(unit, is_right));
        }
        row.right_interval = right.share().interval;
    });
    rows
}

impl Results {
    /// One flat object, with the names of reports; missing values are null.
    #[must_use]
    pub fn json(&self) -> Value {
        let (c, naming) = (self.confusion(), self.naming());
        let ([right, wrong, open], checked) = self.claims();
        let mut row = report::way(&self.way);
        row.insert("n".into(), json!(self.answers.len()));
        row.extend(report::counts(&c));
        let rest = [
            ("unlabelled", json!(self.count(Outcome::Open))),
            ("unparsed", json!(self.count(Outcome::Unparsed))),
            ("failed", json!(self.count(Outcome::Failed))),
            ("right_of_all", json!(self.right_of_all())),
            (
                "right_of_all_ci",
                json!(self.right_interval.map(|i| [i.low, i.high])),
            ),
            ("precision", json!(c.precision())),
            ("recall", json!(c.recall())),
            ("f1", json!(c.f1())),
            ("f1_ci", json!(self.f1.map(|i| [i.low, i.high]))),
            ("naming_recall", json!(naming.recall())),
            ("naming_precision", json!(naming.precision())),
            ("claims_of", json!(checked)),
            ("claims_right", json!((checked > 0).then_some(right))),
            ("claims_wrong", json!((checked > 0).then_some(wrong))),
            ("claims_open", json!((checked > 0).then_some(open))),
            ("claims_wrong_share", json!(self.wrong_claims())),
            ("cost_usd", json!(self.spending.cost())),
            ("cost_unknown", json!(self.spending.unpriced())),
            ("cost_unknown_most_usd", json!(self.spending.most())),
        ];
        row.extend(rest.map(|(name, value)| (name.to_string(), value)));
        Value::Object(row)
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
    pub fn results(self, way: PromptConfig) -> Option<Results> {
        (!self.answers.is_empty()).then(|| Results::new(way, self.answers, self.spending))
    }
}

/// Answers by prompt configuration; questions that were not asked are left out.
#[must_use]
pub fn results<'a>(scored: impl IntoIterator<Item = &'a Scored>) -> Vec<Results> {
    let mut ways: BTreeMap<&PromptConfig, CountedWay> = BTreeMap::new();
    for one in scored {
        ways.entry(&one.way).or_default().take(one);
    }
    let by_way = ways.into_iter();
    by_way
        .filter_map(|(way, counted)| counted.results(way.clone()))
        .collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::evaluation::{Label, TemplateVersion};
    use nearmiss_scene::verdict::{Task, Verdict};

    fn scored(scenario: &str, status: AnswerStatus, truth: Option<bool>) -> Scored {
        let verdict = Verdict {
            task: Task::Collision,
            dangerous: true,
            obstacles: Vec::new(),
            justification: String::new(),
            critical: None,
            probability: None,
            token_probability: None,
            unknown: Vec::new(),
        };
        let label = |collides| {
            if collides {
                Label::Collision(None)
            } else {
                Label::Safe
            }
        };
        let mut scored = Scored::built_in(scenario, "m/x", truth.map(label), verdict);
        scored.status = status;
        scored
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
            one.way.template = version(hash);
        }
        let found = results(&all);
        let rows: Vec<_> = found.iter().map(|row| row.answers.len()).collect();
        assert_eq!(rows, [5, 2, 1]);
    }
}
