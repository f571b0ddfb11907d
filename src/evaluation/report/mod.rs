//! Reports: figures from answers and ground truth, written for people, papers and programs.

mod cell;
mod consumption;
mod contents;
mod csv;
mod document;
mod html;
mod json;
mod latex;
mod markdown;
mod methods;
mod names;
mod pairs;
mod plot;
mod stored;
mod subject;
mod truth;
mod varied;

pub use cell::{Cell, DataHalf, NamingCounts};
pub use consumption::Consumption;
pub(crate) use contents::with_interval;
pub use csv::csv;
pub use document::{Align, Block, Document, Table};
pub(crate) use json::{counts, way};
pub use names::technique;
pub(crate) use names::{NONE, number, p_value};
pub use pairs::Pair;
pub use stored::{Stored, stored};
pub use subject::ReportSubject;
pub use truth::{QuestionKey, RecordedScene, Truth};
pub use varied::{SAME_WORDS, Varied};

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::{PromptConfig, Scored};

/// Aggregated results of answers.
#[derive(Debug, Clone, PartialEq)]
pub struct Report {
    /// For each way of asking, in their order: each half of the data that occurs, then all of it.
    pub cells: Vec<Cell>,
    /// Ways that differ in one thing, on the same scenarios.
    pub pairs: Vec<Pair>,
    /// Which answers these are, and beside which truth.
    pub about: ReportSubject,
    /// Of batches: changed scenes and other leads.
    pub varied: Varied,
}

impl Report {
    /// Counts answers. The order of the answers does not matter.
    #[must_use]
    pub fn from_scored(scored: &[Scored]) -> Self {
        let mut ways: BTreeMap<&PromptConfig, Vec<&Scored>> = BTreeMap::new();
        for one in scored {
            ways.entry(&one.way).or_default().push(one);
        }
        let ways: Vec<(&PromptConfig, Vec<&Scored>)> = ways.into_iter().collect();
        let cells = ways.par_iter().map(|(way, of_way)| {
            let half = |half: DataHalf| {
                let part: Vec<&Scored> = of_way
                    .iter()
                    .copied()
                    .filter(|one| half.holds(one))
                    .collect();
                (!part.is_empty()).then(|| Cell::count(way, half, &part))
            };
            DataHalf::ALL
                .into_iter()
                .filter_map(half)
                .collect::<Vec<_>>()
        });
        Self {
            cells: cells.flatten().collect(),
            pairs: pairs::compare_pairs(&ways),
            about: ReportSubject::default(),
            varied: Varied::default(),
        }
    }

    /// The same report, saying what it is of.
    #[must_use]
    pub fn about(self, about: ReportSubject) -> Self {
        Self { about, ..self }
    }

    /// The same report, with the changed scenes and leads of its batch.
    #[must_use]
    pub fn varied(self, varied: Varied) -> Self {
        Self { varied, ..self }
    }

    /// The cells of whole ways.
    pub fn whole(&self) -> impl Iterator<Item = &Cell> {
        self.cells.iter().filter(|cell| cell.half == DataHalf::All)
    }
}

#[cfg(test)]
mod tests;
