//! The table of a batch: one row for each prompt configuration, counted as in `report`.

use serde_json::{Map, Value, json};

use super::share;
use crate::cli::{Failure, output};
use crate::evaluation::report::{Cell, DataHalf, Report, technique};
use crate::evaluation::{PromptConfig, Scored};
use crate::store::BatchId;

/// The rows of a batch's table: for each way of asking all of its answers, and which half of the data they are about.
pub struct Rows(Vec<(DataHalf, Cell)>);

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

    /// As CSV.
    pub fn csv(&self) -> Result<String, Failure> {
        let mut rows = vec![FIELDS.map(String::from).to_vec()];
        for object in self.objects() {
            let cell = |name: &&str| match &object[*name] {
                Value::Null => String::new(),
                Value::String(text) => output::visible(text),
                other => other.to_string(),
            };
            rows.push(FIELDS.iter().map(cell).collect());
        }
        super::csv(&rows)
    }

    /// For people.
    pub fn table(&self) -> String {
        let width = self.0.iter().map(|(_, c)| c.way.model.chars().count());
        let width = width.max().unwrap_or(0).max("model".len());
        // Most batches have none of either; then there is no column of zeros.
        let unasked = self.0.iter().any(|(_, cell)| cell.unasked > 0);
        let unlabelled = self.0.iter().any(|(_, cell)| cell.unlabelled > 0);
        let another = self.0.iter().any(|(_, cell)| cell.wrong_obstacle > 0);
        let more = |asked: &str, labelled: &str| {
            let mut words = String::new();
            if unasked {
                words += &format!(" {asked:>9}");
            }
            if unlabelled {
                words += &format!(" {labelled:>8}");
            }
            words
        };
        // Of the false negatives those that say yes.
        let named = |words: &str| match another {
            true => format!(" {words:>13}"),
            false => String::new(),
        };
        let mut text = format!(
            "{:<9} {:<9} {:<10} {:<width$} {:>5} {:>5} {:>5} {:>5} {:>5} {:>8} {:>6}{}{} {:>9} {:>6} {:>6}\n",
            "task",
            "frame",
            "techniques",
            "model",
            "n",
            "tp",
            "fp",
            "fn",
            "tn",
            "unparsed",
            "failed",
            more("not asked", "no truth"),
            named("named another"),
            "precision",
            "recall",
            "F1"
        );
        for (_, cell) in &self.0 {
            let (way, c) = (&cell.way, &cell.confusion);
            text.push_str(&format!(
                "{:<9} {:<9} {:<10} {:<width$} {:>5} {:>5} {:>5} {:>5} {:>5} {:>8} {:>6}{}{} {:>9} {:>6} {:>6}\n",
                way.task.name(),
                way.frame.map_or("–", |frame| frame.name()),
                way.techniques.map_or_else(|| "–".into(), technique),
                way.model,
                cell.n,
                c.true_positives,
                c.false_positives,
                c.false_negatives,
                c.true_negatives,
                cell.unparsed,
                cell.failed,
                more(&cell.unasked.to_string(), &cell.unlabelled.to_string()),
                named(&cell.wrong_obstacle.to_string()),
                share(cell.precision()),
                share(c.recall()),
                share(cell.f1()),
            ));
        }
        output::visible(&text)
    }
}
