//! The contents of a report: tables and figures, task by task.

use super::super::Cluster;
use super::document::{Block, Document};
use super::figures::{bars, calibrations, matrices};
use super::{Cell, Pair, Pivot, Report, leaks, methods, names, prevalence, rules};
use nearmiss_record::{CaptionedTable, Column, Kind, Record, Row, columns_of, rows};
use nearmiss_scene::verdict::Task;

impl Report {
    /// The report for people, under the title of its batch, else this one; its notes say first what was counted.
    #[must_use]
    pub fn document(&self, title: &str) -> Document {
        let mut blocks: Vec<Block> = self.about.notes.iter().cloned().map(Block::Text).collect();
        blocks.extend(self.blocks());
        Document {
            title: self.about.title.clone().unwrap_or_else(|| title.into()),
            blocks,
        }
    }

    pub(crate) fn blocks(&self) -> Vec<Block> {
        let mut blocks = Vec::new();
        for task in Task::VERDICTS {
            let cells: Vec<&Cell> = self.whole().filter(|c| c.way.task == task).collect();
            if cells.is_empty() {
                continue;
            }
            blocks.push(Block::Heading(heading(task).into()));
            let of = |title: &str, name: &str, cells: &[&Cell]| table(task, (title, name), cells);
            let unit = unit(&cells);
            let notes = self.about.notes.iter().cloned();
            let notes = notes.chain([methods::counts(), methods::intervals(unit)]);
            let first = of("Accuracy of answers", "accuracy", &cells);
            blocks.push(Block::Table(
                first.with_notes(notes.chain(dangerous(&cells))),
            ));
            blocks.extend(prevalence::table(task, &self.prevalence, &self.rules).map(Block::Table));
            blocks.extend(rules::table(task, &self.rules).map(Block::Table));
            blocks.push(Block::Figures(
                format!(
                    "Right of all asked with intervals of 95 %, {} task",
                    task.name()
                ),
                vec![bars(task, &cells)],
            ));
            blocks.push(Block::Figures(
                "Confusion matrices: truth in rows, verdict in columns".into(),
                matrices(&cells),
            ));
            let title = "Named obstacles, and agreement with the built-in judge";
            let notes = [methods::naming(), methods::intervals(unit)];
            let named = of(title, "agreement", &cells).with_notes(notes);
            blocks.push(Block::Table(named));
            let fit = of("Calibration of probabilities", "calibration", &cells);
            blocks.push(Block::Table(fit.with_notes([methods::calibration()])));
            if cells.iter().any(|cell| cell.token_calibration.n > 0) {
                let fit = of(
                    "Calibration of log probabilities",
                    "log-probabilities",
                    &cells,
                );
                blocks.push(Block::Table(fit.with_notes([methods::token_calibration()])));
            }
            blocks.push(Block::Figures(
                "Calibration: the share of true collisions by tenths of the probability, with Wilson intervals that take answers as independent; dashed, \
                 where both are the same; below, the verdicts in each tenth"
                    .into(),
                calibrations(&cells),
            ));
            let some = |title, name, has: fn(&Cell) -> bool, note: String| {
                let cells: Vec<&Cell> = cells.iter().copied().filter(|cell| has(cell)).collect();
                let table = of(title, name, &cells).with_notes([note]).filled();
                table.map(Block::Table)
            };
            blocks.extend(some(
                "Several samples and their majority",
                "samples",
                |cell| cell.samples.scenarios > 0,
                methods::samples(),
            ));
            blocks.extend(some(
                "Claims about obstacles in the answers",
                "claims",
                |cell| cell.claims.answers + cell.claims.unchecked > 0,
                methods::claims(unit),
            ));
            blocks.extend(some(
                "Time, tokens and cost",
                "cost",
                |cell| cell.consumption.is_known(),
                methods::consumption(),
            ));
            blocks.extend(self.pairs(task).map(Block::Table));
        }
        if !self.tables.is_empty() {
            blocks.push(Block::Heading("Tables of the experiment".into()));
            let tables = self.tables.iter().flat_map(Pivot::tables);
            blocks.extend(tables.map(Block::Table));
        }
        blocks.extend(self.varied.blocks());
        blocks.extend(leaks::table(&self.leaks).map(Block::Table));
        blocks.retain(|block| !matches!(block, Block::Figures(_, all) if all.is_empty()));
        blocks.push(Block::Heading("Method".into()));
        blocks.extend(methods::all(self.unit()).map(Block::Text));
        if let Some(provenance) = &self.about.provenance {
            blocks.push(Block::Heading("Provenance".into()));
            blocks.push(Block::Text(provenance.words()));
        }
        blocks
    }

    /// The unit of its intervals and comparisons.
    pub(super) fn unit(&self) -> Cluster {
        unit(&self.cells.iter().collect::<Vec<_>>())
    }

    fn pairs(&self, task: Task) -> Option<CaptionedTable> {
        let pairs: Vec<&Pair> = { self.pairs.iter() }
            .filter(|pair| pair.first.task == task)
            .collect();
        let mut columns = columns_of::<Pair>("");
        // The two ways are named, not shown part by part.
        for column in &mut columns {
            if column.name.contains('.') {
                column.title = "".into();
            } else if column.name == "n" {
                column.title = names::units(self.unit()).into();
            }
        }
        let named = ["First", "Second"].map(|title| Column {
            title: title.into(),
            ..Column::new("", Kind::Text, "", "")
        });
        columns.splice(0..0, named);
        let mut rows = rows_of(pairs.iter().copied());
        for (row, pair) in rows.iter_mut().zip(&pairs) {
            row.splice(
                0..0,
                [&pair.first, &pair.second].map(|way| names::way(way).into()),
            );
        }
        let caption = format!(
            "Comparisons on the same {}s, {} task",
            self.unit(),
            task.name()
        );
        let name = format!("nearmiss-{}-pairs", task.name());
        let table = CaptionedTable::new(caption, name, &columns, &rows);
        table.with_notes([methods::pairs(self.unit())]).filled()
    }
}

/// The unit of intervals, which all cells of a report share.
pub(super) fn unit(cells: &[&Cell]) -> Cluster {
    cells
        .first()
        .map_or_else(Cluster::default, |cell| cell.cluster)
}

fn heading(task: Task) -> &'static str {
    match task {
        Task::Collision => "Collision evaluation",
        Task::Recording => "Recordings, safe or of high risk",
        _ => "Safety inference",
    }
}

/// The rows of records, whose maps have words as keys.
pub(crate) fn rows_of<'r, R: Record + 'r>(records: impl IntoIterator<Item = &'r R>) -> Vec<Row> {
    rows(records).unwrap_or_default()
}

/// The columns of one of a noun's tables about one task, which the caption names.
pub(super) fn columns_of_task<R: Record>(table: &str) -> Vec<Column> {
    let mut columns = columns_of::<R>(table);
    let task = columns.iter_mut().find(|column| column.name == "task");
    task.into_iter().for_each(|column| column.title = "".into());
    columns
}

/// A table of a task with a row for each cell.
fn table(task: Task, (title, name): (&str, &str), cells: &[&Cell]) -> CaptionedTable {
    let end = if name == "accuracy" {
        String::new()
    } else {
        format!("-{name}")
    };
    CaptionedTable::new(
        format!("{title}, {} task", task.name()),
        format!("nearmiss-{}{end}", task.name()),
        &columns_of_task::<Cell>(name),
        &rows_of(cells.iter().copied()),
    )
}

/// How many of the questions are dangerous, which figures depend on.
fn dangerous(cells: &[&Cell]) -> Option<String> {
    let cell = cells.iter().max_by_key(|cell| cell.asked)?;
    let share = 100.0 * f64::from(cell.dangerous) / f64::from(cell.asked);
    (cell.asked > 0).then(|| {
        format!(
            "Dangerous are {} of {} questions asked ({share:.0} %): right of all, precision, accuracy and F1 hold for this \
             share alone; --prevalence 0.01 shows them for another.",
            cell.dangerous, cell.asked
        )
    })
}
