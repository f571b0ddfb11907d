//! The table of a batch: one row for each prompt configuration, counted as in `report`.

use serde_json::{Map, Value, json};

use super::share;
use crate::Outcome;
use crate::output::Align::{self, Left, Right};
use crate::output::{self, Cell, Kind};
use nearmiss_store::{BatchId, SplitPart};
use nearmiss_study::evaluation::report::{self, DataHalf, Report, technique};
use nearmiss_study::evaluation::{PromptConfig, Scored};

/// The rows of a batch's table: for each way of asking all of its answers, and which half of the data they are about.
pub struct Rows(Vec<(DataHalf, report::Cell)>);

/// What a row says; `report` says more.
const FIELDS: [&str; 21] = [
    "label",
    "task",
    "frame",
    "technique",
    "model",
    "n",
    "right_of_all",
    "tp",
    "fp",
    "fn",
    "tn",
    "unparsed",
    "failed",
    "unasked",
    "unlabelled",
    "precision",
    "recall",
    "f1",
    "naming_recall",
    "naming_precision",
    "settings",
];

/// Titles of the columns that say how was asked.
pub const WAY: [&str; 4] = ["task", "frame", "techniques", "model"];

/// The columns [`WAY`] for names of models of this width.
pub fn way_columns(width: usize) -> [Align; 4] {
    [9, 9, 10, width].map(Left)
}

/// The cells of the columns [`WAY`].
pub fn way_cells(way: &PromptConfig) -> [String; 4] {
    [
        way.task.name().to_string(),
        way.frame.map_or("–", |frame| frame.name()).to_string(),
        way.techniques.map_or_else(|| "–".into(), technique),
        report::model_name(way),
    ]
}

impl Rows {
    /// Counts the answers of a batch.
    pub fn from_scored(scored: &[Scored]) -> Self {
        let report = Report::from_scored(scored);
        let half = |way: &PromptConfig| {
            let mut halves = report.cells.iter().filter(|cell| cell.way == *way);
            match (halves.next(), halves.next(), halves.next()) {
                // One half and the whole, which are the same.
                (Some(only), Some(_), None) => only.half,
                _ => DataHalf::All,
            }
        };
        let rows = report.whole().map(|cell| (half(&cell.way), cell.clone()));
        Self(rows.collect())
    }

    fn objects(&self) -> impl Iterator<Item = Map<String, Value>> {
        self.0.iter().map(|(half, cell)| {
            let all = cell.json();
            let mut object: Map<String, Value> = FIELDS
                .iter()
                .map(|name| ((*name).to_string(), all[*name].clone()))
                .collect();
            object.insert("label".into(), json!(half.name()));
            object.insert("techniques".into(), all["techniques"].clone());
            object
        })
    }

    /// As JSON.
    pub fn document(&self, batch: Option<BatchId>) -> Value {
        json!({
            "batch": batch.map(|id| id.to_string()),
            "cells": self.objects().collect::<Vec<_>>(),
        })
    }

    /// Writes the rows of each part of a split as CSV, or all rows of a batch without one.
    pub fn write_csv(parts: &[(Option<SplitPart>, &Self)]) -> Outcome {
        let has_parts = parts.iter().any(|(part, _)| part.is_some());
        let head = FIELDS.iter().copied().chain(has_parts.then_some("split"));
        let head: Vec<String> = head.map(String::from).collect();
        let row = |part: Option<SplitPart>, object: Map<String, Value>| -> Vec<String> {
            let cells = FIELDS.iter().map(|name| Cell::from_json(&object[*name]));
            let texts = cells.map(|cell| cell.text(Kind::Float).unwrap_or_default().into_owned());
            texts
                .chain(part.map(|part| part.name().to_string()))
                .collect()
        };
        let rows = parts
            .iter()
            .flat_map(|(part, rows)| rows.objects().map(|object| row(*part, object)));
        output::csv(std::iter::once(head).chain(rows))
    }

    /// For people.
    pub fn table(&self) -> String {
        let names = self.0.iter().map(|(_, c)| report::model_name(&c.way));
        let width = names
            .map(|name| name.chars().count())
            .max()
            .unwrap_or(0)
            .max("model".len());
        // Most batches have none of either; then there is no column of zeros.
        let unasked = self.0.iter().any(|(_, cell)| cell.unasked > 0);
        let unlabelled = self.0.iter().any(|(_, cell)| cell.unlabelled > 0);
        let named = self.0.iter().any(|(_, cell)| cell.naming.windows > 0);
        let columns = [
            ("n", 5, true),
            ("right", 6, true),
            ("tp", 5, true),
            ("fp", 5, true),
            ("fn", 5, true),
            ("tn", 5, true),
            ("unparsed", 8, true),
            ("failed", 6, true),
            ("not asked", 9, unasked),
            ("no truth", 8, unlabelled),
            ("precision", 9, true),
            ("recall", 6, true),
            ("F1", 6, true),
            ("obstacle named", 14, named),
            ("names right", 11, named),
        ];
        let shown = columns.iter().filter(|(.., shown)| *shown);
        let widths = shown.clone().map(|(_, width, _)| Right(*width));
        let titles = shown.map(|(title, ..)| *title);
        let aligned: Vec<Align> = way_columns(width).into_iter().chain(widths).collect();
        let titles: Vec<&str> = WAY.into_iter().chain(titles).collect();
        let mut text = output::line(" ", &aligned, &titles);
        for (_, cell) in &self.0 {
            let c = &cell.confusion;
            let figures = [
                cell.n.to_string(),
                share(cell.right_of_all()),
                c.true_positives.to_string(),
                c.false_positives.to_string(),
                c.false_negatives.to_string(),
                c.true_negatives.to_string(),
                cell.unparsed.to_string(),
                cell.failed.to_string(),
                cell.unasked.to_string(),
                cell.unlabelled.to_string(),
                share(cell.precision()),
                share(c.recall()),
                share(c.f1()),
                share(cell.naming.recall()),
                share(cell.naming.precision()),
            ]
            .into_iter()
            .zip(columns)
            .filter_map(|(figure, (.., shown))| shown.then_some(figure));
            let cells: Vec<String> = way_cells(&cell.way).into_iter().chain(figures).collect();
            text += &output::line(" ", &aligned, &cells);
        }
        text
    }
}
