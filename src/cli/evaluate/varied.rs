//! The tables beneath that of a batch: whether changed scenes change the answers, and how early a collision is seen.

use serde_json::{Value, json};

use super::share;
use crate::cli::output;
use crate::evaluation::batch::Answers;
use crate::evaluation::report::technique;
use crate::evaluation::{
    Invariance, Lead, LeadPoint, Share, Timed, Way, invariance, lead_curves, pairs,
};

/// What a batch with changed scenes or several leads tells beside its table.
pub struct Varied {
    invariance: Vec<Invariance>,
    leads: Vec<(Lead, Way, LeadPoint)>,
}

impl Varied {
    /// Counts the answers of a batch.
    pub fn of(answers: &Answers) -> Self {
        let mut paired = answers.plain.clone();
        paired.extend(answers.changed.iter().cloned());
        let mut order: Vec<Lead> = Vec::new();
        for (lead, _) in &answers.leads {
            if !order.contains(lead) {
                order.push(*lead);
            }
        }
        let mut leads = Vec::new();
        for lead in order {
            let of_lead = answers.leads.iter().filter(|(one, _)| *one == lead);
            // They are all of one lead, so that it does not matter how many seconds `paper` is.
            let seconds = match lead {
                Lead::Seconds(seconds) => seconds,
                Lead::Paper => 0.0,
            };
            let timed = of_lead.map(|(_, scored)| Timed {
                scored,
                lead: seconds,
            });
            for curve in lead_curves(timed) {
                let points = curve.points.into_iter();
                leads.extend(points.map(|point| (lead, curve.way.clone(), point)));
            }
        }
        leads.sort_by(|(_, a, _), (_, b, _)| a.cmp(b));
        Self {
            invariance: invariance(pairs(&paired)),
            leads,
        }
    }

    /// Adds its tables to the document of the batch.
    pub fn add_to(&self, document: &mut Value) {
        if !self.invariance.is_empty() {
            let rows = self.invariance.iter().map(invariance_row);
            document["invariance"] = rows.collect();
        }
        if !self.leads.is_empty() {
            document["lead"] = self.leads.iter().map(lead_row).collect();
        }
    }

    /// For people; nothing where there is nothing of the kind.
    pub fn tables(&self) -> String {
        let ways = self.invariance.iter().map(|row| &row.way);
        let ways = ways.chain(self.leads.iter().map(|(_, way, _)| way));
        let width = ways.map(|way| way.model.chars().count()).max();
        let width = width.unwrap_or(0).max("model".len());
        let mut text = String::new();
        if !self.invariance.is_empty() {
            text.push_str(&format!(
                "\nthe same scenes changed, which changes nothing about them; flips: yes became no, or no yes\n{} {:<20} {:>5} {:>5} {:>6} {:>13} {:>7} {:>6}\n",
                heads(width), "change", "n", "flips", "rate", "95 %", "renamed", "none"
            ));
        }
        for row in &self.invariance {
            text.push_str(&format!(
                "{} {:<20} {:>5} {:>5} {:>6} {:>13} {:>7} {:>6}\n",
                cells(&row.way, width),
                row.transform.to_string(),
                row.flipped.of,
                row.flipped.hits,
                share(row.flipped.value()),
                interval(&row.flipped),
                row.renamed.hits,
                row.without_verdict,
            ));
        }
        if !self.leads.is_empty() {
            text.push_str(&format!(
                "\nscenarios that collide, by seconds from the end of the window to the collision\n{} {:>6} {:>5} {:>5} {:>6} {:>13} {:>9} {:>8} {:>6} {:>9}\n",
                heads(width), "lead", "n", "yes", "rate", "95 %", "named", "unparsed", "failed", "not asked"
            ));
        }
        for (lead, way, point) in &self.leads {
            text.push_str(&format!(
                "{} {:>6} {:>5} {:>5} {:>6} {:>13} {:>9} {:>8} {:>6} {:>9}\n",
                cells(way, width),
                lead.to_string(),
                point.yes.of,
                point.yes.hits,
                share(point.yes.value()),
                interval(&point.yes),
                format!("{} of {}", point.named.hits, point.named.of),
                point.unparsed,
                point.failed,
                point.unasked,
            ));
        }
        output::visible(&text)
    }
}

fn heads(width: usize) -> String {
    format!(
        "{:<9} {:<9} {:<10} {:<width$}",
        "task", "frame", "techniques", "model"
    )
}

fn cells(way: &Way, width: usize) -> String {
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

fn invariance_row(row: &Invariance) -> Value {
    json!({
        "task": row.way.task.name(),
        "frame": row.way.frame.map(|frame| frame.name()),
        "technique": row.way.techniques.map(technique),
        "model": row.way.model,
        "transform": row.transform.to_string(),
        "n": row.flipped.of,
        "flips": row.flipped.hits,
        "flip_rate": row.flipped.value(),
        "ci": row.flipped.interval(),
        "renamed": row.renamed.hits,
        "risk_change": row.risk_change,
        "risk_distance": row.risk_distance,
        "without_verdict": row.without_verdict,
    })
}

fn lead_row((lead, way, point): &(Lead, Way, LeadPoint)) -> Value {
    json!({
        "task": way.task.name(),
        "frame": way.frame.map(|frame| frame.name()),
        "technique": way.techniques.map(technique),
        "model": way.model,
        "lead": match lead {
            Lead::Seconds(seconds) => json!(seconds),
            Lead::Paper => json!("paper"),
        },
        "n": point.yes.of,
        "yes": point.yes.hits,
        "rate": point.yes.value(),
        "ci": point.yes.interval(),
        "named": point.named.hits,
        "named_of": point.named.of,
        "unparsed": point.unparsed,
        "failed": point.failed,
        "unasked": point.unasked,
    })
}
