//! The subject of a report: which answers, how they were asked, and against which ground truth.

use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;

use crate::evaluation::Provenance;

/// Subject of a report.
#[derive(Debug, Clone, PartialEq, Default, Serialize, JsonSchema)]
pub struct ReportSubject {
    /// The batch, such as `b7`; null if the report is not of one.
    pub batch: Option<String>,
    /// What the batch is about, in a line: the title of documents.
    #[serde(skip)]
    pub title: Option<String>,
    /// The part of the batch's split, `dev` or `test`; `None` for all of it.
    #[serde(skip)]
    pub split: Option<&'static str>,
    /// How the batch asks, as it was begun; null if the report is not of one.
    pub asked: Option<Value>,
    /// The ground truth.
    pub truth: TruthSubject,
    /// Notes for the reader, in sentences.
    pub notes: Vec<String>,
    /// What it was made from: program, batch, days of the answers, models as returned, hashes of templates, scenarios and
    /// thresholds.
    pub provenance: Option<Provenance>,
}

/// The ground truth of a report.
#[derive(Debug, Clone, PartialEq, Default, Serialize, JsonSchema)]
pub struct TruthSubject {
    /// Its description.
    pub words: String,
    /// The same as words of `--truth`: `auto`, `layout`, files.
    pub sources: Vec<String>,
}
