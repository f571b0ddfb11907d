//! The subject of a report: which answers, how they were asked, and against which ground truth.

use serde_json::{Value, json};

use crate::evaluation::Provenance;

/// Subject of a report.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ReportSubject {
    /// The batch, such as `b7`; `None` if the report is not of one.
    pub batch: Option<String>,
    /// What the batch is about, in a line: the title of documents.
    pub title: Option<String>,
    /// The part of the batch's split, `dev` or `test`; `None` for all of it.
    pub split: Option<&'static str>,
    /// How the batch asks, as its [`Spec`](crate::evaluation::batch::Spec) says it.
    pub asked: Option<Value>,
    /// Description of the ground truth.
    pub truth: String,
    /// The same as words of `--truth`: `auto`, `layout`, files.
    pub sources: Vec<String>,
    /// Notes for the reader, in sentences.
    pub notes: Vec<String>,
    /// What it was made from.
    pub provenance: Option<Provenance>,
}

impl ReportSubject {
    /// The fields that stand beside `cells`.
    pub(super) fn fields(&self) -> [(&'static str, Value); 5] {
        [
            ("batch", json!(self.batch)),
            ("asked", json!(self.asked)),
            (
                "truth",
                json!({ "words": self.truth, "sources": self.sources }),
            ),
            ("notes", json!(self.notes)),
            ("provenance", json!(self.provenance)),
        ]
    }

    /// The last columns of every line of CSV.
    pub(super) fn columns(&self) -> [(&'static str, Value); 2] {
        [("batch", json!(self.batch)), ("truth", json!(self.truth))]
    }
}
