//! The contents of a report: tables and figures, task by task.

use super::super::statistics::Interval;
use super::document::{Block, Document, Figure, Table};
use super::names::{self, NONE, number, p_value};
use super::{Cell, Report, methods, plot};
use crate::judge;
use crate::verdict::Task;

impl Report {
    /// The report for people, under a title; its notes say first what was counted.
    #[must_use]
    pub fn document(&self, title: &str) -> Document {
        let mut blocks: Vec<Block> = self.about.notes.iter().cloned().map(Block::Text).collect();
        blocks.extend(self.blocks());
        Document {
            title: title.into(),
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
            let mut first = quality(task, &cells);
            first.notes.splice(0..0, self.about.notes.iter().cloned());
            blocks.push(Block::Table(first));
            blocks.push(Block::Figures(
                format!("F1 with bootstrap intervals of 95 %, {} task", task.name()),
                vec![bars(task, &cells)],
            ));
            blocks.push(Block::Figures(
                "Confusion matrices: truth in rows, verdict in columns".into(),
                matrices(&cells),
            ));
            blocks.push(Block::Table(agreement(task, &cells)));
            blocks.push(Block::Figures(
                "Calibration: the share of true collisions by the gravest risk score, with Wilson intervals; dashed, the \
                 probability 1 − s/5 that a score is taken for; below, the answers with that score"
                    .into(),
                calibrations(&cells),
            ));
            blocks.extend(samples(task, &cells).map(Block::Table));
            blocks.extend(consumption(task, &cells).map(Block::Table));
            blocks.extend(self.pairs(task).map(Block::Table));
        }
        blocks.extend(self.varied.blocks());
        blocks.retain(|block| !matches!(block, Block::Figures(_, all) if all.is_empty()));
        blocks.push(Block::Heading("How it is counted".into()));
        blocks.extend(methods::all().map(Block::Text));
        blocks
    }

    fn pairs(&self, task: Task) -> Option<Table> {
        let mut table = Table::new(
            format!("Pairs of ways on the same scenarios, {} task", task.name()),
            format!("nearmiss-{}-pairs", task.name()),
            &[
                "<First",
                "<Second",
                "Scenarios",
                "Left out",
                "Only first right",
                "Only second right",
                "χ²",
                "p",
                "p (Holm)",
            ],
        );
        table.notes.push(methods::pairs());
        for pair in self.pairs.iter().filter(|p| p.first.task == task) {
            table.rows.push(vec![
                names::way(&pair.first),
                names::way(&pair.second),
                pair.n.to_string(),
                pair.left_out.to_string(),
                pair.test.only_first.to_string(),
                pair.test.only_second.to_string(),
                pair.test
                    .chi_square
                    .map_or_else(|| "exact".into(), |c| format!("{c:.2}")),
                p_value(pair.test.p),
                p_value(pair.corrected),
            ]);
        }
        (!table.rows.is_empty()).then_some(table)
    }
}

fn heading(task: Task) -> &'static str {
    match task {
        Task::Collision => "Collision evaluation",
        _ => "Safety inference",
    }
}

/// A table whose first columns say how was asked.
struct WayTable {
    table: Table,
    /// Whether the version of the template has a column: where it is not known of any, there is none.
    templates: bool,
}

const WAY: [&str; 3] = ["<Frame", "<Techniques", "<Model"];

impl WayTable {
    fn new(task: Task, cells: &[&Cell], (caption, name): (&str, &str), titles: &[&str]) -> Self {
        let templates = cells.iter().any(|cell| cell.way.template.is_some());
        let template: &[&str] = if templates { &["<Template"] } else { &[] };
        let table = Table::new(
            format!("{caption}, {} task", task.name()),
            format!("nearmiss-{}{name}", task.name()),
            &[&WAY, template, titles].concat(),
        );
        Self { table, templates }
    }

    /// The first cells of a row.
    fn way(&self, cell: &Cell) -> Vec<String> {
        let way = &cell.way;
        let mut row = vec![names::frame(way), names::techniques(way), way.model.clone()];
        if self.templates {
            row.push(names::template(way));
        }
        row
    }

    fn filled(self) -> Option<Table> {
        (!self.table.rows.is_empty()).then_some(self.table)
    }
}

/// A share with its interval: `0.83 [0.70, 0.91]`.
pub(crate) fn with_interval(value: Option<f64>, interval: Option<Interval>) -> String {
    match (value, interval) {
        (None, _) => NONE.into(),
        (Some(value), None) => format!("{value:.2}"),
        (Some(value), Some(i)) => format!("{value:.2} [{:.2}, {:.2}]", i.low, i.high),
    }
}

fn quality(task: Task, cells: &[&Cell]) -> Table {
    let unlabelled = cells.iter().any(|c| c.unlabelled > 0);
    let unasked = cells.iter().any(|c| c.unasked > 0);
    let mut titles = vec!["n", "TP", "FP", "FN", "TN"];
    if task == Task::Safety {
        titles.push("Wrong obstacle");
    }
    titles.extend(["Unparsed", "Failed"]);
    if unasked {
        titles.push("Not asked");
    }
    if unlabelled {
        titles.push("No truth");
    }
    titles.extend(["Precision", "Recall", "Specificity", "Accuracy", "F1"]);
    let mut filled = WayTable::new(task, cells, ("Accuracy of answers", ""), &titles);
    filled.table.notes = vec![methods::counts(), methods::intervals()];
    for cell in cells {
        let c = &cell.confusion;
        let mut row = filled.way(cell);
        let counts = [
            c.true_positives,
            c.false_positives,
            c.false_negatives,
            c.true_negatives,
        ];
        row.push(cell.n.to_string());
        row.extend(counts.map(|n| n.to_string()));
        if task == Task::Safety {
            row.push(cell.wrong_obstacle.to_string());
        }
        row.extend([cell.unparsed, cell.failed].map(|n| n.to_string()));
        if unasked {
            row.push(cell.unasked.to_string());
        }
        if unlabelled {
            row.push(cell.unlabelled.to_string());
        }
        row.push(with_interval(cell.precision(), cell.precision_interval()));
        row.push(with_interval(c.recall(), cell.recall_interval()));
        row.push(with_interval(c.specificity(), cell.specificity_interval()));
        row.push(with_interval(c.accuracy(), cell.accuracy_interval()));
        row.push(with_interval(cell.f1(), cell.f1_interval));
        filled.table.rows.push(row);
    }
    filled.table
}

fn agreement(task: Task, cells: &[&Cell]) -> Table {
    let titles = [
        "Named",
        "Named worst",
        "κ with the judge",
        "Same verdict",
        "Scored",
        "Brier",
        "ECE",
    ];
    let caption = "The obstacle that collides, agreement with the built-in judge, and calibration of risk scores";
    let mut filled = WayTable::new(task, cells, (caption, "-agreement"), &titles);
    filled.table.notes = vec![methods::agreement(), methods::intervals()];
    let of = |part: u32, all: u32| match all {
        0 => NONE.into(),
        _ => format!("{part} of {all}"),
    };
    for cell in cells {
        let mut row = filled.way(cell);
        row.push(of(cell.named.right, cell.named.n));
        row.push(of(cell.named.first, cell.named.n));
        let kappa = cell.kappa;
        row.push(with_interval(
            kappa.and_then(|k| k.kappa),
            kappa.and_then(|k| k.interval),
        ));
        row.push(number(kappa.map(|k| k.agreement), 2));
        row.push(cell.calibration.n().to_string());
        row.push(number(cell.calibration.brier(), 3));
        row.push(number(cell.calibration.error(), 3));
        filled.table.rows.push(row);
    }
    filled.table
}

fn samples(task: Task, cells: &[&Cell]) -> Option<Table> {
    let titles = [
        "Scenarios",
        "Unanimous",
        "Agreement",
        "Majority TP",
        "FP",
        "FN",
        "TN",
        "No vote",
        "F1",
    ];
    let caption = "Several samples and their majority";
    let mut filled = WayTable::new(task, cells, (caption, "-samples"), &titles);
    filled.table.notes.push(methods::samples());
    for cell in cells.iter().filter(|c| c.spread.scenarios > 0) {
        let c = &cell.majority;
        let counts = [
            c.true_positives,
            c.false_positives,
            c.false_negatives,
            c.true_negatives,
        ];
        let mut row = filled.way(cell);
        row.push(cell.spread.scenarios.to_string());
        row.push(number(cell.spread.unanimity(), 2));
        row.push(number(cell.spread.agreement(), 2));
        row.extend(counts.map(|n| n.to_string()));
        row.push(cell.undecided.to_string());
        row.push(number(c.f1(), 2));
        filled.table.rows.push(row);
    }
    filled.filled()
}

fn consumption(task: Task, cells: &[&Cell]) -> Option<Table> {
    let titles = [
        "Timed",
        "Median s",
        "95 % s",
        "Tokens known",
        "Input",
        "Output",
        "US dollars",
        "Cost unknown",
    ];
    let caption = "Time, tokens and cost";
    let mut filled = WayTable::new(task, cells, (caption, "-cost"), &titles);
    filled.table.notes.push(methods::consumption());
    for cell in cells {
        let c = &cell.consumption;
        if c.timed + c.counted + c.priced == 0 {
            continue;
        }
        let tokens = |n: u64| match c.counted {
            0 => NONE.into(),
            _ => n.to_string(),
        };
        let mut row = filled.way(cell);
        row.push(c.timed.to_string());
        row.push(number(c.median_s, 2));
        row.push(number(c.p95_s, 2));
        row.push(c.counted.to_string());
        row.push(tokens(c.input_tokens));
        row.push(tokens(c.output_tokens));
        row.push(number(c.cost_usd, 4));
        row.push(c.unpriced().to_string());
        filled.table.rows.push(row);
    }
    filled.filled()
}

fn bars(task: Task, cells: &[&Cell]) -> Figure {
    let bar = |cell: &&Cell| plot::Bar {
        name: names::way(&cell.way),
        value: cell.f1(),
        interval: cell.f1_interval,
        other: cell.way.model == judge::MODEL,
    };
    let title = format!("F1 with bootstrap intervals of 95 %, {} task", task.name());
    Figure {
        svg: plot::bars(&title, &cells.iter().map(bar).collect::<Vec<_>>()),
        caption: String::new(),
    }
}

fn matrices(cells: &[&Cell]) -> Vec<Figure> {
    let figure = |cell: &&Cell| {
        let aside = match cell.unparsed + cell.failed + cell.unasked {
            0 => String::new(),
            aside => format!("; {aside} without a verdict"),
        };
        let caption = format!("{}{aside}", names::way(&cell.way));
        Figure {
            svg: plot::confusion(
                &format!("Truth in rows, verdict in columns: {caption}"),
                &cell.confusion,
            ),
            caption,
        }
    };
    cells.iter().map(figure).collect()
}

fn calibrations(cells: &[&Cell]) -> Vec<Figure> {
    let scored = cells.iter().filter(|c| c.calibration.n() > 0);
    let figure = |cell: &&Cell| {
        let caption = names::way(&cell.way);
        Figure {
            svg: plot::calibration(
                &format!("Share of true collisions by risk score: {caption}"),
                &cell.calibration,
            ),
            caption,
        }
    };
    scored.map(figure).collect()
}
