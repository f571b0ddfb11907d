//! Reports as JSON: every number, unrounded.

use schemars::JsonSchema;
use serde::Serialize;

use super::super::statistics::{DRAWS, RESAMPLES, SEED};
use super::super::{Cluster, Leak};
use super::pivot::AxesDocument;
use super::rules::RuleRow;
use super::{
    AtPrevalence, Cell, ComparisonRow, InvarianceRow, LeadRow, Pair, PartProgress, Report,
    ReportSubject,
};
use nearmiss_store::SplitPart;

/// A row with the part of a split that it is of.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct InSplit<R> {
    /// The row.
    #[serde(flatten)]
    pub row: R,
    /// The part, dev or test; missing without a split.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub split: Option<&'static str>,
}

impl<R> InSplit<R> {
    /// Rows of a part of a split, or of a batch without one.
    pub fn all(split: Option<SplitPart>, rows: impl IntoIterator<Item = R>) -> Vec<Self> {
        let split = split.map(SplitPart::name);
        let rows = rows.into_iter();
        rows.map(|row| Self { row, split }).collect()
    }
}

/// How the 95 % intervals are computed.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct IntervalMethods {
    /// Their level.
    pub level: f64,
    /// What is drawn as a whole: scenario or map.
    pub unit: String,
    /// How those of proportions are computed.
    pub proportions: String,
    /// How those of F1 are computed.
    pub f1: String,
    /// Draws of the bootstrap.
    pub resamples: usize,
    /// How configurations are compared.
    pub comparisons: String,
    /// Random permutations, where not all are tried.
    pub permutations: usize,
    /// Seed of all draws.
    pub seed: u64,
}

impl IntervalMethods {
    fn of(unit: Cluster) -> Self {
        Self {
            level: 0.95,
            unit: unit.to_string(),
            proportions: format!(
                "Wilson with one answer a {unit}, else percentile bootstrap over {unit}s"
            ),
            f1: format!("percentile bootstrap over {unit}s"),
            resamples: RESAMPLES,
            comparisons: format!("paired permutation test by {unit}"),
            permutations: DRAWS,
            seed: SEED,
        }
    }
}

/// A report for programs.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct ReportDocument {
    /// One prompt configuration each, on half of the data or all of it.
    pub cells: Vec<InSplit<Cell>>,
    /// Paired permutation tests between prompt configurations, by scenario or map.
    pub pairs: Vec<InSplit<Pair>>,
    /// How the 95 % intervals are computed.
    pub intervals: IntervalMethods,
    /// Which answers these are, and beside which truth.
    #[serde(flatten)]
    pub about: ReportSubject,
    /// Which verdicts changed on transformed scenes.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub invariance: Vec<InSplit<InvarianceRow>>,
    /// Results by lead of the safety task.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub lead: Vec<InSplit<LeadRow>>,
    /// Tables over axes that were declared with the batch.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub tables: Vec<InSplit<AxesDocument>>,
    /// What trivial rules come to on the same questions.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub rules: Vec<InSplit<RuleRow>>,
    /// What the configurations come to at another share of dangerous questions.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub prevalence: Vec<InSplit<AtPrevalence>>,
    /// How well position, length and traffic of the questions tell their answers, by lead.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub leaks: Vec<InSplit<Leak>>,
    /// Published numbers beside those recomputed, with --paper.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub comparisons: Vec<ComparisonRow>,
    /// Of a batch with a split: the progress of each part, whether it is locked, and looks at it before it was complete.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub splits: Vec<PartProgress>,
}

impl ReportDocument {
    /// Of a batch or of a part of its split.
    fn new(report: &Report, part: Option<SplitPart>) -> Self {
        Self {
            cells: InSplit::all(part, report.cells.iter().cloned()),
            pairs: InSplit::all(part, report.pairs.iter().cloned()),
            intervals: IntervalMethods::of(report.unit()),
            about: report.about.clone(),
            invariance: InSplit::all(part, report.varied.changes()),
            lead: InSplit::all(part, report.varied.by_lead()),
            tables: InSplit::all(part, report.tables.iter().map(AxesDocument::from)),
            rules: InSplit::all(part, report.rules.iter().map(RuleRow::from)),
            prevalence: InSplit::all(part, report.prevalence.iter().cloned()),
            leaks: InSplit::all(part, report.leaks.iter().cloned()),
            comparisons: Vec::new(),
            splits: Vec::new(),
        }
    }

    /// Of the parts of a split: their lists one after the other, each row with its part.
    pub(super) fn of_parts(parts: &[(SplitPart, Report)]) -> Self {
        let documents = { parts.iter() }.map(|(part, report)| Self::new(report, Some(*part)));
        let joined = documents.reduce(|mut all, part| {
            all.cells.extend(part.cells);
            all.pairs.extend(part.pairs);
            all.invariance.extend(part.invariance);
            all.lead.extend(part.lead);
            all.tables.extend(part.tables);
            all.rules.extend(part.rules);
            all.prevalence.extend(part.prevalence);
            all.leaks.extend(part.leaks);
            let known = all.about.notes.clone();
            let notes = part.about.notes.into_iter();
            all.about
                .notes
                .extend(notes.filter(|note| !known.contains(note)));
            all
        });
        joined.unwrap_or_else(|| Self::new(&Report::default(), None))
    }
}

impl Report {
    /// The report for programs; missing values are null.
    #[must_use]
    pub fn json(&self) -> ReportDocument {
        ReportDocument::new(self, None)
    }
}
