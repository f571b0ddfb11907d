//! Reports: figures from answers and ground truth, written for people, papers and programs.

mod cell;
mod charts;
mod comparison;
mod contents;
mod document;
mod names;
mod pivot;
mod prevalence;
mod published;
mod stored;
mod truth;
mod varied;

pub use cell::{
    CalibrationRow, Cell, ClaimTally, Consumption, DataHalf, Flagged, ProbabilitySources,
    SourcedCalibration,
};
pub use charts::ReportFigure;
pub(crate) use comparison::is_called;
pub use comparison::{Comparison, Family, Pair, Samples};
pub(crate) use contents::record_rows;
pub use contents::{PartProgress, RuleRow, SplitReport};
pub use document::{Block, Document, Figure, FlatRows, InSplit, IntervalMethods, ReportDocument};
pub(crate) use names::p_value;
pub use names::{ReportSubject, TruthSubject, configuration_name, model as model_name};
pub use pivot::{AskedFacts, AxesDocument, Axis, Measure, Pivot, PivotRequest};
pub use prevalence::{AtPrevalence, at_prevalence};
pub use published::{ComparisonRow, CountedCounts, Finding, PartRow, PrintedCounts};
pub use stored::{Stored, stored};
pub use truth::{AskedAs, BatchTruth, QuestionKey, RecordedScene, ScoreKey, Truth};
pub use varied::{InvarianceRow, LeadRow, LeadWord, SAME_WORDS, Varied};

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::{AnswerPage, Leak, PromptConfig, RuleScore, Scored};

/// Aggregated results of answers.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Report {
    /// For each way of asking, in their order: each half of the data that occurs, then all of it.
    pub cells: Vec<Cell>,
    /// Ways that are compared on the same scenarios.
    pub pairs: Vec<Pair>,
    /// Which answers these are, and beside which truth.
    pub about: ReportSubject,
    /// Of batches: changed scenes and other leads.
    pub varied: Varied,
    /// Tables over axes that were declared with the batch.
    pub tables: Vec<Pivot>,
    /// Of batches: how well what the questions look like tells their answers.
    pub leaks: Vec<Leak>,
    /// Of batches: what trivial rules come to on the same questions.
    pub rules: Vec<RuleScore>,
    /// What the ways come to at another share of dangerous questions, where that was asked for.
    pub prevalence: Vec<AtPrevalence>,
    /// The answers themselves, for the page that shows them.
    pub answers: AnswerPage,
}

impl Report {
    /// Counts answers, and compares every pair of ways that differ in one thing. The order of the answers does not
    /// matter.
    #[must_use]
    pub fn from_scored(scored: &[Scored]) -> Self {
        Self::compared(scored, &Comparison::default())
    }

    /// Counts answers, and makes the comparisons that were declared.
    #[must_use]
    pub fn compared(scored: &[Scored], comparison: &Comparison) -> Self {
        let configurations = configurations(scored);
        let cells = configurations.par_iter().map(|(configuration, of_way)| {
            let half = |half: DataHalf| {
                let part: Vec<&Scored> = of_way
                    .iter()
                    .copied()
                    .filter(|one| half.holds(one))
                    .collect();
                (!part.is_empty()).then(|| Cell::count(configuration, half, &part))
            };
            DataHalf::ALL
                .into_iter()
                .filter_map(half)
                .collect::<Vec<_>>()
        });
        Self {
            cells: cells.flatten().collect(),
            pairs: comparison::compare_pairs(&configurations, comparison),
            ..Self::default()
        }
    }

    /// The same report, saying what it is of; its notes begin with who left out much, and whose verdicts are doubtful.
    #[must_use]
    pub fn about(self, mut about: ReportSubject) -> Self {
        about.notes.splice(0..0, self.warnings());
        Self { about, ..self }
    }

    /// The same report, with the changed scenes and leads of its batch.
    #[must_use]
    pub fn varied(self, varied: Varied) -> Self {
        Self { varied, ..self }
    }

    /// The same report, with the tables that were declared.
    #[must_use]
    pub fn tables(self, tables: Vec<Pivot>) -> Self {
        Self { tables, ..self }
    }

    /// The same report, with what the questions of its batch give away.
    #[must_use]
    pub fn leaks(self, leaks: Vec<Leak>) -> Self {
        Self { leaks, ..self }
    }

    /// The same report, with what trivial rules come to.
    #[must_use]
    pub fn rules(self, rules: Vec<RuleScore>) -> Self {
        Self { rules, ..self }
    }

    /// The same report, with figures for another share of dangerous questions.
    #[must_use]
    pub fn prevalence(self, prevalence: Vec<AtPrevalence>) -> Self {
        Self { prevalence, ..self }
    }

    /// The same report, with the answers that it counts, to be read.
    #[must_use]
    pub fn answers(self, answers: AnswerPage) -> Self {
        Self { answers, ..self }
    }

    /// The cells of whole ways.
    pub fn full_cells(&self) -> impl Iterator<Item = &Cell> {
        self.cells.iter().filter(|cell| cell.half == DataHalf::All)
    }
}

/// The answers by way, in their order.
fn configurations<'a>(
    scored: impl IntoIterator<Item = &'a Scored>,
) -> Vec<(&'a PromptConfig, Vec<&'a Scored>)> {
    by_configuration(scored).into_iter().collect()
}

/// The answers by way.
pub(super) fn by_configuration<'a>(
    scored: impl IntoIterator<Item = &'a Scored>,
) -> BTreeMap<&'a PromptConfig, Vec<&'a Scored>> {
    let mut configurations: BTreeMap<&PromptConfig, Vec<&Scored>> = BTreeMap::new();
    for one in scored {
        configurations
            .entry(&one.configuration)
            .or_default()
            .push(one);
    }
    configurations
}

#[cfg(test)]
mod tests;
