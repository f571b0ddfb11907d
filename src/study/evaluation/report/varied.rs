//! Batch results beyond its cells: invariance to changed scenes, and verdicts by lead.

use schemars::JsonSchema;
use serde::Serialize;

use super::super::batch::Answers;
use super::super::statistics::Interval;
use super::super::{
    Invariance, Lead, LeadPoint, PromptConfig, Timed, invariance, lead_curves, pairs,
};
use super::contents::record_rows;
use super::document::Block;
use nearmiss_record::{CaptionedTable, Record, columns};

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
                leads.extend(points.map(|point| (lead, curve.configuration.clone(), point)));
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

    /// Its rows by way and change.
    #[must_use]
    pub fn changes(&self) -> Vec<InvarianceRow> {
        self.invariance.iter().map(InvarianceRow::from).collect()
    }

    /// Its rows by way and lead.
    #[must_use]
    pub fn by_lead(&self) -> Vec<LeadRow> {
        self.leads.iter().map(LeadRow::from).collect()
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
        let changes = CaptionedTable::new(
            "Transformed scenes, equally dangerous: verdicts that flipped",
            "nearmiss-changes",
            &columns::<InvarianceRow>(),
            &record_rows(&self.changes()),
        );
        let leads = CaptionedTable::new(
            "Collisions, by seconds from the end of the window to the collision",
            "nearmiss-leads",
            &columns::<LeadRow>(),
            &record_rows(&self.by_lead()),
        );
        let tables = [
            changes.with_notes([SAME_WORDS.into()]),
            leads.with_notes(self.about_leads()),
        ];
        let tables = tables.into_iter().filter_map(CaptionedTable::filled);
        std::iter::once(heading)
            .chain(tables.map(Block::Table))
            .collect()
    }
}

/// Effect of a scene change on the answers of one prompt configuration, as tables and documents have it.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct InvarianceRow {
    /// How it was asked.
    #[serde(flatten)]
    pub configuration: PromptConfig,
    /// The change of the scenes.
    #[schemars(title = "Change")]
    pub transform: String,
    /// Pairs of two verdicts.
    #[schemars(title = "n")]
    pub n: u32,
    /// Scenarios that they are about.
    pub scenarios: u32,
    /// Of the pairs those whose verdict turned from yes to no or from no to yes.
    #[schemars(title = "Flips")]
    pub flips: u32,
    /// Their share.
    #[schemars(title = "Rate", extend("decimals" = 2))]
    pub flip_rate: Option<f64>,
    /// Its interval of 95 %.
    pub flip_rate_ci: Option<Interval>,
    /// Of the pairs those whose verdicts name other obstacles as the danger.
    #[schemars(title = "Renamed")]
    pub renamed: u32,
    /// The mean of the score afterwards less the score before, over all obstacles that both verdicts of a pair score.
    pub risk_change: Option<f64>,
    /// The mean of the size of that difference.
    pub risk_distance: Option<f64>,
    /// Pairs in which one answer or both hold no verdict.
    #[schemars(title = "No verdict")]
    pub without_verdict: u32,
    /// Pairs of one and the same answer, as the change leaves the words the same; they are in none of the other counts.
    #[schemars(title = "Same words")]
    pub same_words: u32,
}

impl Record for InvarianceRow {
    const NAME: &'static str = "invariance";
    const TITLE: &'static str = "Which verdicts changed on transformed scenes";
}

impl From<&Invariance> for InvarianceRow {
    fn from(row: &Invariance) -> Self {
        Self {
            configuration: row.configuration.clone(),
            transform: row.transform.to_string(),
            n: row.flipped.of,
            scenarios: row.flipped.scenarios,
            flips: row.flipped.hits,
            flip_rate: row.flipped.value(),
            flip_rate_ci: row.flipped.interval,
            renamed: row.renamed.hits,
            risk_change: row.risk_change,
            risk_distance: row.risk_distance,
            without_verdict: row.without_verdict,
            same_words: row.same_words,
        }
    }
}

/// The answers of one prompt configuration at one lead, as tables and documents have them.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct LeadRow {
    /// How it was asked.
    #[serde(flatten)]
    pub configuration: PromptConfig,
    /// Seconds from the end of the window to the collision; `end` for two steps before the last recorded one.
    #[schemars(title = "Lead")]
    pub lead: LeadWord,
    /// Questions asked about collisions.
    #[schemars(title = "n")]
    pub n: u32,
    /// Scenarios that they are about.
    pub scenarios: u32,
    /// Those that say yes, whomever they name.
    #[schemars(title = "Said yes")]
    pub yes: u32,
    /// Their share.
    #[schemars(title = "Rate", extend("decimals" = 2))]
    pub yes_rate: Option<f64>,
    /// Its interval of 95 %.
    pub yes_rate_ci: Option<Interval>,
    /// Those that say yes and name an obstacle that is truly critical.
    #[schemars(title = "Named")]
    pub named: u32,
    /// Questions about collisions whose critical obstacles are known.
    #[schemars(title = "of")]
    pub named_of: u32,
    /// Their share.
    #[schemars(title = "Rate", extend("decimals" = 2))]
    pub named_rate: Option<f64>,
    /// Its interval of 95 %.
    pub named_rate_ci: Option<Interval>,
    /// Those that say yes about windows that are safe in truth.
    #[schemars(title = "False alarms")]
    pub false_alarms: u32,
    /// Verdicts about such windows.
    #[schemars(title = "of")]
    pub false_alarms_of: u32,
    /// Their share.
    pub false_alarm_rate: Option<f64>,
    /// Its interval of 95 %.
    pub false_alarm_rate_ci: Option<Interval>,
    /// The share of those that say yes that is dangerous in truth; null without dangerous or safe windows, as is F1.
    #[schemars(extend("decimals" = 2))]
    pub precision: Option<f64>,
    /// Harmonic mean of precision and recall.
    #[schemars(extend("decimals" = 2))]
    pub f1: Option<f64>,
    /// The share of the named obstacles that is truly critical; on a safe window none is.
    #[schemars(extend("decimals" = 2))]
    pub naming_precision: Option<f64>,
    /// Answers in which no verdict could be read.
    #[schemars(title = "Unparsed")]
    pub unparsed: u32,
    /// Questions without a whole answer.
    #[schemars(title = "Failed")]
    pub failed: u32,
    /// Questions that were not asked, or not yet.
    #[schemars(title = "Not asked")]
    pub unasked: u32,
}

/// A lead for programs: seconds, or the word for the end of recordings.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum LeadWord {
    /// Seconds before the collision.
    Seconds(f64),
    /// `end`.
    Word(&'static str),
}

impl From<Lead> for LeadWord {
    fn from(lead: Lead) -> Self {
        match lead {
            Lead::Seconds(seconds) => Self::Seconds(seconds),
            Lead::Paper => Self::Word("end"),
        }
    }
}

impl Record for LeadRow {
    const NAME: &'static str = "lead";
    const TITLE: &'static str = "Results by lead of the safety task";
}

impl From<&(Lead, PromptConfig, LeadPoint)> for LeadRow {
    fn from((lead, configuration, point): &(Lead, PromptConfig, LeadPoint)) -> Self {
        let whole = point.counts.positives() > 0 && point.counts.negatives() > 0;
        Self {
            configuration: configuration.clone(),
            lead: (*lead).into(),
            n: point.yes.of,
            scenarios: point.yes.scenarios,
            yes: point.yes.hits,
            yes_rate: point.yes.value(),
            yes_rate_ci: point.yes.interval,
            named: point.named.hits,
            named_of: point.named.of,
            named_rate: point.named.value(),
            named_rate_ci: point.named.interval,
            false_alarms: point.false_alarms.hits,
            false_alarms_of: point.false_alarms.of,
            false_alarm_rate: point.false_alarms.value(),
            false_alarm_rate_ci: point.false_alarms.interval,
            precision: point.counts.precision().filter(|_| whole),
            f1: point.counts.f1().filter(|_| whole),
            naming_precision: point.naming.precision(),
            unparsed: point.unparsed,
            failed: point.failed,
            unasked: point.unasked,
        }
    }
}
