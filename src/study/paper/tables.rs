//! Recorded answers compared with the paper's printed numbers and the built-in judge.

use serde::Deserialize;

use crate::evaluation::report::{Cell, Finding, Report, ReportSubject};
use crate::evaluation::statistics::{Interval, fisher_p_value, wilson};
use crate::evaluation::{AxisValues, Confusion, PromptConfig, Scored};
use nearmiss_ask::prompts::Techniques;
use nearmiss_scene::description::Frame;
use nearmiss_scene::judge;
use nearmiss_scene::verdict::Task;

/// A row of one of the paper's tables, as printed.
#[derive(Debug, Clone, PartialEq)]
pub struct Published {
    /// `I` to `IV`.
    pub table: String,
    /// The prompt configuration, with the model as recorded answers name it.
    pub configuration: PromptConfig,
    /// The paper's word for the techniques.
    pub method: String,
    /// The paper's word for the model.
    pub model: String,
    /// The four counts.
    pub counts: Confusion,
    /// Precision, recall and F1, rounded to two decimals.
    pub rates: [f64; 3],
}

/// One half of a row: detected collisions, or normal scenarios mistaken for one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Part {
    /// Whether it is the half of the collisions.
    pub collision: bool,
    /// Said yes, and all, as printed.
    pub published: (u32, u32),
    /// Said yes, and all, of the recorded answers.
    pub recorded: (u32, u32),
    /// The two-sided p value of the recorded ones being a random part of the published ones.
    pub p: Option<f64>,
    /// The conclusion.
    pub finding: Finding,
}

/// A row of the paper beside what was recorded.
#[derive(Debug, Clone, PartialEq)]
pub struct Comparison {
    /// The row.
    pub published: Published,
    /// The recorded answers; `None` if there are none.
    pub recorded: Option<Cell>,
    /// The built-in judge on the scenarios of the recorded answers of any way.
    pub reference: Option<Cell>,
    /// Both halves.
    pub parts: [Part; 2],
    /// The table in which the same row stands before: its counts are published once.
    pub repeats: Option<String>,
}

/// The paper's tables beside the recorded answers.
#[derive(Debug, Clone, PartialEq)]
pub struct Paper {
    /// The report of the recorded answers.
    pub report: Report,
    /// Row by row.
    pub comparisons: Vec<Comparison>,
}

/// Lowest p value at which a recorded count is said to agree.
const LEVEL: f64 = 0.05;

#[derive(Deserialize)]
struct File {
    row: Vec<Row>,
}

#[derive(Deserialize)]
struct Row {
    table: String,
    task: String,
    frame: String,
    method: String,
    techniques: String,
    model: String,
    printed_model: String,
    tp: u32,
    fp: u32,
    #[serde(rename = "fn")]
    missed: u32,
    tn: u32,
    precision: f64,
    recall: f64,
    f1: f64,
}

/// The rows of Tables I to IV of "From Words to Collisions".
///
/// # Errors
/// The file in the program is not as it should be; a test sees to that.
pub fn published() -> Result<Vec<Published>, String> {
    let file: File = toml::from_str(include_str!("tables.toml")).map_err(|e| e.to_string())?;
    let row = |row: Row| {
        let word = |what: &str| format!("{what} of a row of table {}", row.table);
        Ok(Published {
            configuration: PromptConfig {
                task: Task::parse(&row.task).ok_or_else(|| word("the task"))?,
                frame: Some(Frame::parse(&row.frame).ok_or_else(|| word("the frame"))?),
                techniques: Some(Techniques::parse(&row.techniques)?),
                model: row.model,
                settings: AxisValues::default(),
                template: None,
            },
            table: row.table,
            method: row.method,
            model: row.printed_model,
            counts: Confusion {
                true_positives: row.tp,
                false_positives: row.fp,
                false_negatives: row.missed,
                true_negatives: row.tn,
            },
            rates: [row.precision, row.recall, row.f1],
        })
    };
    file.row.into_iter().map(row).collect()
}

impl Published {
    /// Describes where the printed precision, recall and F1 do not follow from the printed counts.
    #[must_use]
    pub fn contradictions(&self) -> Vec<String> {
        let c = &self.counts;
        let rates = [c.precision(), c.recall(), c.f1()];
        let names = ["precision", "recall", "F1"];
        let compared = names.into_iter().zip(rates).zip(self.rates);
        compared
            .filter_map(|((name, counted), printed)| {
                // Half a unit of the last digit that is printed.
                let off = counted.is_none_or(|counted| (counted - printed).abs() > 0.005 + 1e-9);
                let counted = counted.map_or_else(|| "none".into(), |c| format!("{c:.3}"));
                off.then(|| {
                    format!("{name} is printed as {printed:.2}, but its counts give {counted}")
                })
            })
            .collect()
    }
}

impl Paper {
    /// Compares recorded answers, as [`super::scored`] gives them, with the paper.
    ///
    /// # Errors
    /// As [`published`].
    pub fn from_scored(scored: &[Scored]) -> Result<Self, String> {
        let report = Report::from_scored(scored);
        let mut counted = scored.to_vec();
        counted.iter_mut().for_each(Scored::require_naming);
        let counted = Report::from_scored(&counted);
        let find = |wanted: &dyn Fn(&PromptConfig) -> bool| {
            counted
                .full_cells()
                .find(|c| wanted(&c.configuration))
                .cloned()
        };
        let compare = |row: Published| {
            let recorded = find(&|configuration| *configuration == row.configuration);
            let judge = |configuration: &PromptConfig| {
                configuration.task == row.configuration.task && configuration.model == judge::MODEL
            };
            let counts = recorded.as_ref().map(|cell| cell.confusion);
            Comparison {
                parts: [true, false].map(|half| Part::new(half, &row.counts, counts.as_ref())),
                repeats: None,
                reference: find(&judge),
                recorded,
                published: row,
            }
        };
        let mut comparisons: Vec<Comparison> = Vec::new();
        for row in published()? {
            let same = |one: &&Comparison| {
                one.published.configuration == row.configuration
                    && one.published.counts == row.counts
            };
            let before = comparisons.iter().find(same);
            let repeats = before.map(|one| one.published.table.clone());
            comparisons.push(Comparison {
                repeats,
                ..compare(row)
            });
        }
        Ok(Self {
            report,
            comparisons,
        })
    }
}

impl Paper {
    /// The same, saying what the recorded answers are.
    #[must_use]
    pub fn about(self, about: ReportSubject) -> Self {
        Self {
            report: self.report.about(about),
            ..self
        }
    }
}

impl Part {
    fn new(collision: bool, published: &Confusion, recorded: Option<&Confusion>) -> Self {
        let half = |c: &Confusion| {
            if collision {
                (c.true_positives, c.positives())
            } else {
                (c.false_positives, c.negatives())
            }
        };
        let (published, recorded) = (half(published), recorded.map_or((0, 0), half));
        let p = match recorded.1 {
            0 => None,
            n => fisher_p_value(recorded.0, n, published.0, published.1),
        };
        let finding = match p {
            None => Finding::Missing,
            Some(p) if p <= 0.0 => Finding::Impossible,
            Some(p) if p < LEVEL => Finding::Differs,
            Some(_) => Finding::Agrees,
        };
        Self {
            collision,
            published,
            recorded,
            p,
            finding,
        }
    }

    /// The published share of yes, and its Wilson interval.
    #[must_use]
    pub fn published_share(&self) -> (Option<f64>, Option<Interval>) {
        share(self.published)
    }

    /// The recorded share of yes, and its Wilson interval.
    #[must_use]
    pub fn recorded_share(&self) -> (Option<f64>, Option<Interval>) {
        share(self.recorded)
    }
}

fn share((hits, all): (u32, u32)) -> (Option<f64>, Option<Interval>) {
    let share = (all > 0).then(|| f64::from(hits) / f64::from(all));
    (share, wilson(hits, all))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::evaluation::Label;
    use crate::evaluation::tests_scored::answer;

    #[test]
    fn a_row_that_stands_in_two_tables_is_counted_once() {
        // An answer that no published count of its row can hold: nothing was taken for a collision there.
        let alarm = Scored {
            configuration: PromptConfig {
                task: Task::Collision,
                frame: Some(Frame::Cartesian),
                techniques: Some(Techniques::ALL),
                model: "recorded/gemini-1.5-pro".into(),
                settings: AxisValues::default(),
                template: None,
            },
            truth: Some(Label::Safe),
            ..answer("c", "", true, &[])
        };
        let paper = Paper::from_scored(&[alarm]).unwrap();
        let repeats: Vec<_> = paper
            .comparisons
            .iter()
            .filter_map(|c| {
                c.repeats
                    .as_deref()
                    .map(|of| (c.published.table.as_str(), of))
            })
            .collect();
        assert_eq!(
            repeats,
            [("II", "I"), ("II", "I"), ("IV", "III"), ("IV", "III")]
        );
        let text = paper.document().markdown();
        let said = "Of 48 published counts 0 agree, 0 differ, 1 are impossible, and 47 have no recorded answers";
        assert!(text.contains(said), "{text}");
        assert!(
            text.contains("cartesian All Gemini-1.5Pro in II as in I"),
            "{text}"
        );
        let rows = text
            .lines()
            .filter(|line| line.contains("impossible") && line.starts_with("| I, II "));
        assert_eq!(rows.count(), 1, "{text}");
    }

    #[test]
    fn what_is_printed_is_checked_against_its_counts() {
        let rows = published().unwrap();
        let tables = |name: &str| rows.iter().filter(|r| r.table == name).count();
        assert_eq!(["I", "II", "III", "IV"].map(tables), [8, 6, 8, 6]);
        let wrong: Vec<_> = rows
            .iter()
            .filter(|r| !r.contradictions().is_empty())
            .collect();
        // 65 of 89 is 0.730 where 0.72 is printed, with an F1 of 0.688 where 0.68 is printed.
        assert!(
            wrong.iter().any(|r| r.table == "III" && r.method == "CP"),
            "{wrong:?}"
        );
        assert!(wrong.len() < 8, "{wrong:#?}");
    }
}
