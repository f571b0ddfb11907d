//! Rows of published numbers beside recorded answers.

use nearmiss_record::Record;
use schemars::JsonSchema;
use serde::Serialize;

use crate::evaluation::statistics::Interval;
use crate::evaluation::{Confusion, PromptConfig};

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
