//! Rows of published numbers beside recorded answers.

use nearmiss_record::Record;
use nearmiss_store::SplitPart;
use schemars::JsonSchema;
use serde::Serialize;

use super::document::{Block, Document};
use super::{FlatRows, Report, ReportDocument};
use crate::evaluation::statistics::Interval;
use crate::evaluation::{AnswerPage, Confusion, PromptConfig, Provenance};

/// Comparison of recorded answers with a published count.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Finding {
    /// They could be a random part of the published ones.
    Agrees,
    /// A random part would be so far off with a probability below 0.05.
    Differs,
    /// They cannot be a part of the published ones: there are more of one kind than were published.
    Impossible,
    /// There are no recorded answers, or more than published ones.
    Missing,
}

/// A row of the paper beside the recorded answers, for programs.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct ComparisonRow {
    /// How was asked.
    #[serde(flatten)]
    pub configuration: PromptConfig,
    /// The table of the paper, I to IV.
    pub table: String,
    /// The paper's word for the techniques.
    pub method: String,
    /// The table in which the same row stands before: its counts are published once.
    pub repeats: Option<String>,
    /// What is printed.
    pub published: PrintedCounts,
    /// Where the printed rates do not follow from the printed counts.
    pub contradictions: Vec<String>,
    /// The recorded answers; null if there are none.
    pub recorded: Option<CountedCounts>,
    /// The built-in judge on the scenarios of the recorded answers of any way.
    pub reference: Option<CountedCounts>,
    /// The share of collisions that are found.
    pub collisions_found: PartRow,
    /// The share of normal scenarios that are mistaken for one.
    pub false_alarms: PartRow,
}

impl Record for ComparisonRow {
    const NAME: &'static str = "paper-comparison";
    const TITLE: &'static str = "A row of the paper beside the recorded answers";
}

/// Counts with the rates that are printed beside them.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct PrintedCounts {
    /// The four counts.
    #[serde(flatten)]
    pub counts: Confusion,
    /// Rounded to two decimals, as are the others.
    pub precision: f64,
    /// The recall.
    pub recall: f64,
    /// F1.
    pub f1: f64,
}

/// Counts with the rates that follow from them.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct CountedCounts {
    /// The four counts.
    #[serde(flatten)]
    pub counts: Confusion,
    /// Answers without a verdict.
    pub unparsed: u32,
    /// tp / (tp + fp).
    pub precision: Option<f64>,
    /// tp / (tp + fn).
    pub recall: Option<f64>,
    /// Harmonic mean of precision and recall.
    pub f1: Option<f64>,
    /// Its interval of 95 %.
    pub f1_ci: Option<Interval>,
}

/// A published share beside the recorded one.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct PartRow {
    /// The published share.
    pub published: Option<f64>,
    /// Its Wilson interval.
    pub published_ci: Option<Interval>,
    /// The recorded share.
    pub recorded: Option<f64>,
    /// Its Wilson interval.
    pub recorded_ci: Option<Interval>,
    /// The two-sided p value of the recorded ones being a random part of the published ones.
    pub p: Option<f64>,
    /// The conclusion.
    pub finding: Finding,
}

/// The reports of the parts that may be shown.
#[derive(Debug, Clone, PartialEq)]
pub struct SplitReport {
    /// The dev part, then the test part where it is not locked.
    pub parts: Vec<(SplitPart, Report)>,
    /// How far both parts are.
    pub progress: Vec<PartProgress>,
    /// What is to be said of the test part: how far it is, and looks before it was complete.
    pub notes: Vec<String>,
    /// The answers that may be shown, to read in.
    pub answers: AnswerPage,
    /// What all parts that are shown were made from.
    pub provenance: Option<Provenance>,
}

/// How far a part of a split is, for programs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
pub struct PartProgress {
    /// The part, dev or test.
    pub split: &'static str,
    /// Its questions.
    pub questions: u64,
    /// Those with an answer.
    pub answered: u64,
    /// Whether nothing but this may be shown.
    pub locked: bool,
    /// Looks at its figures before it was complete.
    pub looks: usize,
}

impl SplitReport {
    /// For programs: the lists of [`Report::json`], each row with its part, and how far the parts are.
    #[must_use]
    pub fn json(&self) -> ReportDocument {
        let mut document = ReportDocument::of_parts(&self.parts);
        document.about.provenance.clone_from(&self.provenance);
        document.splits.clone_from(&self.progress);
        document
    }

    /// The cells, one row each.
    #[must_use]
    pub fn rows(&self) -> FlatRows {
        let parts = self.parts.iter();
        let parts = parts.map(|(_, report)| (&report.about, report.cells.clone()));
        FlatRows::new(&parts.collect::<Vec<_>>())
    }

    /// The comparisons of ways within each part, one row each.
    #[must_use]
    pub fn pair_rows(&self) -> FlatRows {
        let parts = self.parts.iter();
        let parts = parts.map(|(_, report)| (&report.about, report.pairs.clone()));
        FlatRows::new(&parts.collect::<Vec<_>>())
    }

    /// The report for people, under a title.
    #[must_use]
    pub fn document(&self, title: &str) -> Document {
        let mut blocks: Vec<Block> = self.notes.iter().cloned().map(Block::Text).collect();
        let last = self.parts.len().saturating_sub(1);
        for (place, (part, report)) in self.parts.iter().enumerate() {
            let name = part.name();
            blocks.push(Block::Heading(format!("The {name} split")));
            let mut of_part = report.document("").blocks;
            if place < last {
                // The method is the same for both.
                let is_method = |block: &Block| *block == Block::Heading("Method".into());
                of_part.truncate(of_part.iter().position(is_method).unwrap_or(of_part.len()));
            }
            for block in &mut of_part {
                if let Block::Table(table) = block {
                    table.caption.push_str(&format!(", {name} split"));
                    table.name.push_str(&format!("-{name}"));
                }
            }
            blocks.extend(of_part);
        }
        let of_batch = self
            .parts
            .first()
            .and_then(|(_, report)| report.about.title.clone());
        Document {
            title: of_batch.unwrap_or_else(|| title.into()),
            blocks,
        }
    }
}
