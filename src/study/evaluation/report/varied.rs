//! Batch results beyond its cells: invariance to changed scenes, and verdicts by lead.

use serde_json::{Value, json};

use super::super::batch::Answers;
use super::super::{
    Invariance, Lead, LeadPoint, PromptConfig, Share, Timed, invariance, lead_curves, pairs,
};
use super::contents::with_interval;
use super::document::{Block, Table};
use super::json::interval;
use super::names::{self, NONE, technique};

/// Results of a batch with changed scenes or several leads, beside its cells.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Varied {
    /// By way and change.
    pub invariance: Vec<Invariance>,
    /// By way, in the order of the leads.
    pub leads: Vec<(Lead, PromptConfig, LeadPoint)>,
}

/// The meaning of `same words` in tables of changed scenes.
pub const SAME_WORDS: &str =
    "same words: the transform leaves the question unchanged, so it was not asked again; not in n";

impl Varied {
    /// Counts the answers of a batch.
    #[must_use]
    pub fn from_answers(answers: &Answers) -> Self {
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

    /// Whether there is nothing of the kind.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.invariance.is_empty() && self.leads.is_empty()
    }

    /// `invariance` and `lead`, each where there is something, as rows of JSON.
    #[must_use]
    pub fn fields(&self) -> Vec<(&'static str, Value)> {
        let invariance: Vec<Value> = self.invariance.iter().map(invariance_row).collect();
        let leads: Vec<Value> = self.leads.iter().map(lead_row).collect();
        let all = [("invariance", invariance), ("lead", leads)];
        let some = all.into_iter().filter(|(_, rows)| !rows.is_empty());
        some.map(|(name, rows)| (name, json!(rows))).collect()
    }

    /// Explains the columns of leads, and where false alarms are.
    #[must_use]
    pub fn about_leads(&self) -> [String; 2] {
        let points = || self.leads.iter().map(|(.., point)| point.false_alarms.of);
        let alarms = match (points().all(|of| of > 0), points().any(|of| of > 0)) {
            (true, _) => {
                "false alarms: yes to the safe windows that are matched to those of the lead"
            }
            (false, true) => {
                "safe scenarios have the same window at every lead and are asked once: their false alarms apply to all leads"
            }
            (false, false) => {
                "no safe scenario was asked with these leads, so there are no false alarms to compare; the table above has those of the batch"
            }
        };
        let columns = "said yes: whichever obstacle is named; named: also names an obstacle that is truly critical";
        [columns.into(), alarms.into()]
    }

    /// The tables for people and papers.
    pub(super) fn blocks(&self) -> Vec<Block> {
        if self.is_empty() {
            return Vec::new();
        }
        let heading = Block::Heading("Transformed scenes and leads".into());
        let tables = [self.changes(), self.by_lead()]
            .into_iter()
            .filter(|table| !table.rows.is_empty());
        std::iter::once(heading)
            .chain(tables.map(Block::Table))
            .collect()
    }

    fn changes(&self) -> Table {
        let mut table = Table::new(
            "Transformed scenes, equally dangerous: verdicts that flipped",
            "nearmiss-changes",
            &[
                "<Task",
                "<Frame",
                "<Techniques",
                "<Model",
                "<Change",
                "n",
                "Flips",
                "Rate",
                "Renamed",
                "No verdict",
                "Same words",
            ],
        );
        table.notes = vec![SAME_WORDS.into()];
        for row in &self.invariance {
            let mut cells = way(&row.way);
            cells.push(row.transform.to_string());
            cells.push(row.flipped.of.to_string());
            cells.push(row.flipped.hits.to_string());
            cells.push(if row.flipped.of == 0 && row.same_words > 0 {
                "same words".into()
            } else {
                share(&row.flipped)
            });
            let counts = [row.renamed.hits, row.without_verdict, row.same_words];
            cells.extend(counts.map(|n| n.to_string()));
            table.rows.push(cells);
        }
        table
    }

    fn by_lead(&self) -> Table {
        let mut table = Table::new(
            "Collisions, by seconds from the end of the window to the collision",
            "nearmiss-leads",
            &[
                "<Task",
                "<Frame",
                "<Techniques",
                "<Model",
                "Lead",
                "n",
                "Said yes",
                "Rate",
                "Named",
                "Rate",
                "False alarms",
                "Unparsed",
                "Failed",
                "Not asked",
            ],
        );
        table.notes = self.about_leads().into();
        for (lead, of, point) in &self.leads {
            let mut cells = way(of);
            cells.push(lead.to_string());
            cells.push(point.yes.of.to_string());
            cells.push(point.yes.hits.to_string());
            cells.push(share(&point.yes));
            cells.push(of_all(&point.named));
            cells.push(share(&point.named));
            cells.push(of_all(&point.false_alarms));
            let counts = [point.unparsed, point.failed, point.unasked];
            cells.extend(counts.map(|n| n.to_string()));
            table.rows.push(cells);
        }
        table
    }
}

fn way(way: &PromptConfig) -> Vec<String> {
    vec![
        way.task.name().into(),
        names::frame(way),
        names::techniques(way),
        names::model(way),
    ]
}

fn share(share: &Share) -> String {
    with_interval(share.value(), share.interval)
}

fn of_all(share: &Share) -> String {
    match share.of {
        0 => NONE.into(),
        all => format!("{} of {all}", share.hits),
    }
}

fn invariance_row(row: &Invariance) -> Value {
    json!({
        "task": row.way.task.name(),
        "frame": row.way.frame.map(|frame| frame.name()),
        "technique": row.way.techniques.map(technique),
        "model": row.way.model,
        "settings": row.way.settings.words(),
        "transform": row.transform.to_string(),
        "n": row.flipped.of,
        "scenarios": row.flipped.scenarios,
        "flips": row.flipped.hits,
        "flip_rate": row.flipped.value(),
        "ci": interval(row.flipped.interval),
        "renamed": row.renamed.hits,
        "risk_change": row.risk_change,
        "risk_distance": row.risk_distance,
        "without_verdict": row.without_verdict,
        "same_words": row.same_words,
    })
}

fn lead_row((lead, way, point): &(Lead, PromptConfig, LeadPoint)) -> Value {
    json!({
        "task": way.task.name(),
        "frame": way.frame.map(|frame| frame.name()),
        "technique": way.techniques.map(technique),
        "model": way.model,
        "settings": way.settings.words(),
        "lead": match lead {
            Lead::Seconds(seconds) => json!(seconds),
            Lead::Paper => json!("paper"),
        },
        "n": point.yes.of,
        "scenarios": point.yes.scenarios,
        "yes": point.yes.hits,
        "yes_rate": point.yes.value(),
        "yes_ci": interval(point.yes.interval),
        "named": point.named.hits,
        "named_of": point.named.of,
        "named_rate": point.named.value(),
        "named_ci": interval(point.named.interval),
        "false_alarms": point.false_alarms.hits,
        "false_alarms_of": point.false_alarms.of,
        "false_alarm_rate": point.false_alarms.value(),
        "false_alarm_ci": interval(point.false_alarms.interval),
        "unparsed": point.unparsed,
        "failed": point.failed,
        "unasked": point.unasked,
    })
}
