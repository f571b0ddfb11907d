//! The table of a batch: a row for each way of asking.

use serde_json::{Value, json};

use super::share;
use crate::cli::{Failure, output};
use crate::evaluation::report::technique;
use crate::evaluation::{Confusion, Said, Scored, Way};
use crate::store::BatchId;

/// What one way of asking reached.
pub struct Cell {
    way: Way,
    /// The half of the truth that it is about: collision, safe, or all of it.
    label: &'static str,
    counts: Confusion,
    unparsed: u32,
    failed: u32,
}

/// A cell for each way of asking, in the order in which they come.
pub fn cells(scored: &[Scored]) -> Vec<Cell> {
    let mut cells: Vec<(Cell, [bool; 2])> = Vec::new();
    for one in scored {
        let at = cells.iter().position(|(cell, _)| cell.way == one.way);
        let at = at.unwrap_or_else(|| {
            let cell = Cell {
                way: one.way.clone(),
                label: "all",
                counts: Confusion::default(),
                unparsed: 0,
                failed: 0,
            };
            cells.push((cell, [false; 2]));
            cells.len() - 1
        });
        let (cell, halves) = &mut cells[at];
        if let Some(collides) = one.is_collision() {
            halves[usize::from(collides)] = true;
        }
        match (&one.said, one.positive(), one.is_collision()) {
            (_, Some(said), Some(truth)) => cell.counts.count(said, truth),
            (Said::Failed(_), ..) => cell.failed += 1,
            (Said::Unparsed(_), ..) => cell.unparsed += 1,
            // Nobody says what is true, so that it is neither right nor wrong.
            (Said::Verdict(_), ..) => {}
        }
    }
    let named = cells.into_iter().map(|(mut cell, halves)| {
        cell.label = match halves {
            [false, true] => "collision",
            [true, false] => "safe",
            _ => "all",
        };
        cell
    });
    named.collect()
}

impl Cell {
    fn n(&self) -> u32 {
        self.counts.positives() + self.counts.negatives() + self.unparsed + self.failed
    }

    fn frame(&self) -> Option<&'static str> {
        self.way.frame.map(|frame| frame.name())
    }

    fn technique(&self) -> Option<String> {
        self.way.techniques.map(technique)
    }

    fn numbers(&self) -> [u32; 7] {
        let c = &self.counts;
        [
            self.n(),
            c.true_positives,
            c.false_positives,
            c.false_negatives,
            c.true_negatives,
            self.unparsed,
            self.failed,
        ]
    }
}

/// The names of [`Cell::numbers`].
const NUMBERS: [&str; 7] = ["n", "tp", "fp", "fn", "tn", "unparsed", "failed"];

/// As JSON.
pub fn document(batch: Option<BatchId>, cells: &[Cell]) -> Value {
    let cells = cells.iter().map(|cell| {
        let [n, tp, fp, fn_, tn, unparsed, failed] = cell.numbers();
        json!({
            "label": cell.label,
            "task": cell.way.task.name(),
            "frame": cell.frame(),
            "technique": cell.technique(),
            "model": cell.way.model,
            "n": n,
            "tp": tp,
            "fp": fp,
            "fn": fn_,
            "tn": tn,
            "unparsed": unparsed,
            "failed": failed,
            "precision": cell.counts.precision(),
            "recall": cell.counts.recall(),
            "f1": cell.counts.f1(),
        })
    });
    json!({
        "batch": batch.map(|id| id.to_string()),
        "cells": cells.collect::<Vec<_>>(),
    })
}

/// As CSV.
pub fn csv(cells: &[Cell]) -> Result<String, Failure> {
    let words = ["label", "task", "frame", "technique", "model"];
    let shares = ["precision", "recall", "f1"];
    let header = words.into_iter().chain(NUMBERS).chain(shares);
    let mut rows: Vec<Vec<String>> = vec![header.map(String::from).collect()];
    for cell in cells {
        let mut row = vec![
            cell.label.to_string(),
            cell.way.task.name().to_string(),
            cell.frame().unwrap_or_default().to_string(),
            cell.technique().unwrap_or_default(),
            output::visible(&cell.way.model),
        ];
        row.extend(cell.numbers().map(|n| n.to_string()));
        let counts = &cell.counts;
        let shares = [counts.precision(), counts.recall(), counts.f1()];
        row.extend(shares.map(|s| s.map_or_else(String::new, |s| s.to_string())));
        rows.push(row);
    }
    super::csv(&rows)
}

/// For people.
pub fn table(cells: &[Cell]) -> String {
    let width = cells.iter().map(|c| c.way.model.chars().count()).max();
    let width = width.unwrap_or(0).max("model".len());
    let mut text = format!(
        "{:<9} {:<9} {:<10} {:<width$} {:>5} {:>5} {:>5} {:>5} {:>5} {:>8} {:>6} {:>9} {:>6} {:>6}\n",
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
        "precision",
        "recall",
        "F1"
    );
    for cell in cells {
        let [n, tp, fp, fn_, tn, unparsed, failed] = cell.numbers();
        let counts = &cell.counts;
        text.push_str(&format!(
            "{:<9} {:<9} {:<10} {:<width$} {n:>5} {tp:>5} {fp:>5} {fn_:>5} {tn:>5} {unparsed:>8} {failed:>6} {:>9} {:>6} {:>6}\n",
            cell.way.task.name(),
            cell.frame().unwrap_or("–"),
            cell.technique().unwrap_or_else(|| "–".into()),
            cell.way.model,
            share(counts.precision()),
            share(counts.recall()),
            share(counts.f1()),
        ));
    }
    output::visible(&text)
}
