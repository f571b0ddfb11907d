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
                "\nthe same scenes changed, which changes nothing about them; flips: yes became no, or no yes\n{} {:<20} {:>5} {:>5} {:>6} {:>13} {:>7} {:>6} {:>10}\n",
                heads(width), "change", "n", "flips", "rate", "95 %", "renamed", "none", "same words"
            ));
        }
        for row in &self.invariance {
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
        if self.invariance.iter().any(|row| row.same_words > 0) {
            text.push_str(
                "same words: the change leaves the question as it is, so that it was not asked again; not in n\n",
            );
        }
        if !self.leads.is_empty() {
            text.push_str(&format!(
                "\nscenarios that collide, by seconds from the end of the window to the collision\n{} {:>6} {:>5} {:>8} {:>6} {:>13} {:>9} {:>6} {:>13} {:>12} {:>8} {:>6} {:>9}\n",
                heads(width), "lead", "n", "said yes", "rate", "95 %", "named", "rate", "95 %", "false alarms", "unparsed", "failed", "not asked"
            ));
        }
        for (lead, way, point) in &self.leads {
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
        if !self.leads.is_empty() {
            text.push_str(&self.about_leads());
        }
        output::visible(&text)
    }

    /// What the columns of leads mean, and where false alarms are.
    fn about_leads(&self) -> String {
        let alarms = match self
            .leads
            .iter()
            .any(|(.., point)| point.false_alarms.of > 0)
        {
            true => {
                "windows of scenarios without a collision are the same at every lead and are asked once: their false \
                 alarms hold for all leads"
            }
            false => {
                "no scenario without a collision was asked with these leads, so that there are no false alarms to set \
                 beside; the table above has those of the batch"
            }
        };
        format!(
            "said yes: whomever it names; named: also names the obstacle of the truth with a score of 0 or 1, as the table \
             above counts it\n{alarms}\n"
        )
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
        "scenarios": row.flipped.scenarios,
        "flips": row.flipped.hits,
        "flip_rate": row.flipped.value(),
        "ci": row.flipped.interval(),
        "renamed": row.renamed.hits,
        "risk_change": row.risk_change,
        "risk_distance": row.risk_distance,
        "without_verdict": row.without_verdict,
        "same_words": row.same_words,
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
        "scenarios": point.yes.scenarios,
        "yes": point.yes.hits,
        "yes_rate": point.yes.value(),
        "yes_ci": point.yes.interval(),
        "named": point.named.hits,
        "named_of": point.named.of,
        "named_rate": point.named.value(),
        "named_ci": point.named.interval(),
        "false_alarms": point.false_alarms.hits,
        "false_alarms_of": point.false_alarms.of,
        "false_alarm_rate": point.false_alarms.value(),
        "false_alarm_ci": point.false_alarms.interval(),
        "unparsed": point.unparsed,
        "failed": point.failed,
        "unasked": point.unasked,
    })
}
