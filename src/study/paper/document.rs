//! The paper's tables beside the recorded answers, for people and programs.

use serde_json::{Value, json};

use super::tables::{Comparison, Finding, Paper, Part, Published};
use crate::evaluation::Confusion;
use crate::evaluation::report::{
    Block, Cell, DataHalf, Document, NONE, Table, counts, csv, number, p_value, way, with_interval,
};
use crate::evaluation::statistics::Interval;

impl Paper {
    /// The comparison, then the report of the recorded answers; its notes say first what was read.
    #[must_use]
    pub fn document(&self) -> Document {
        let notes = &self.report.about.notes;
        let mut blocks: Vec<Block> = notes.iter().cloned().map(Block::Text).collect();
        blocks.extend(self.words().map(Block::Text));
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

    /// The comparisons as CSV, one line each.
    ///
    /// # Errors
    /// Never in practice: the writer's own words.
    pub fn csv(&self) -> Result<String, String> {
        csv(&self.rows())
    }

    /// The lines of [`Paper::csv`] as objects.
    #[must_use]
    pub fn rows(&self) -> Vec<Value> {
        self.comparisons.iter().map(Comparison::json).collect()
    }

    /// The cells of the recorded answers, and the comparisons.
    #[must_use]
    pub fn json(&self) -> Value {
        let mut report = self.report.json();
        report["comparisons"] = self.comparisons.iter().map(Comparison::json).collect();
        report
    }

    fn words(&self) -> impl Iterator<Item = String> {
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

    fn table(&self, name: &str) -> Table {
        let rows: Vec<&Comparison> = self
            .comparisons
            .iter()
            .filter(|c| c.published.table == name)
            .collect();
        let task = rows.first().map_or("", |c| c.published.way.task.name());
        let mut table = Table::new(
            format!(
                "Table {name} of the paper, {task} task, with the recorded answers and the built-in judge: TP/FP/FN/TN"
            ),
            format!("nearmiss-paper-{}", name.to_lowercase()),
            &[
                "<Prompt",
                "<Method",
                "<Model",
                "Published",
                "F1",
                "Recorded",
                "Unparsed",
                "F1 recorded",
                "Judge",
                "F1 judge",
                "<Collisions found",
                "<False alarms",
            ],
        );
        table.notes = self.words().collect();
        for c in rows {
            let (row, recorded) = (&c.published, c.recorded.as_ref());
            let prompt = row
                .way
                .frame
                .map_or(NONE, |f| if f.name() == "ego" { "Ego" } else { "Cart" });
            table.rows.push(vec![
                prompt.into(),
                row.method.clone(),
                row.model.clone(),
                four(Some(&row.counts)),
                number(Some(row.rates[2]), 2),
                four(recorded.map(|r| &r.confusion)),
                recorded.map_or_else(|| NONE.into(), |r| r.unparsed.to_string()),
                with_interval(
                    recorded.and_then(Cell::f1),
                    recorded.and_then(|r| r.intervals.f1),
                ),
                four(c.reference.as_ref().map(|r| &r.confusion)),
                number(c.reference.as_ref().and_then(Cell::f1), 2),
                c.parts[0].finding.name().into(),
                c.parts[1].finding.name().into(),
            ]);
        }
        table
    }

    fn departures(&self) -> Option<Table> {
        let mut table = Table::new(
            "Published and recorded shares that differ, with 95 % Wilson intervals",
            "nearmiss-paper-departures",
            &[
                "<Table",
                "<Row",
                "<Share",
                "Published",
                "Recorded",
                "p",
                "<Finding",
            ],
        );
        table.notes = self.words().collect();
        for c in self.comparisons.iter().filter(|c| c.repeats.is_none()) {
            let same = |one: &&Comparison| {
                one.repeats.as_ref() == Some(&c.published.table)
                    && one.published.way == c.published.way
            };
            let others = self.comparisons.iter().filter(same);
            let tables: Vec<&str> = std::iter::once(c)
                .chain(others)
                .map(|one| one.published.table.as_str())
                .collect();
            for part in c.parts.iter().filter(|p| p.finding != Finding::Agrees) {
                let of = |(hits, all), (share, interval)| {
                    format!("{hits}/{all} = {}", with_interval(share, interval))
                };
                let what = if part.collision {
                    "collisions found"
                } else {
                    "false alarms"
                };
                table.rows.push(vec![
                    tables.join(", "),
                    name(&c.published),
                    what.into(),
                    of(part.published, part.published_share()),
                    match part.recorded.1 {
                        0 => NONE.into(),
                        _ => of(part.recorded, part.recorded_share()),
                    },
                    part.p.map_or_else(|| NONE.into(), p_value),
                    part.finding.name().into(),
                ]);
            }
        }
        (!table.rows.is_empty()).then_some(table)
    }

    fn contradictions(&self) -> Option<Table> {
        let mut table = Table::new(
            "Published rates that do not match the published counts",
            "nearmiss-paper-contradictions",
            &["<Table", "<Row", "<What"],
        );
        for row in self.comparisons.iter().map(|c| &c.published) {
            for words in row.contradictions() {
                table.rows.push(vec![row.table.clone(), name(row), words]);
            }
        }
        (!table.rows.is_empty()).then_some(table)
    }
}

/// A row in short: `ego All Gemini-1.5Pro`.
fn name(row: &Published) -> String {
    let frame = row.way.frame.map_or(NONE, |f| f.name());
    format!("{frame} {} {}", row.method, row.model)
}

fn four(c: Option<&Confusion>) -> String {
    c.map_or_else(
        || NONE.into(),
        |c| {
            format!(
                "{}/{}/{}/{}",
                c.true_positives, c.false_positives, c.false_negatives, c.true_negatives
            )
        },
    )
}

impl Comparison {
    /// One object.
    #[must_use]
    pub fn json(&self) -> Value {
        let row = &self.published;
        let mut map = way(&row.way);
        let cell = |cell: &Cell| {
            let mut map = counts(&cell.confusion);
            map.insert("unparsed".into(), json!(cell.unparsed));
            map.insert("precision".into(), json!(cell.precision()));
            map.insert("recall".into(), json!(cell.confusion.recall()));
            map.insert("f1".into(), json!(cell.f1()));
            map.insert(
                "f1_ci".into(),
                json!(cell.intervals.f1.map(|i| [i.low, i.high])),
            );
            map
        };
        let mut printed = counts(&row.counts);
        for (name, rate) in ["precision", "recall", "f1"].into_iter().zip(row.rates) {
            printed.insert(name.into(), json!(rate));
        }
        let part = |part: &Part| {
            let ends = |(_, i): (Option<f64>, Option<Interval>)| i.map(|i| [i.low, i.high]);
            json!({
                "published": part.published_share().0,
                "published_ci": ends(part.published_share()),
                "recorded": part.recorded_share().0,
                "recorded_ci": ends(part.recorded_share()),
                "p": part.p,
                "finding": part.finding.name(),
            })
        };
        let rest = json!({
            "table": row.table,
            "method": row.method,
            "repeats": self.repeats,
            "published": printed,
            "contradictions": row.contradictions(),
            "recorded": self.recorded.as_ref().map(cell),
            "reference": self.reference.as_ref().map(cell),
            "collisions_found": part(&self.parts[0]),
            "false_alarms": part(&self.parts[1]),
        });
        if let Value::Object(rest) = rest {
            map.extend(rest);
        }
        Value::Object(map)
    }
}
