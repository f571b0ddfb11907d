//! Tables below that of a batch: invariance to changed scenes, and how early a collision is detected.

use serde_json::Value;

use super::share;
use super::table::{WAY, way_cells, way_columns};
use crate::output;
use crate::output::Align::{Left, Right};
use nearmiss_study::evaluation::Share;
use nearmiss_study::evaluation::batch::Answers;
use nearmiss_study::evaluation::report;
use nearmiss_study::evaluation::statistics::Interval;

/// Titles of the columns behind [`WAY`].
const CHANGED: [&str; 8] = [
    "change",
    "n",
    "flips",
    "rate",
    "95 %",
    "renamed",
    "none",
    "same words",
];

/// Titles of the columns behind [`WAY`].
const LEADS: [&str; 12] = [
    "lead",
    "n",
    "said yes",
    "rate",
    "95 %",
    "named",
    "rate",
    "95 %",
    "false alarms",
    "unparsed",
    "failed",
    "not asked",
];

/// Results of a batch with changed scenes or several leads, beside its table.
pub struct Varied(report::Varied);

impl Varied {
    /// Counts the answers of a batch.
    pub fn from_answers(answers: &Answers) -> Self {
        Self(report::Varied::from_answers(answers))
    }

    /// Adds its tables to the document of the batch.
    pub fn add_to(&self, document: &mut Value) {
        for (name, rows) in self.0.fields() {
            document[name] = rows;
        }
    }

    /// For people; nothing where there is nothing of the kind.
    pub fn tables(&self) -> String {
        let ways = self
            .0
            .invariance
            .iter()
            .map(|row| &row.way)
            .chain(self.0.leads.iter().map(|(_, way, _)| way));
        let names = ways.map(report::model_name);
        let width = names
            .map(|name| name.chars().count())
            .max()
            .unwrap_or(0)
            .max("model".len());
        let mut text = String::new();
        if !self.0.invariance.is_empty() {
            text += "\ntransformed scenes, whose answer should stay the same; flips: the verdict changed\n";
            let widths = [5, 5, 6, 13, 7, 6, 10].map(Right);
            let columns = [&way_columns(width)[..], &[Left(20)], &widths].concat();
            text += &output::line(" ", &columns, &[&WAY[..], &CHANGED].concat());
            for row in &self.0.invariance {
                let flipped = &row.flipped;
                let figures = [
                    row.transform.to_string(),
                    flipped.of.to_string(),
                    flipped.hits.to_string(),
                    share(flipped.value()),
                    if flipped.of == 0 && row.same_words > 0 {
                        "same words".into()
                    } else {
                        interval(flipped)
                    },
                    row.renamed.hits.to_string(),
                    row.without_verdict.to_string(),
                    row.same_words.to_string(),
                ];
                text += &output::line(
                    " ",
                    &columns,
                    &[&way_cells(&row.way)[..], &figures].concat(),
                );
            }
        }
        if self.0.invariance.iter().any(|row| row.same_words > 0) {
            text.push_str(report::SAME_WORDS);
            text.push('\n');
        }
        if !self.0.leads.is_empty() {
            text += "\ncollisions, by seconds from the end of the window to the collision\n";
            let widths = [6, 5, 8, 6, 13, 9, 6, 13, 12, 8, 6, 9].map(Right);
            let columns = [&way_columns(width)[..], &widths].concat();
            text += &output::line(" ", &columns, &[&WAY[..], &LEADS].concat());
            for (lead, way, point) in &self.0.leads {
                let figures = [
                    lead.to_string(),
                    point.yes.of.to_string(),
                    point.yes.hits.to_string(),
                    share(point.yes.value()),
                    interval(&point.yes),
                    of(&point.named),
                    share(point.named.value()),
                    interval(&point.named),
                    of(&point.false_alarms),
                    point.unparsed.to_string(),
                    point.failed.to_string(),
                    point.unasked.to_string(),
                ];
                text += &output::line(" ", &columns, &[&way_cells(way)[..], &figures].concat());
            }
        }
        if !self.0.leads.is_empty() {
            text.push_str(&self.0.about_leads().join("\n"));
            text.push('\n');
        }
        output::visible(&text)
    }
}

fn of(share: &Share) -> String {
    match share.of {
        0 => "–".into(),
        all => format!("{} of {all}", share.hits),
    }
}

fn interval(of: &Share) -> String {
    let words = |Interval { low, high }| format!("{low:.3}–{high:.3}");
    of.interval.map_or_else(|| "–".into(), words)
}
