//! The contents of a report: tables and figures, task by task.

use super::super::Cluster;
use super::super::statistics::{Interval, shown};
use super::calibration_tables::{calibrations, probabilities, token_probabilities};
use super::document::{Block, Document, Table};
use super::figures::{bars, matrices};
use super::names::{self, NONE, number, p_value};
use super::{Cell, Pivot, Report, leaks, methods, prevalence, rules};
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
            let mut first = quality(task, &cells);
            first.notes.splice(0..0, self.about.notes.iter().cloned());
            first.notes.extend(dangerous(&cells));
            blocks.push(Block::Table(first));
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
            blocks.push(Block::Table(naming(task, &cells)));
            blocks.push(Block::Table(probabilities(task, &cells)));
            blocks.extend(token_probabilities(task, &cells).map(Block::Table));
            blocks.push(Block::Figures(
                "Calibration: the share of true collisions by tenths of the probability, with Wilson intervals that take answers as independent; dashed, \
                 where both are the same; below, the verdicts in each tenth"
                    .into(),
                calibrations(&cells),
            ));
            blocks.extend(samples(task, &cells).map(Block::Table));
            blocks.extend(claims(task, &cells).map(Block::Table));
            blocks.extend(consumption(task, &cells).map(Block::Table));
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

    fn pairs(&self, task: Task) -> Option<Table> {
        let mut table = Table::new(
            format!(
                "Comparisons on the same {}s, {} task",
                self.unit(),
                task.name()
            ),
            format!("nearmiss-{}-pairs", task.name()),
            &[
                "<First",
                "<Second",
                "<Family",
                names::units(self.unit()),
                "Left out",
                "Ties",
                "Difference",
                "Detectable",
                "p",
                "p (Holm)",
            ],
        );
        table.notes.push(methods::pairs(self.unit()));
        for pair in self.pairs.iter().filter(|p| p.first.task == task) {
            let test = &pair.test;
            table.rows.push(vec![
                names::way(&pair.first),
                names::way(&pair.second),
                pair.family.name().into(),
                pair.n.to_string(),
                pair.left_out.to_string(),
                pair.ties.to_string(),
                with_interval(Some(test.difference), shown(test.interval, pair.n)),
                number(test.detectable, 2),
                p_value(test.p),
                p_value(pair.corrected),
            ]);
        }
        (!table.rows.is_empty()).then_some(table)
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

/// A table whose rows are ways of asking.
pub(super) struct WayTable {
    pub(super) table: Table,
    /// Whether the values of axes have a column.
    settings: bool,
    /// Whether the version of the template has a column: where it is not known of any, there is none.
    templates: bool,
}

const WAY: [&str; 3] = ["<Frame", "<Techniques", "<Model"];

impl WayTable {
    pub(super) fn new(
        task: Task,
        cells: &[&Cell],
        (caption, name): (&str, &str),
        titles: &[&str],
    ) -> Self {
        let templates = cells.iter().any(|cell| cell.way.template.is_some());
        let settings = cells.iter().any(|cell| !cell.way.settings.is_empty());
        let setting: &[&str] = if settings { &["<Settings"] } else { &[] };
        let template: &[&str] = if templates { &["<Template"] } else { &[] };
        let table = Table::new(
            format!("{caption}, {} task", task.name()),
            format!("nearmiss-{}{name}", task.name()),
            &[&WAY, setting, template, titles].concat(),
        );
        Self {
            table,
            settings,
            templates,
        }
    }

    /// The first cells of a row.
    pub(super) fn way(&self, cell: &Cell) -> Vec<String> {
        let way = &cell.way;
        let mut row = vec![names::frame(way), names::techniques(way), way.model.clone()];
        if self.settings {
            row.push(names::settings(way));
        }
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
    let mut titles = vec![
        "n",
        "Right of all",
        "TP",
        "FP",
        "FN",
        "TN",
        "Unparsed",
        "Failed",
    ];
    if unasked {
        titles.push("Not asked");
    }
    if unlabelled {
        titles.push("No truth");
    }
    titles.extend(["Precision", "Recall", "Specificity", "Accuracy", "F1"]);
    let mut filled = WayTable::new(task, cells, ("Accuracy of answers", ""), &titles);
    filled.table.notes = vec![methods::counts(), methods::intervals(unit(cells))];
    for cell in cells {
        let c = &cell.confusion;
        let mut row = filled.way(cell);
        row.push(cell.n.to_string());
        row.push(with_interval(cell.right_of_all(), cell.intervals.right));
        row.extend(c.counts().map(|n| n.to_string()));
        row.extend([cell.unparsed, cell.failed].map(|n| n.to_string()));
        if unasked {
            row.push(cell.unasked.to_string());
        }
        if unlabelled {
            row.push(cell.unlabelled.to_string());
        }
        row.push(with_interval(cell.precision(), cell.intervals.precision));
        row.push(with_interval(c.recall(), cell.intervals.recall));
        row.push(with_interval(c.specificity(), cell.intervals.specificity));
        row.push(with_interval(c.accuracy(), cell.intervals.accuracy));
        row.push(with_interval(cell.f1(), cell.intervals.f1));
        filled.table.rows.push(row);
    }
    filled.table
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

fn naming(task: Task, cells: &[&Cell]) -> Table {
    let titles = [
        "Windows",
        "Obstacle named",
        "Named worst",
        "Names",
        "Names right",
        "κ with judge",
        "Same verdict",
    ];
    let caption = "Named obstacles, and agreement with the built-in judge";
    let mut filled = WayTable::new(task, cells, (caption, "-agreement"), &titles);
    filled.table.notes = vec![methods::naming(), methods::intervals(unit(cells))];
    for cell in cells {
        let (naming, intervals) = (&cell.naming, &cell.naming_intervals);
        let kappa = cell.kappa;
        let mut row = filled.way(cell);
        row.push(naming.windows.to_string());
        row.push(with_interval(naming.recall(), intervals.recall));
        row.push(naming.first.to_string());
        row.push(naming.named.to_string());
        row.push(with_interval(naming.precision(), intervals.precision));
        row.push(with_interval(
            kappa.and_then(|k| k.kappa),
            kappa.and_then(|k| k.interval),
        ));
        row.push(number(kappa.map(|k| k.agreement), 2));
        filled.table.rows.push(row);
    }
    filled.table
}

fn samples(task: Task, cells: &[&Cell]) -> Option<Table> {
    let titles = [
        "Questions",
        "Unanimous",
        "Agreement",
        "All right",
        "Majority TP",
        "FP",
        "FN",
        "TN",
        "Ties",
        "No vote",
        "Coverage",
        "F1",
    ];
    let caption = "Several samples and their majority";
    let mut filled = WayTable::new(task, cells, (caption, "-samples"), &titles);
    filled.table.notes.push(methods::samples());
    for cell in cells.iter().filter(|c| c.samples.spread.scenarios > 0) {
        let (samples, c) = (&cell.samples, &cell.samples.majority);
        let mut row = filled.way(cell);
        row.push(samples.spread.scenarios.to_string());
        row.push(number(samples.spread.unanimity(), 2));
        row.push(number(samples.spread.agreement(), 2));
        row.push(number(samples.all_right.share, 2));
        row.extend(c.counts().map(|n| n.to_string()));
        row.push(samples.ties.to_string());
        row.push((samples.undecided - samples.ties).to_string());
        row.push(number(samples.coverage(), 2));
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
        "at most",
        "Superseded",
    ];
    let caption = "Time, tokens and cost";
    let mut filled = WayTable::new(task, cells, (caption, "-cost"), &titles);
    filled.table.notes.push(methods::consumption());
    for cell in cells {
        let c = &cell.consumption;
        let of = &c.spending;
        if c.timed + c.counted + of.known + of.bounded == 0 {
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
        row.push(number(of.cost(), 4));
        row.push(of.unpriced().to_string());
        row.push(number(of.most(), 4));
        row.push(c.superseded.to_string());
        filled.table.rows.push(row);
    }
    filled.filled()
}

fn claims(task: Task, cells: &[&Cell]) -> Option<Table> {
    let titles = [
        "Checked",
        "Not checked",
        "Right",
        "Wrong",
        "Open",
        "Claims an answer",
        "Wrong share",
    ];
    let caption = "Claims about obstacles in the answers";
    let mut filled = WayTable::new(task, cells, (caption, "-claims"), &titles);
    filled.table.notes.push(methods::claims(unit(cells)));
    for cell in cells {
        let claims = &cell.claims;
        if claims.answers + claims.unchecked == 0 {
            continue;
        }
        let known = |n: u32| match claims.answers {
            0 => NONE.into(),
            _ => n.to_string(),
        };
        let mut row = filled.way(cell);
        row.extend([claims.answers, claims.unchecked].map(|n| n.to_string()));
        row.extend([claims.right, claims.wrong, claims.open].map(known));
        row.push(number(claims.per_answer(), 1));
        row.push(with_interval(claims.wrong_share(), claims.interval));
        filled.table.rows.push(row);
    }
    filled.filled()
}
