//! Tables over axes for people, papers and programs.

use std::borrow::Cow;
use std::collections::BTreeSet;

use schemars::JsonSchema;
use serde::Serialize;

use super::super::contents::{record_rows, unit};
use super::super::document::{self, Block, Document};
use super::super::{FlatRows, ReportSubject, names};
use super::{Axis, AxisValue, Difference, Pivot, PivotCell, PivotPart};
use crate::evaluation::statistics::{Interval, PairedTest};
use crate::evaluation::{Cluster, Confusion};
use nearmiss_record::{CaptionedTable, Column, NONE, Record, columns, with_interval};
use std::collections::BTreeMap;

/// The answers with one value of each axis.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct AxisRow {
    /// The task; null of all.
    pub task: Option<&'static str>,
    /// The value of the rows' axis.
    #[schemars(title = "row")]
    pub row: String,
    /// That of the columns' axis; null without one.
    pub column: Option<String>,
    /// Questions.
    #[schemars(title = "n")]
    pub n: u32,
    /// Those with a verdict.
    #[schemars(title = "Answered")]
    pub answered: u32,
    /// Scenarios that they are about.
    #[schemars(title = "Scenarios")]
    pub scenarios: u32,
    /// What is measured.
    #[schemars(title = "value", extend("decimals" = 2))]
    pub value: Option<f64>,
    /// Its interval of 95 %.
    pub value_ci: Option<Interval>,
    /// Verdicts beside the truth.
    #[serde(flatten)]
    #[schemars(extend("table" = "counts"))]
    pub confusion: Confusion,
}

impl Record for AxisRow {
    const NAME: &'static str = "axis-value";
    const TITLE: &'static str = "A measure of the answers with one value of each axis";
}

/// A value of the rows' axis against the baseline, within a column.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct DifferenceRow {
    /// The task; null of all.
    pub task: Option<&'static str>,
    /// The value of the rows' axis.
    #[schemars(title = "row")]
    pub row: String,
    /// That of the columns' axis; null without one.
    #[schemars(title = "column", extend("rare" = true))]
    pub column: Option<String>,
    /// The value that it is compared with.
    pub against: String,
    /// Units that both were asked about alike in all else.
    #[schemars(title = "n")]
    pub n: u32,
    /// Units that both have questions about, and that at least one was not asked so.
    #[schemars(title = "Left out")]
    pub left_out: u32,
    /// By how much the value is right more often than the baseline.
    #[serde(flatten)]
    pub test: PairedTest,
    /// Its p value, corrected for all differences of the table, by Holm.
    #[schemars(title = "p (Holm)", extend("decimals" = 3, "bounded" = true))]
    pub p_holm: f64,
}

impl Record for DifferenceRow {
    const NAME: &'static str = "axis-difference";
    const TITLE: &'static str = "A value of an axis against the baseline";
}

/// Tables over axes for programs.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct AxesDocument {
    /// The axis of the rows.
    pub rows: &'static str,
    /// What intervals and comparisons take as one: scenario or map.
    pub unit: String,
    /// The axis of the columns.
    pub columns: Option<&'static str>,
    /// What is measured.
    pub measure: &'static str,
    /// The value of the rows that all others are compared with.
    pub against: Option<String>,
    /// A table for each task.
    pub tables: Vec<AxesTable>,
    /// When the first and the last answer was asked, milliseconds since 1970, UTC.
    pub asked_ms: Option<(i64, i64)>,
    /// The names that servers returned, by the model asked for.
    pub models_returned: BTreeMap<String, BTreeSet<String>>,
    /// Which answers these are, and beside which truth.
    #[serde(flatten)]
    pub about: ReportSubject,
}

/// The table of a task.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct AxesTable {
    /// The task; null of all.
    pub task: Option<&'static str>,
    /// Scenarios.
    pub scenarios: usize,
    /// Questions about them.
    pub n: usize,
    /// A measure of the answers with one value of each axis.
    pub cells: Vec<AxisRow>,
    /// Differences from the baseline, where there is one.
    pub differences: Vec<DifferenceRow>,
}

impl From<&Pivot> for AxesDocument {
    fn from(pivot: &Pivot) -> Self {
        let tables = pivot.parts.iter().map(|part| AxesTable {
            task: part.task.map(|task| task.name()),
            scenarios: part.counted.0,
            n: part.counted.1,
            cells: pivot.cells(part),
            differences: pivot.differences(part),
        });
        Self {
            rows: pivot.request.rows.name(),
            unit: pivot.unit().to_string(),
            columns: pivot.request.columns.map(Axis::name),
            measure: pivot.request.measure.name(),
            against: pivot.request.against.clone(),
            tables: tables.collect(),
            asked_ms: pivot.asked.asked_ms,
            models_returned: pivot.asked.returned.clone(),
            about: pivot.about.clone(),
        }
    }
}

impl Pivot {
    /// The tables for people, each with what its numbers are of.
    #[must_use]
    pub fn document(&self) -> Document {
        let mut blocks: Vec<Block> = self.about.notes.iter().cloned().map(Block::Text).collect();
        blocks.extend(self.tables().into_iter().map(Block::Table));
        blocks.push(Block::Heading("Method".into()));
        blocks.push(Block::Text(document::intervals(self.unit())));
        if self.request.against.is_some() {
            blocks.push(Block::Text(paired(self.unit())));
        }
        Document {
            title: self.title(),
            blocks,
        }
    }

    /// The tables alone, task by task: the values, and where one is compared with, the differences.
    pub(crate) fn tables(&self) -> Vec<CaptionedTable> {
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
        let asked = self.asked.summary().map(|words| format!("; {words}"));
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

    fn table(&self, part: &PivotPart) -> CaptionedTable {
        let caption = self.caption(part, &self.title());
        let name = self.name(part, "");
        let mut table = match self.request.columns {
            None => {
                let columns = self.titled(columns::<AxisRow>());
                CaptionedTable::new(caption, name, &columns, &record_rows(&self.cells(part)))
            }
            Some(_) => self.matrix(part, caption, name),
        };
        table.notes = self.about.notes.clone();
        table.notes.push(document::intervals(self.unit()));
        table
    }

    /// A table with a column for each value of the second axis.
    fn matrix(&self, part: &PivotPart, caption: String, name: String) -> CaptionedTable {
        let columns: BTreeSet<&Option<AxisValue>> =
            part.cells.iter().map(|one| &one.column).collect();
        let values = columns.iter().copied().flatten();
        let values = values.map(|value| (value.text.clone(), true));
        let rows: BTreeSet<&AxisValue> = part.cells.iter().map(|one| &one.row).collect();
        let row = |row: &AxisValue| {
            let cells = columns.iter().map(|column| {
                let is_here = |one: &&PivotCell| one.row == *row && one.column == **column;
                let found = part.cells.iter().find(is_here);
                found.map_or_else(|| NONE.into(), |one| self.value(one))
            });
            std::iter::once(row.text.clone()).chain(cells).collect()
        };
        CaptionedTable {
            caption,
            name,
            columns: std::iter::once((capital(self.request.rows.name()), false))
                .chain(values)
                .collect(),
            rows: rows.into_iter().map(row).collect(),
            notes: Vec::new(),
        }
    }

    /// A value with its interval, and how many questions it is of: those with a verdict, where the others do not count.
    fn value(&self, one: &PivotCell) -> String {
        let measure = self.request.measure;
        let of = &one.cell;
        let answered = of.confusion.answered() + of.unlabelled;
        let n = if measure.is_of_all() || answered == of.n {
            of.n.to_string()
        } else {
            format!("{answered} of {}", of.n)
        };
        let interval = measure.interval(of).map(Into::into);
        format!("{}, n = {n}", with_interval(measure.value(of), interval))
    }

    fn against(&self, part: &PivotPart) -> CaptionedTable {
        let baseline = self.request.against.as_deref().unwrap_or_default();
        let title = format!(
            "Share of right answers by {} against {baseline}",
            self.request.rows.name()
        );
        let table = CaptionedTable::new(
            self.caption(part, &title),
            self.name(part, "-against"),
            &self.titled(columns::<DifferenceRow>()),
            &record_rows(&self.differences(part)),
        );
        table.with_notes([paired(self.unit())])
    }

    /// Columns whose headings name the axes, the measure and the unit.
    fn titled(&self, mut columns: Vec<Column>) -> Vec<Column> {
        let compared = self.request.against.is_some();
        for column in &mut columns {
            column.title = match &*column.title {
                "row" => capital(self.request.rows.name()).into(),
                "column" => {
                    let axis = self.request.columns.map(|axis| capital(axis.name()));
                    axis.unwrap_or_default().into()
                }
                "value" => self.request.measure.title().into(),
                "n" if compared && column.source.starts_with("Units") => {
                    names::units(self.unit()).into()
                }
                "TP" | "FP" | "FN" | "TN" => "".into(),
                _ => continue,
            };
        }
        columns
    }

    /// The cells of a table as rows.
    fn cells(&self, part: &PivotPart) -> Vec<AxisRow> {
        let measure = self.request.measure;
        let row = |one: &PivotCell| AxisRow {
            task: part.task.map(|task| task.name()),
            row: one.row.text.clone(),
            column: one.column.as_ref().map(|value| value.text.clone()),
            n: one.cell.n,
            answered: one.cell.confusion.answered() + one.cell.unlabelled,
            scenarios: one.cell.scenarios,
            value: measure.value(&one.cell),
            value_ci: measure.interval(&one.cell),
            confusion: one.cell.confusion,
        };
        part.cells.iter().map(row).collect()
    }

    /// The differences of a table as rows.
    fn differences(&self, part: &PivotPart) -> Vec<DifferenceRow> {
        let row = |one: &Difference| DifferenceRow {
            task: part.task.map(|task| task.name()),
            row: one.row.text.clone(),
            column: one.column.as_ref().map(|value| value.text.clone()),
            against: self.request.against.clone().unwrap_or_default(),
            n: one.units,
            left_out: one.left_out,
            test: one.test,
            p_holm: one.corrected,
        };
        part.differences.iter().map(row).collect()
    }

    /// One row a cell, or a difference where there is a baseline; columns have the names of the axes and the measure.
    #[must_use]
    pub fn rows(&self) -> FlatRows {
        let parts = self.parts.iter();
        let rows = if self.request.against.is_some() {
            let rows = parts.flat_map(|part| self.differences(part)).collect();
            FlatRows::new(&[(&self.about, rows)])
        } else {
            let rows = parts.flat_map(|part| self.cells(part)).collect();
            FlatRows::new(&[(&self.about, rows)])
        };
        let axes = [Some(self.request.rows), self.request.columns];
        let measure = self.request.measure.name();
        rows.renamed(|name| match name {
            // The task is a column once.
            "task" if axes.contains(&Some(Axis::Task)) => None,
            "row" => Some(self.request.rows.name().into()),
            "column" => self.request.columns.map(|axis| axis.name().into()),
            _ => Some(match name.strip_prefix("value") {
                Some(end) => format!("{measure}{end}").into(),
                None => Cow::Owned(name.into()),
            }),
        })
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
