//! The report of a batch with a split: its dev and test parts as tables of their own, side by side in one file.

use schemars::JsonSchema;
use serde::Serialize;

use super::document::{Block, Document};
use super::{FlatRows, Report, ReportDocument};
use crate::evaluation::{AnswerPage, Provenance};
use nearmiss_store::SplitPart;

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
