//! The contents of a report: tables and figures, task by task, and what is said before every table; those of the parts of
//! a split one after the other.

use nearmiss_record::{CaptionedTable, Column, Kind, Record, Row, columns, columns_of, rows};
use nearmiss_scene::judge;
use nearmiss_scene::verdict::Task;
use nearmiss_store::SplitPart;
use schemars::JsonSchema;
use serde::Serialize;

use super::super::windows::{CLEAR, MATCHED_ON};
use super::super::{Cluster, Confusion, Leak, RuleScore, SURFACE};
use super::document::{self, Block, Document, Figure};
use super::{
    Cell, DataHalf, FlatRows, Pair, Pivot, Report, ReportDocument, charts, configurations, names,
    prevalence,
};
use crate::evaluation::{AnswerPage, Provenance, Scored};

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
            let cells: Vec<&Cell> = self
                .full_cells()
                .filter(|c| c.configuration.task == task)
                .collect();
            if cells.is_empty() {
                continue;
            }
            blocks.push(Block::Heading(heading(task).into()));
            let of = |title: &str, name: &str, cells: &[&Cell]| table(task, (title, name), cells);
            let unit = unit(&cells);
            let notes = self.about.notes.iter().cloned();
            let notes = notes.chain([document::counts(), document::intervals(unit)]);
            let first = of("Accuracy of answers", "accuracy", &cells);
            blocks.push(Block::Table(
                first.with_notes(notes.chain(dangerous(&cells))),
            ));
            blocks.extend(prevalence::table(task, &self.prevalence, &self.rules).map(Block::Table));
            blocks.extend(rule_table(task, &self.rules).map(Block::Table));
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
            let notes = [document::naming(), document::intervals(unit)];
            let named = of(title, "agreement", &cells).with_notes(notes);
            blocks.push(Block::Table(named));
            let fit = of("Calibration of probabilities", "calibration", &cells);
            blocks.push(Block::Table(fit.with_notes([document::calibration()])));
            if cells.iter().any(|cell| cell.token_calibration.n > 0) {
                let fit = of(
                    "Calibration of log probabilities",
                    "log-probabilities",
                    &cells,
                );
                blocks.push(Block::Table(
                    fit.with_notes([document::token_calibration()]),
                ));
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
                document::samples(),
            ));
            blocks.extend(some(
                "Claims about obstacles in the answers",
                "claims",
                |cell| cell.claims.answers + cell.claims.unchecked > 0,
                document::claims(unit),
            ));
            blocks.extend(some(
                "Time, tokens and cost",
                "cost",
                |cell| cell.consumption.is_known(),
                document::consumption(),
            ));
            blocks.extend(self.pairs(task).map(Block::Table));
        }
        if !self.tables.is_empty() {
            blocks.push(Block::Heading("Tables of the experiment".into()));
            let tables = self.tables.iter().flat_map(Pivot::tables);
            blocks.extend(tables.map(Block::Table));
        }
        blocks.extend(self.varied.blocks());
        blocks.extend(leak_table(&self.leaks).map(Block::Table));
        blocks.retain(|block| !matches!(block, Block::Figures(_, all) if all.is_empty()));
        blocks.push(Block::Heading("Method".into()));
        blocks.extend(document::all(self.unit()).map(Block::Text));
        if let Some(provenance) = &self.about.provenance {
            blocks.push(Block::Heading("Provenance".into()));
            blocks.push(Block::Text(provenance.summary()));
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
        let mut rows = record_rows(pairs.iter().copied());
        for (row, pair) in rows.iter_mut().zip(&pairs) {
            row.splice(
                0..0,
                [&pair.first, &pair.second]
                    .map(|configuration| names::configuration_name(configuration).into()),
            );
        }
        let caption = format!(
            "Comparisons on the same {}s, {} task",
            self.unit(),
            task.name()
        );
        let name = format!("nearmiss-{}-pairs", task.name());
        let table = CaptionedTable::new(caption, name, &columns, &rows);
        table.with_notes([document::pairs(self.unit())]).filled()
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
pub(crate) fn record_rows<'r, R: Record + 'r>(
    records: impl IntoIterator<Item = &'r R>,
) -> Vec<Row> {
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
        &record_rows(cells.iter().copied()),
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

/// The table; `None` where nothing is known of the questions.
pub(super) fn leak_table(leaks: &[Leak]) -> Option<CaptionedTable> {
    let caption = "What the questions give away: how well each part of their surface alone tells dangerous from safe windows";
    let columns = columns::<Leak>();
    let table = CaptionedTable::new(caption, "nearmiss-leaks", &columns, &record_rows(leaks));
    table.with_notes([leak_methods()]).filled()
}

/// What the numbers are.
pub(super) fn leak_methods() -> String {
    let surface = SURFACE.map(|(name, words)| format!("{name}: {words}"));
    format!(
        "Windows: each dangerous one is matched to a safe one by {MATCHED_ON}, of all recordings and times at once so that the \
         sum of squared differences is least; nothing is touched in a safe window, within the horizon after it and for {CLEAR} s \
         more. Leaks are areas under the ROC curve, 0.5 where a value says nothing about the answer ({}); the last one is of a \
         logistic regression on all of them, on scenarios that it was not fitted to.",
        surface.join("; ")
    )
}

/// What a trivial rule comes to, as tables and documents have it.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct RuleRow {
    /// The task.
    pub task: &'static str,
    /// What the rule says yes to.
    #[schemars(title = "Rule")]
    pub rule: String,
    /// Whether its threshold is the best one of the dev part.
    pub fitted_on_dev: bool,
    /// Questions.
    #[schemars(title = "n")]
    pub n: u32,
    /// The share that it is right about.
    #[schemars(title = "Right of all", extend("decimals" = 2))]
    pub right_of_all: Option<f64>,
    /// Its answers beside the truth.
    #[serde(flatten)]
    pub counts: Confusion,
    /// tp / (tp + fp).
    #[schemars(title = "Precision", extend("decimals" = 2))]
    pub precision: Option<f64>,
    /// tp / (tp + fn).
    #[schemars(title = "Recall", extend("decimals" = 2))]
    pub recall: Option<f64>,
    /// Harmonic mean of precision and recall.
    #[schemars(title = "F1", extend("decimals" = 2))]
    pub f1: Option<f64>,
}

impl Record for RuleRow {
    const NAME: &'static str = "rule";
    const TITLE: &'static str = "What a trivial rule comes to";
}

impl From<&RuleScore> for RuleRow {
    fn from(score: &RuleScore) -> Self {
        let c = &score.counts;
        Self {
            task: score.task.name(),
            rule: score.rule.to_string(),
            fitted_on_dev: score.is_fitted,
            n: c.answered(),
            right_of_all: c.accuracy(),
            counts: *c,
            precision: c.precision(),
            recall: c.recall(),
            f1: c.f1(),
        }
    }
}

/// The table of a task; `None` where nothing is known of the questions.
pub(super) fn rule_table(task: Task, rules: &[RuleScore]) -> Option<CaptionedTable> {
    let of_task = rules.iter().filter(|score| score.task == task);
    let rows: Vec<RuleRow> = of_task.map(RuleRow::from).collect();
    let caption = format!("Trivial rules on the same questions, {} task", task.name());
    let name = format!("nearmiss-{}-rules", task.name());
    let columns = columns_of_task::<RuleRow>("accuracy");
    let table = CaptionedTable::new(caption, name, &columns, &record_rows(&rows));
    table.with_notes([rule_methods(rules)]).filled()
}

/// What the rules are.
fn rule_methods(rules: &[RuleScore]) -> String {
    let chosen = if rules.iter().any(|rule| rule.is_fitted) {
        "the best ones of the dev part"
    } else {
        "the usual ones, as the batch has no split"
    };
    format!(
        "Rules see the measures of the window and no model: a distance of 0.00 is written in the ego and metrics frames where \
         bodies touch, so the collision task can be solved there by looking for it; TTC at the end of the window; the nearest \
         obstacle at any of its steps. Thresholds are {chosen}. A model that is no better than these reads a table."
    )
}

/// From this share without a verdict on, a report begins with it.
const MANY: f64 = 0.05;

impl Report {
    /// What is said before every table.
    pub(super) fn warnings(&self) -> impl Iterator<Item = String> + use<> {
        self.unanswered().into_iter().chain(self.doubtful())
    }

    /// The same of answers that have no report.
    pub(super) fn answer_warnings<'a>(
        scored: impl IntoIterator<Item = &'a Scored>,
    ) -> impl Iterator<Item = String> {
        let cells = configurations(scored)
            .into_iter()
            .map(|(configuration, of_way)| Cell::count(configuration, DataHalf::All, &of_way));
        let report = Self {
            cells: cells.collect(),
            ..Self::default()
        };
        report.warnings()
    }

    /// Whose verdicts contradict themselves, or name obstacles twice or that are not there.
    fn doubtful(&self) -> Option<String> {
        let who = self.full_cells().filter_map(|cell| {
            let flagged = cell.flagged;
            let counts = [
                (flagged.contradictory, "contradictory"),
                (
                    flagged.unknown,
                    "with an obstacle that the scene does not have",
                ),
                (flagged.twice, "with an obstacle named twice"),
            ]
            .into_iter()
            .filter(|(count, _)| *count > 0);
            let counts: Vec<String> = counts.map(|(n, what)| format!("{n} {what}")).collect();
            let of = cell.confusion.answered() + cell.unlabelled;
            let configuration = names::configuration_name(&cell.configuration);
            (!counts.is_empty()).then(|| format!("{configuration}, of {of}: {}", counts.join(", ")))
        });
        let who: Vec<String> = who.collect();
        (!who.is_empty()).then(|| {
            format!(
                "Doubtful verdicts, which count as they say: {}.",
                who.join("; ")
            )
        })
    }

    /// Who left out much, which notes begin with.
    fn unanswered(&self) -> Option<String> {
        let many = |cell: &&Cell| cell.without_verdict().is_some_and(|share| share >= MANY);
        let who = self.full_cells().filter(many).map(|cell| {
            let without = cell.asked - cell.confusion.answered();
            let share = 100.0 * f64::from(without) / f64::from(cell.asked);
            let configuration = names::configuration_name(&cell.configuration);
            format!(
                "{configuration}: {without} of {} ({share:.0} %)",
                cell.asked
            )
        });
        let who: Vec<String> = who.collect();
        (!who.is_empty()).then(|| {
            format!(
                "Without a verdict, unparsed or failed: {}. That counts as not right; precision, recall, specificity, accuracy and F1 \
                 are of the verdicts alone and flatter who leaves out what is hard.",
                who.join("; ")
            )
        })
    }
}

pub(super) fn bars(task: Task, cells: &[&Cell]) -> Figure {
    let bar = |cell: &&Cell| charts::Bar {
        name: names::configuration_name(&cell.configuration),
        value: cell.right_of_all,
        interval: cell.right_of_all_ci,
        other: cell.configuration.model == judge::MODEL,
    };
    let title = format!(
        "Right of all asked with intervals of 95 %, {} task",
        task.name()
    );
    Figure {
        svg: charts::bars(&title, &cells.iter().map(bar).collect::<Vec<_>>()),
        caption: String::new(),
    }
}

pub(super) fn matrices(cells: &[&Cell]) -> Vec<Figure> {
    let figure = |cell: &&Cell| {
        let aside = match cell.unparsed + cell.failed + cell.unasked {
            0 => String::new(),
            aside => format!("; {aside} without a verdict"),
        };
        let caption = format!("{}{aside}", names::configuration_name(&cell.configuration));
        Figure {
            svg: charts::confusion(
                &format!("Truth in rows, verdict in columns: {caption}"),
                &cell.confusion,
            ),
            caption,
        }
    };
    cells.iter().map(figure).collect()
}

pub(super) fn calibrations(cells: &[&Cell]) -> Vec<Figure> {
    let scored = cells.iter().filter(|c| c.calibration.fit.n > 0);
    let figure = |cell: &&Cell| {
        let caption = names::configuration_name(&cell.configuration);
        Figure {
            svg: charts::calibration(
                &format!("Share of true collisions by probability: {caption}"),
                &cell.calibration.fit.bins,
            ),
            caption,
        }
    };
    scored.map(figure).collect()
}

/// The reports of the parts that may be shown.
#[derive(Debug, Clone, PartialEq)]
pub struct SplitReport {
    /// The dev part, then the test part where it is not locked.
    pub parts: Vec<(SplitPart, Report)>,
    /// How far both parts are.
    pub progress: Vec<PartProgress>,
    /// What is to be said of the test part: how far it is, and looks before it was complete.
    pub notes: Vec<String>,
    /// The answers that may be shown, to read in.
    pub answers: AnswerPage,
    /// What all parts that are shown were made from.
    pub provenance: Option<Provenance>,
}

/// How far a part of a split is, for programs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
pub struct PartProgress {
    /// The part, dev or test.
    pub split: &'static str,
    /// Its questions.
    pub questions: u64,
    /// Those with an answer.
    pub answered: u64,
    /// Whether nothing but this may be shown.
    pub locked: bool,
    /// Looks at its figures before it was complete.
    pub looks: usize,
}

impl SplitReport {
    /// For programs: the lists of [`Report::json`], each row with its part, and how far the parts are.
    #[must_use]
    pub fn json(&self) -> ReportDocument {
        let mut document = ReportDocument::of_parts(&self.parts);
        document.about.provenance.clone_from(&self.provenance);
        document.splits.clone_from(&self.progress);
        document
    }

    /// The cells, one row each.
    #[must_use]
    pub fn rows(&self) -> FlatRows {
        let parts = self.parts.iter();
        let parts = parts.map(|(_, report)| (&report.about, report.cells.clone()));
        FlatRows::new(&parts.collect::<Vec<_>>())
    }

    /// The comparisons of ways within each part, one row each.
    #[must_use]
    pub fn pair_rows(&self) -> FlatRows {
        let parts = self.parts.iter();
        let parts = parts.map(|(_, report)| (&report.about, report.pairs.clone()));
        FlatRows::new(&parts.collect::<Vec<_>>())
    }

    /// The report for people, under a title.
    #[must_use]
    pub fn document(&self, title: &str) -> Document {
        let mut blocks: Vec<Block> = self.notes.iter().cloned().map(Block::Text).collect();
        let last = self.parts.len().saturating_sub(1);
        for (place, (part, report)) in self.parts.iter().enumerate() {
            let name = part.name();
            blocks.push(Block::Heading(format!("The {name} split")));
            let mut of_part = report.document("").blocks;
            if place < last {
                // The method is the same for both.
                let is_method = |block: &Block| *block == Block::Heading("Method".into());
                of_part.truncate(of_part.iter().position(is_method).unwrap_or(of_part.len()));
            }
            for block in &mut of_part {
                if let Block::Table(table) = block {
                    table.caption.push_str(&format!(", {name} split"));
                    table.name.push_str(&format!("-{name}"));
                }
            }
            blocks.extend(of_part);
        }
        let of_batch = self
            .parts
            .first()
            .and_then(|(_, report)| report.about.title.clone());
        Document {
            title: of_batch.unwrap_or_else(|| title.into()),
            blocks,
        }
    }
}
