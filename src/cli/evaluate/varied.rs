//! Tables below that of a batch: invariance to changed scenes, and how early a collision is detected.

use serde_json::Value;

use super::share;
use crate::cli::output;
use crate::evaluation::batch::Answers;
use crate::evaluation::report::{self, technique};
use crate::evaluation::{PromptConfig, Share};

/// Results of a batch with changed scenes or several leads, beside its table.
pub struct Varied(report::Varied);

impl Varied {
    /// Counts the answers of a batch.
    pub fn of(answers: &Answers) -> Self {
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
        let ways = self.0.invariance.iter().map(|row| &row.way);
        let ways = ways.chain(self.0.leads.iter().map(|(_, way, _)| way));
        let width = ways.map(|way| way.model.chars().count()).max();
        let width = width.unwrap_or(0).max("model".len());
        let mut text = String::new();
        if !self.0.invariance.is_empty() {
            text.push_str(&format!(
                "\nthe same scenes changed, which changes nothing about them; flips: yes became no, or no yes\n{} {:<20} {:>5} {:>5} {:>6} {:>13} {:>7} {:>6} {:>10}\n",
                heads(width), "change", "n", "flips", "rate", "95 %", "renamed", "none", "same words"
            ));
        }
        for row in &self.0.invariance {
            text.push_str(&format!(
                "{} {:<20} {:>5} {:>5} {:>6} {:>13} {:>7} {:>6} {:>10}\n",
                cells(&row.way, width),
                row.transform.to_string(),
                row.flipped.of,
                row.flipped.hits,
                share(row.flipped.value()),
                match row.flipped.of == 0 && row.same_words > 0 {
                    true => "same words".into(),
                    false => interval(&row.flipped),
                },
                row.renamed.hits,
                row.without_verdict,
                row.same_words,
            ));
        }
        if self.0.invariance.iter().any(|row| row.same_words > 0) {
            text.push_str(report::SAME_WORDS);
            text.push('\n');
        }
        if !self.0.leads.is_empty() {
            text.push_str(&format!(
                "\nscenarios that collide, by seconds from the end of the window to the collision\n{} {:>6} {:>5} {:>8} {:>6} {:>13} {:>9} {:>6} {:>13} {:>12} {:>8} {:>6} {:>9}\n",
                heads(width), "lead", "n", "said yes", "rate", "95 %", "named", "rate", "95 %", "false alarms", "unparsed", "failed", "not asked"
            ));
        }
        for (lead, way, point) in &self.0.leads {
            text.push_str(&format!(
                "{} {:>6} {:>5} {:>8} {:>6} {:>13} {:>9} {:>6} {:>13} {:>12} {:>8} {:>6} {:>9}\n",
                cells(way, width),
                lead.to_string(),
                point.yes.of,
                point.yes.hits,
                share(point.yes.value()),
                interval(&point.yes),
                of(&point.named),
                share(point.named.value()),
                interval(&point.named),
                of(&point.false_alarms),
                point.unparsed,
                point.failed,
                point.unasked,
            ));
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

fn heads(width: usize) -> String {
    format!(
        "{:<9} {:<9} {:<10} {:<width$}",
        "task", "frame", "techniques", "model"
    )
}

fn cells(way: &PromptConfig, width: usize) -> String {
    format!(
        "{:<9} {:<9} {:<10} {:<width$}",
        way.task.name(),
        way.frame.map_or("–", |frame| frame.name()),
        way.techniques.map_or_else(|| "–".into(), technique),
        way.model,
    )
}

fn interval(of: &Share) -> String {
    let words = |(low, high): (f64, f64)| format!("{low:.3}–{high:.3}");
    of.interval().map_or_else(|| "–".into(), words)
}
