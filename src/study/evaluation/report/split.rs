//! The report of a batch with a split: its dev and test parts as tables of their own, side by side in one file.

use serde_json::{Map, Value, json};

use super::document::{Block, Document};
use super::{Report, csv};
use crate::evaluation::{AnswerPage, Provenance};
use nearmiss_store::{SplitPart, SplitProgress};

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
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PartProgress {
    /// The part.
    pub part: SplitPart,
    /// Its questions.
    pub progress: SplitProgress,
    /// Whether nothing but this may be shown.
    pub locked: bool,
    /// Looks at its figures before it was complete.
    pub looks: usize,
}

impl PartProgress {
    fn json(&self) -> Value {
        json!({
            "split": self.part.name(),
            "questions": self.progress.questions,
            "answered": self.progress.answered,
            "locked": self.locked,
            "looks": self.looks,
        })
    }
}

/// One document of those of the parts: their lists one after the other, each row with its part; and how far the parts
/// are.
#[must_use]
pub fn joined(parts: &[(SplitPart, Value)], progress: &[PartProgress]) -> Value {
    let mut whole = Map::new();
    for (part, document) in parts {
        for (name, value) in document.as_object().into_iter().flatten() {
            let known = whole.entry(name.clone()).or_insert_with(|| match value {
                Value::Array(_) => json!([]),
                value => value.clone(),
            });
            if let (Value::Array(all), Value::Array(rows)) = (known, value) {
                for row in rows {
                    let row = tagged(*part, row.clone());
                    if !all.contains(&row) {
                        all.push(row);
                    }
                }
            }
        }
    }
    whole.insert(
        "splits".into(),
        progress.iter().map(PartProgress::json).collect(),
    );
    Value::Object(whole)
}

fn tagged(part: SplitPart, mut row: Value) -> Value {
    if let Some(row) = row.as_object_mut() {
        row.insert("split".into(), part.name().into());
    }
    row
}

impl SplitReport {
    /// As JSON: the lists of [`Report::json`], each row with its part, and how far the parts are.
    #[must_use]
    pub fn json(&self) -> Value {
        let parts: Vec<(SplitPart, Value)> = self
            .parts
            .iter()
            .map(|(part, report)| (*part, report.json()))
            .collect();
        let mut whole = joined(&parts, &self.progress);
        whole["provenance"] = json!(self.provenance);
        whole
    }

    /// The cells, one line each, with their part as the last column.
    ///
    /// # Errors
    /// Never in practice: the writer's own words.
    pub fn csv(&self) -> Result<String, String> {
        csv(&self.rows())
    }

    /// The lines of [`SplitReport::csv`] as objects.
    #[must_use]
    pub fn rows(&self) -> Vec<Value> {
        self.lines(Report::rows)
    }

    /// The comparisons of ways within each part, one line each.
    ///
    /// # Errors
    /// Never in practice: the writer's own words.
    pub fn pairs_csv(&self) -> Result<String, String> {
        csv(&self.lines(Report::pair_rows))
    }

    fn lines(&self, rows: impl Fn(&Report) -> Vec<Value>) -> Vec<Value> {
        let of_part = |(part, report): &(SplitPart, Report)| {
            let rows = rows(report).into_iter();
            rows.map(|row| tagged(*part, row)).collect::<Vec<_>>()
        };
        self.parts.iter().flat_map(of_part).collect()
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
