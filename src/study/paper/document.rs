//! The paper's tables beside the recorded answers, for people and programs.

use schemars::JsonSchema;
use serde::Serialize;

use super::tables::{Comparison, Paper, Part, Published};
use crate::evaluation::Confusion;
use crate::evaluation::report::{
    Block, Cell, ComparisonRow, CountedCounts, DataHalf, Document, Finding, FlatRows, PartRow,
    PrintedCounts, ReportDocument, record_rows,
};
use crate::evaluation::statistics::Interval;
use nearmiss_record::{CaptionedTable, NONE, Record, columns, with_interval};
use nearmiss_scene::description::Frame;

impl Paper {
    /// The comparison, then the report of the recorded answers; its notes say first what was read.
    #[must_use]
    pub fn document(&self) -> Document {
        let notes = &self.report.about.notes;
        let mut blocks: Vec<Block> = notes.iter().cloned().map(Block::Text).collect();
        blocks.extend(self.paragraphs().map(Block::Text));
        for table in ["I", "II", "III", "IV"] {
            blocks.push(Block::Table(self.table(table)));
        }
        blocks.push(Block::Heading(
            "Published numbers that the recorded answers do not reproduce".into(),
        ));
        blocks.push(self.departures().map_or_else(
            || {
                Block::Text(
                    "Every recorded count is consistent with a random part of the published one."
                        .into(),
                )
            },
            Block::Table,
        ));
        blocks.extend(self.contradictions().map(Block::Table));
        blocks.extend(self.report.blocks());
        Document {
            title: "Recorded answers compared with Tables I–IV of \"From Words to Collisions\""
                .into(),
            blocks,
        }
    }

    /// The comparisons, one row each.
    #[must_use]
    pub fn rows(&self) -> FlatRows {
        FlatRows::new(&[(&self.report.about, self.comparison_rows())])
    }

    /// The cells of the recorded answers, and the comparisons.
    #[must_use]
    pub fn json(&self) -> ReportDocument {
        ReportDocument {
            comparisons: self.comparison_rows(),
            ..self.report.json()
        }
    }

    fn comparison_rows(&self) -> Vec<ComparisonRow> {
        self.comparisons.iter().map(ComparisonRow::from).collect()
    }

    fn paragraphs(&self) -> impl Iterator<Item = String> {
        let cells = |half| {
            self.report
                .cells
                .iter()
                .filter(move |c: &&Cell| c.half == half)
        };
        let most = |half| cells(half).map(|c| c.scenarios).max().unwrap_or(0);
        let once = self.comparisons.iter().filter(|c| c.repeats.is_none());
        let parts: Vec<&Part> = once.flat_map(|c| &c.parts).collect();
        let again = self.comparisons.iter().filter_map(|c| {
            let table = c.repeats.as_ref()?;
            let row = &c.published;
            Some(format!("{} in {} as in {table}", name(row), row.table))
        });
        let again: Vec<String> = again.collect();
        let again = if again.is_empty() {
            String::new()
        } else {
            format!(
                " Rows in two tables are counted once: {}.",
                again.join("; ")
            )
        };
        let count = |finding| parts.iter().filter(|p| p.finding == finding).count();
        [
            format!(
                "The paper's tables cover 100 collisions and 100 normal scenarios (104 for some models), the recorded answers here {} and {}. So shares are compared, not counts: if the recorded answers were a random part of those the paper counted, how probable is a count at least as unlikely as the recorded one? (Two-sided hypergeometric test, not corrected for multiple rows: one in twenty differs by chance.) Impossible: no part of the published answers has such a count. Which of these scenarios the paper counted is unknown. As in the paper, a yes of the safety task that does not name the obstacle that collides counts as a no here.",
                most(DataHalf::Collision),
                most(DataHalf::Normal)
            ),
            format!(
                "Of {} published counts {} agree, {} differ, {} are impossible, and {} have no recorded answers.{again}",
                parts.len(),
                count(Finding::Agrees),
                count(Finding::Differs),
                count(Finding::Impossible),
                count(Finding::Missing)
            ),
        ]
        .into_iter()
    }

    fn table(&self, name: &str) -> CaptionedTable {
        let of_table = { self.comparisons.iter() }.filter(|c| c.published.table == name);
        let task = of_table.clone().next();
        let task = task.map_or("", |c| c.published.configuration.task.name());
        let rows: Vec<PaperRow> = of_table.map(PaperRow::from).collect();
        let table = CaptionedTable::new(
            format!(
                "Table {name} of the paper, {task} task, with the recorded answers and the built-in judge: TP/FP/FN/TN"
            ),
            format!("nearmiss-paper-{}", name.to_lowercase()),
            &columns::<PaperRow>(),
            &record_rows(&rows),
        );
        table.with_notes(self.paragraphs())
    }

    fn departures(&self) -> Option<CaptionedTable> {
        let mut rows = Vec::new();
        for c in self.comparisons.iter().filter(|c| c.repeats.is_none()) {
            let same = |one: &&Comparison| {
                one.repeats.as_ref() == Some(&c.published.table)
                    && one.published.configuration == c.published.configuration
            };
            let others = self.comparisons.iter().filter(same);
            let tables: Vec<&str> = std::iter::once(c)
                .chain(others)
                .map(|one| one.published.table.as_str())
                .collect();
            for part in c.parts.iter().filter(|p| p.finding != Finding::Agrees) {
                let of = |(hits, all), (share, interval): (Option<f64>, Option<Interval>)| {
                    let share = with_interval(share, interval.map(Into::into));
                    format!("{hits}/{all} = {share}")
                };
                let recorded = part.recorded.1 > 0;
                rows.push(Departure {
                    table: tables.join(", "),
                    row: name(&c.published),
                    share: if part.collision {
                        "collisions found"
                    } else {
                        "false alarms"
                    },
                    published: of(part.published, part.published_share()),
                    recorded: recorded.then(|| of(part.recorded, part.recorded_share())),
                    p: part.p,
                    finding: part.finding,
                });
            }
        }
        let table = CaptionedTable::new(
            "Published and recorded shares that differ, with 95 % Wilson intervals",
            "nearmiss-paper-departures",
            &columns::<Departure>(),
            &record_rows(&rows),
        );
        table.with_notes(self.paragraphs()).filled()
    }

    fn contradictions(&self) -> Option<CaptionedTable> {
        let published = self.comparisons.iter().map(|c| &c.published);
        let rows = published.flat_map(|row| {
            let of_row = row.contradictions().into_iter();
            of_row.map(|what| Contradiction {
                table: row.table.clone(),
                row: name(row),
                what,
            })
        });
        let rows: Vec<Contradiction> = rows.collect();
        CaptionedTable::new(
            "Published rates that do not match the published counts",
            "nearmiss-paper-contradictions",
            &columns::<Contradiction>(),
            &record_rows(&rows),
        )
        .filled()
    }
}

/// A row of the paper beside the recorded answers, for people.
#[derive(Serialize, JsonSchema)]
struct PaperRow {
    #[schemars(title = "Prompt")]
    prompt: Option<&'static str>,
    #[schemars(title = "Method")]
    method: String,
    #[schemars(title = "Model")]
    model: String,
    #[schemars(title = "Published")]
    published: String,
    #[schemars(title = "F1", extend("decimals" = 2))]
    f1: f64,
    #[schemars(title = "Recorded")]
    recorded: Option<String>,
    #[schemars(title = "Unparsed")]
    unparsed: Option<u32>,
    #[schemars(title = "F1 recorded", extend("decimals" = 2))]
    recorded_f1: Option<f64>,
    recorded_f1_ci: Option<Interval>,
    #[schemars(title = "Judge")]
    judge: Option<String>,
    #[schemars(title = "F1 judge", extend("decimals" = 2))]
    judge_f1: Option<f64>,
    #[schemars(title = "Collisions found")]
    collisions_found: Finding,
    #[schemars(title = "False alarms")]
    false_alarms: Finding,
}

impl Record for PaperRow {
    const NAME: &'static str = "paper-row";
    const TITLE: &'static str = "A row of the paper beside the recorded answers";
}

impl From<&Comparison> for PaperRow {
    fn from(c: &Comparison) -> Self {
        let (row, recorded, judge) = (&c.published, c.recorded.as_ref(), c.reference.as_ref());
        let prompt = |frame: Frame| if frame.name() == "ego" { "Ego" } else { "Cart" };
        Self {
            prompt: row.configuration.frame.map(prompt),
            method: row.method.clone(),
            model: row.model.clone(),
            published: four(&row.counts),
            f1: row.rates[2],
            recorded: recorded.map(|r| four(&r.confusion)),
            unparsed: recorded.map(|r| r.unparsed),
            recorded_f1: recorded.and_then(|r| r.f1),
            recorded_f1_ci: recorded.and_then(|r| r.f1_ci),
            judge: judge.map(|r| four(&r.confusion)),
            judge_f1: judge.and_then(|r| r.f1),
            collisions_found: c.parts[0].finding,
            false_alarms: c.parts[1].finding,
        }
    }
}

/// A published share that the recorded answers do not reproduce.
#[derive(Serialize, JsonSchema)]
struct Departure {
    #[schemars(title = "Table")]
    table: String,
    #[schemars(title = "Row")]
    row: String,
    #[schemars(title = "Share")]
    share: &'static str,
    #[schemars(title = "Published")]
    published: String,
    #[schemars(title = "Recorded")]
    recorded: Option<String>,
    #[schemars(title = "p", extend("decimals" = 3, "bounded" = true))]
    p: Option<f64>,
    #[schemars(title = "Finding")]
    finding: Finding,
}

impl Record for Departure {
    const NAME: &'static str = "paper-departure";
    const TITLE: &'static str = "A published share that the recorded answers do not reproduce";
}

/// A published rate that does not match the published counts.
#[derive(Serialize, JsonSchema)]
struct Contradiction {
    #[schemars(title = "Table")]
    table: String,
    #[schemars(title = "Row")]
    row: String,
    #[schemars(title = "What")]
    what: String,
}

impl Record for Contradiction {
    const NAME: &'static str = "paper-contradiction";
    const TITLE: &'static str = "A published rate that does not match the published counts";
}

/// A row in short: `ego All Gemini-1.5Pro`.
fn name(row: &Published) -> String {
    let frame = row.configuration.frame.map_or(NONE, |f| f.name());
    format!("{frame} {} {}", row.method, row.model)
}

fn four(c: &Confusion) -> String {
    c.counts().map(|n| n.to_string()).join("/")
}

impl From<&Part> for PartRow {
    fn from(part: &Part) -> Self {
        let (published, published_ci) = part.published_share();
        let (recorded, recorded_ci) = part.recorded_share();
        Self {
            published,
            published_ci,
            recorded,
            recorded_ci,
            p: part.p,
            finding: part.finding,
        }
    }
}

impl From<&Cell> for CountedCounts {
    fn from(cell: &Cell) -> Self {
        Self {
            counts: cell.confusion,
            unparsed: cell.unparsed,
            precision: cell.precision,
            recall: cell.recall,
            f1: cell.f1,
            f1_ci: cell.f1_ci,
        }
    }
}

impl From<&Comparison> for ComparisonRow {
    fn from(one: &Comparison) -> Self {
        let row = &one.published;
        let [precision, recall, f1] = row.rates;
        Self {
            configuration: row.configuration.clone(),
            table: row.table.clone(),
            method: row.method.clone(),
            repeats: one.repeats.clone(),
            published: PrintedCounts {
                counts: row.counts,
                precision,
                recall,
                f1,
            },
            contradictions: row.contradictions(),
            recorded: one.recorded.as_ref().map(CountedCounts::from),
            reference: one.reference.as_ref().map(CountedCounts::from),
            collisions_found: (&one.parts[0]).into(),
            false_alarms: (&one.parts[1]).into(),
        }
    }
}
