//! Tables over axes for people, papers and programs.

use std::collections::BTreeSet;

use serde_json::{Map, Value, json};

use super::super::contents::unit;
use super::super::document::{Align, Block, Document, Table};
use super::super::json::{counts, interval};
use super::super::{csv, methods, names, with_interval};
use super::{AxisValue, Difference, Measure, Pivot, PivotCell, PivotPart};
use crate::evaluation::Cluster;
use crate::evaluation::statistics::{Interval, shown};

impl Pivot {
    /// The tables for people, each with what its numbers are of.
    #[must_use]
    pub fn document(&self) -> Document {
        let mut blocks: Vec<Block> = self.about.notes.iter().cloned().map(Block::Text).collect();
        blocks.extend(self.tables().into_iter().map(Block::Table));
        blocks.push(Block::Heading("Method".into()));
        blocks.push(Block::Text(methods::intervals(self.unit())));
        if self.request.against.is_some() {
            blocks.push(Block::Text(paired(self.unit())));
        }
        Document {
            title: self.title(),
            blocks,
        }
    }

    /// The tables alone, task by task: the values, and where one is compared with, the differences.
    pub(crate) fn tables(&self) -> Vec<Table> {
        let mut tables = Vec::new();
        for part in &self.parts {
            tables.push(self.table(part));
            if self.request.against.is_some() {
                tables.push(self.against(part));
            }
        }
        tables
    }

    fn unit(&self) -> Cluster {
        let cells = self.parts.iter().flat_map(|part| &part.cells);
        unit(&cells.map(|one| &one.cell).collect::<Vec<_>>())
    }

    fn title(&self) -> String {
        let rows = self.request.rows.name();
        let by = match self.request.columns {
            Some(columns) => format!("{rows} and {}", columns.name()),
            None => rows.into(),
        };
        format!("{} by {by}", self.request.measure.title())
    }

    /// What a table is of: `F1 by model, safety task: 12 scenarios, 240 answers, asked …`.
    fn caption(&self, part: &PivotPart, title: &str) -> String {
        let task = part.task.map(|task| format!(", {} task", task.name()));
        let (scenarios, n) = part.counted;
        let asked = self.asked.words().map(|words| format!("; {words}"));
        format!(
            "{title}{}: {scenarios} scenarios, n = {n}{}",
            task.unwrap_or_default(),
            asked.unwrap_or_default()
        )
    }

    fn name(&self, part: &PivotPart, end: &str) -> String {
        let task = part.task.map_or("all", |task| task.name());
        let columns = self.request.columns.map(|axis| format!("-{}", axis.name()));
        let (measure, rows) = (self.request.measure.name(), self.request.rows.name());
        let name = format!(
            "nearmiss-{task}-{measure}-{rows}{}{end}",
            columns.unwrap_or_default()
        );
        name.replace('_', "-")
    }

    fn table(&self, part: &PivotPart) -> Table {
        let mut table = Table::new(
            self.caption(part, &self.title()),
            self.name(part, ""),
            &[&format!("<{}", capital(self.request.rows.name()))],
        );
        table.notes = vec![methods::intervals(self.unit())];
        table.notes.splice(0..0, self.about.notes.iter().cloned());
        let columns: BTreeSet<&Option<AxisValue>> =
            part.cells.iter().map(|one| &one.column).collect();
        match self.request.columns {
            None => table.columns.extend(
                [self.request.measure.title(), "n", "Scenarios"]
                    .map(|t| (t.to_string(), Align::Right)),
            ),
            Some(_) => table.columns.extend(
                columns
                    .iter()
                    .copied()
                    .flatten()
                    .map(|value| (value.text.clone(), Align::Right)),
            ),
        }
        let rows: BTreeSet<&AxisValue> = part.cells.iter().map(|one| &one.row).collect();
        for row in rows {
            let mut line = vec![row.text.clone()];
            for column in &columns {
                let found = part
                    .cells
                    .iter()
                    .find(|one| one.row == *row && one.column == **column);
                match (found, self.request.columns) {
                    (None, _) => line.push(names::NONE.into()),
                    (Some(one), Some(_)) => {
                        line.push(format!("{}, n = {}", self.value(one), self.counted(one)))
                    }
                    (Some(one), None) => line.extend([
                        self.value(one),
                        self.counted(one),
                        one.cell.scenarios.to_string(),
                    ]),
                }
            }
            table.rows.push(line);
        }
        table
    }

    /// How many questions a value is of: those with a verdict, where the others do not count.
    fn counted(&self, one: &PivotCell) -> String {
        let answered = one.cell.confusion.answered() + one.cell.unlabelled;
        let of_all = matches!(
            self.request.measure,
            Measure::RightOfAll | Measure::Seconds | Measure::Cost
        );
        if of_all || answered == one.cell.n {
            one.cell.n.to_string()
        } else {
            format!("{answered} of {}", one.cell.n)
        }
    }

    fn value(&self, one: &PivotCell) -> String {
        let measure = self.request.measure;
        with_interval(measure.value(&one.cell), measure.interval(&one.cell))
    }

    fn against(&self, part: &PivotPart) -> Table {
        let baseline = self.request.against.as_deref().unwrap_or_default();
        let title = format!(
            "Share of right answers by {} against {baseline}",
            self.request.rows.name()
        );
        let mut titles = vec![format!("<{}", capital(self.request.rows.name()))];
        titles.extend(
            self.request
                .columns
                .map(|axis| format!("<{}", capital(axis.name()))),
        );
        let unit = names::units(self.unit());
        titles.extend([unit, "Left out", "Difference", "p", "p (Holm)"].map(String::from));
        let titles: Vec<&str> = titles.iter().map(String::as_str).collect();
        let mut table = Table::new(
            self.caption(part, &title),
            self.name(part, "-against"),
            &titles,
        );
        table.notes = vec![paired(self.unit())];
        for one in &part.differences {
            let mut line = vec![one.row.text.clone()];
            line.extend(one.column.as_ref().map(|column| column.text.clone()));
            line.extend([
                one.units.to_string(),
                one.left_out.to_string(),
                signed(one),
                names::p_value(one.test.p),
                names::p_value(one.corrected),
            ]);
            table.rows.push(line);
        }
        table
    }

    /// Every number, unrounded.
    #[must_use]
    pub fn json(&self) -> Value {
        let tables = self.parts.iter().map(|part| {
            json!({
                "task": part.task.map(|task| task.name()),
                "scenarios": part.counted.0,
                "n": part.counted.1,
                "cells": part.cells.iter().map(|one| self.cell(one)).collect::<Vec<_>>(),
                "differences": part.differences.iter().map(|one| self.difference(one)).collect::<Vec<_>>(),
            })
        });
        let mut all = json!({
            "rows": self.request.rows.name(),
            "unit": self.unit().to_string(),
            "columns": self.request.columns.map(super::Axis::name),
            "measure": self.request.measure.name(),
            "against": self.request.against,
            "tables": tables.collect::<Vec<_>>(),
            "asked_ms": self.asked.asked_ms.map(|(first, last)| [first, last]),
            "models_returned": self.asked.returned,
        });
        for (name, value) in self.about.fields() {
            all[name] = value;
        }
        all
    }

    /// One line a cell, or a difference where there is a baseline, with the batch and the truth as the last columns.
    ///
    /// # Errors
    /// Never in practice: the writer's own words.
    pub fn csv(&self) -> Result<String, String> {
        csv(&self.rows())
    }

    /// The lines of [`Pivot::csv`] as objects.
    #[must_use]
    pub fn rows(&self) -> Vec<Value> {
        let mut lines = Vec::new();
        for part in &self.parts {
            let objects: Vec<Value> = if self.request.against.is_some() {
                part.differences
                    .iter()
                    .map(|one| self.difference(one))
                    .collect()
            } else {
                part.cells.iter().map(|one| self.cell(one)).collect()
            };
            for object in objects {
                let mut line = json!({ "task": part.task.map(|task| task.name()) });
                if let (Some(line), Value::Object(object)) = (line.as_object_mut(), object) {
                    // The axis may be the task itself.
                    line.extend(object);
                }
                for (name, value) in self.about.columns() {
                    line[name] = value;
                }
                lines.push(line);
            }
        }
        lines
    }

    /// The values of the axes.
    fn place(&self, row: &AxisValue, column: &Option<AxisValue>) -> Map<String, Value> {
        let mut map = Map::new();
        map.insert(self.request.rows.name().into(), json!(row.text));
        if let (Some(axis), Some(value)) = (self.request.columns, column) {
            map.insert(axis.name().into(), json!(value.text));
        }
        map
    }

    fn cell(&self, one: &PivotCell) -> Value {
        let measure = self.request.measure;
        let mut map = self.place(&one.row, &one.column);
        map.insert("n".into(), json!(one.cell.n));
        let answered = one.cell.confusion.answered() + one.cell.unlabelled;
        map.insert("answered".into(), json!(answered));
        map.insert("scenarios".into(), json!(one.cell.scenarios));
        map.insert(measure.name().into(), json!(measure.value(&one.cell)));
        let ends = interval(measure.interval(&one.cell));
        map.insert(format!("{}_ci", measure.name()), ends);
        map.extend(counts(&one.cell.confusion));
        Value::Object(map)
    }

    fn difference(&self, one: &Difference) -> Value {
        let mut map = self.place(&one.row, &one.column);
        let rest = json!({
            "against": self.request.against,
            "scenarios": one.units,
            "left_out": one.left_out,
            "difference": one.test.difference,
            "difference_ci": interval(shown(one.test.interval, one.units)),
            "p": one.test.p,
            "p_holm": one.corrected,
            "exact": one.test.exact,
            "detectable": one.test.detectable,
        });
        if let Value::Object(rest) = rest {
            map.extend(rest);
        }
        Value::Object(map)
    }
}

/// A difference with its sign and its interval: `−0.12 [−0.20, −0.03]`.
fn signed(one: &Difference) -> String {
    let number = |value: f64| match format!("{value:+.2}").as_str() {
        "+0.00" | "-0.00" => "0.00".to_string(),
        other => other.replace('-', "\u{2212}"),
    };
    let difference = number(one.test.difference);
    match shown(one.test.interval, one.units) {
        Some(Interval { low, high }) => format!("{difference} [{}, {}]", number(low), number(high)),
        None => difference,
    }
}

fn capital(word: &str) -> String {
    let mut letters = word.chars();
    let first = letters.next().map(|c| c.to_ascii_uppercase());
    first.into_iter().chain(letters).collect()
}

fn paired(unit: Cluster) -> String {
    format!(
        "Difference: the mean over {unit}s of the share of questions that are right of those asked minus that of the \
         baseline, over questions that are asked alike in all else, with its bootstrap interval over {unit}s. p is that of \
         the paired permutation test by {unit}; p (Holm) is corrected for all differences of the table."
    )
}
