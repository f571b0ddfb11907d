//! The table of a batch: one row for each prompt configuration, counted as in `report`.

use serde_json::{Map, Value, json};

use super::share;
use crate::cli::Outcome;
use crate::cli::output::Align::{self, Left, Right};
use crate::cli::output::{self, Cell, Kind};
use crate::evaluation::report::{self, Half, Report, technique};
use crate::evaluation::{PromptConfig, Scored};
use crate::store::BatchId;

/// The rows of a batch's table: for each way of asking all of its answers, and which half of the data they are about.
pub struct Rows(Vec<(Half, report::Cell)>);

/// What a row says; `report` says more.
const FIELDS: [&str; 18] = [
    "label",
    "task",
    "frame",
    "technique",
    "model",
    "n",
    "tp",
    "fp",
    "fn",
    "tn",
    "unparsed",
    "failed",
    "unasked",
    "unlabelled",
    "fn_wrong_obstacle",
    "precision",
    "recall",
    "f1",
];

impl Rows {
    /// Counts the answers of a batch.
    pub fn of(scored: &[Scored]) -> Self {
        let report = Report::from_scored(scored);
        let half = |way: &PromptConfig| {
            let mut halves = report.cells.iter().filter(|cell| cell.way == *way);
            match (halves.next(), halves.next(), halves.next()) {
                // One half and the whole, which are the same.
                (Some(only), Some(_), None) => only.half,
                _ => Half::All,
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

    /// Writes them as CSV.
    pub fn write_csv(&self) -> Outcome {
        let head = FIELDS.map(String::from).to_vec();
        let rows = self.objects().map(|object| {
            let cells = FIELDS.iter().map(|name| Cell::from_json(&object[*name]));
            let texts = cells.map(|cell| cell.text(Kind::Float).unwrap_or_default().into_owned());
            texts.collect()
        });
        output::csv(std::iter::once(head).chain(rows))
    }

    /// For people.
    pub fn table(&self) -> String {
        let width = self.0.iter().map(|(_, c)| c.way.model.chars().count());
        let width = width.max().unwrap_or(0).max("model".len());
        // Most batches have none of either; then there is no column of zeros.
        let unasked = self.0.iter().any(|(_, cell)| cell.unasked > 0);
        let unlabelled = self.0.iter().any(|(_, cell)| cell.unlabelled > 0);
        let another = self.0.iter().any(|(_, cell)| cell.wrong_obstacle > 0);
        let columns = [
            ("task", Left(9), true),
            ("frame", Left(9), true),
            ("techniques", Left(10), true),
            ("model", Left(width), true),
            ("n", Right(5), true),
            ("tp", Right(5), true),
            ("fp", Right(5), true),
            ("fn", Right(5), true),
            ("tn", Right(5), true),
            ("unparsed", Right(8), true),
            ("failed", Right(6), true),
            ("not asked", Right(9), unasked),
            ("no truth", Right(8), unlabelled),
            // Of the false negatives those that say yes.
            ("named another", Right(13), another),
            ("precision", Right(9), true),
            ("recall", Right(6), true),
            ("F1", Right(6), true),
        ];
        let shown = |place: &usize| columns[*place].2;
        let places: Vec<usize> = (0..columns.len()).filter(shown).collect();
        let aligned: Vec<Align> = places.iter().map(|i| columns[*i].1).collect();
        let titles: Vec<&str> = places.iter().map(|i| columns[*i].0).collect();
        let mut text = output::line(" ", &aligned, &titles);
        for (_, cell) in &self.0 {
            let (way, c) = (&cell.way, &cell.confusion);
            let cells = [
                way.task.name().to_string(),
                way.frame.map_or("–", |frame| frame.name()).to_string(),
                way.techniques.map_or_else(|| "–".into(), technique),
                way.model.clone(),
                cell.n.to_string(),
                c.true_positives.to_string(),
                c.false_positives.to_string(),
                c.false_negatives.to_string(),
                c.true_negatives.to_string(),
                cell.unparsed.to_string(),
                cell.failed.to_string(),
                cell.unasked.to_string(),
                cell.unlabelled.to_string(),
                cell.wrong_obstacle.to_string(),
                share(cell.precision()),
                share(c.recall()),
                share(c.f1()),
            ];
            let cells: Vec<&String> = places.iter().map(|i| &cells[*i]).collect();
            text += &output::line(" ", &aligned, &cells);
        }
        text
    }
}
