//! Leads before a collision: where the windows of the safety task end, and verdicts by lead.

use std::collections::BTreeMap;

use nearmiss_record::fields::{FieldValue, Takes, Wrong};
use nearmiss_scene::judge::judge_collision;
use nearmiss_scene::metrics::Thresholds;
use nearmiss_scene::scenario::{Scene, Window};
use nearmiss_scene::verdict::Task;
use toml::Value;

use super::confusion::{Share, Tally};
use super::{AnswerStatus, Confusion, Label, Naming, PromptConfig, Scored};

/// End of the window before a collision.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Lead {
    /// Two steps before the last recorded one. The scripts of "From Words to Collisions" end every window there,
    /// those of safe scenarios too; at any lead, this one included, those have their first window.
    Paper,
    /// This many seconds before the first step at which the bodies of the ego and anyone else overlap, or have touched
    /// since the step before; to the
    /// nearest step.
    Seconds(f64),
}

/// Steps that the scripts of "From Words to Collisions" describe.
pub const PAPER_STEPS: usize = 10;

/// A scenario with its label.
#[derive(Debug, Clone, Copy)]
pub struct Labelled<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The label.
    pub label: Label,
    /// The first step at which the ego overlaps an obstacle, or has touched it since the step before.
    pub contact: Option<i64>,
}

impl<'a> Labelled<'a> {
    /// A scene with its exact geometric truth, or with a label that says otherwise.
    #[must_use]
    pub fn new(scene: &'a Scene, label: Option<Label>) -> Self {
        let collision = judge_collision(scene, Thresholds::shipped());
        let hit = collision.decisive_step.is_some();
        let who = collision.verdict.obstacles.first().map(|o| o.id);
        Self {
            scene,
            label: label.unwrap_or(if hit {
                Label::Collision(who)
            } else {
                Label::Safe
            }),
            contact: collision.decisive_step,
        }
    }

    /// Where the label and the bodies do not agree.
    #[must_use]
    pub fn doubt(&self) -> Option<&'static str> {
        match (self.label, self.contact) {
            (Label::Collision(_), None) => Some(
                "labelled a collision, but no bodies overlap; the last recorded step is used as the collision",
            ),
            (Label::Safe, Some(_)) => Some("labelled safe, but bodies touch"),
            _ => None,
        }
    }

    /// The window at a lead: of a collision, `history` steps that end this long before it, fewer where the
    /// recording begins later; of a safe scenario always its first `history` steps.
    ///
    /// Where a label says collision and no bodies overlap, the last recorded step stands for the contact.
    #[must_use]
    pub fn window(&self, lead: Lead, history: usize) -> Option<Window> {
        let steps = self.scene.steps();
        let last = match (self.label, lead) {
            (Label::Safe, _) => first_full_step(self.scene, history),
            (_, Lead::Paper) => steps.end - 1 - Window::AFTER_SAFETY,
            (_, Lead::Seconds(lead)) => {
                let contact = self.contact.unwrap_or(steps.end - 1);
                contact - (lead / self.scene.scenario.dt()).round() as i64
            }
        };
        steps
            .contains(&last)
            .then(|| Window::ending_at(self.scene, last, history))
    }

    /// The window that the scripts of "From Words to Collisions" describe: of a collision its end, for the safety task
    /// two steps before that; of a safe scenario its first `history` steps. `None` for other tasks.
    #[must_use]
    pub fn paper_window(&self, task: Task, history: usize) -> Option<Window> {
        match (task, self.label) {
            (Task::Collision, Label::Collision(_)) => Some(Window::ending_at(
                self.scene,
                self.scene.last_step(),
                history,
            )),
            (Task::Collision | Task::Safety, _) => self.window(Lead::Paper, history),
            (Task::Recording, _) => Some(Window::full(self.scene)),
            (Task::Attacker | Task::Trajectory, _) => None,
        }
    }
}

/// The last step of the first whole window; of a shorter recording its last step.
pub(super) fn first_full_step(scene: &Scene, history: usize) -> i64 {
    let steps = scene.steps();
    let before = i64::try_from(history.max(1) - 1).unwrap_or(i64::MAX);
    steps.start.saturating_add(before).min(steps.end - 1)
}

impl std::fmt::Display for Lead {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Paper => f.write_str("end"),
            Self::Seconds(seconds) => write!(f, "{seconds}"),
        }
    }
}

impl Lead {
    /// Whether a contact at this lead is later than a horizon, seconds: the truth of a window does not see it.
    #[must_use]
    pub fn is_beyond(self, horizon: Option<f64>) -> bool {
        matches!((self, horizon), (Self::Seconds(lead), Some(horizon)) if lead > horizon)
    }

    /// As stores keep it, those of earlier versions too; it is read again like what people write.
    #[must_use]
    pub fn stored(self) -> String {
        match self {
            Self::Paper => STORED_END.into(),
            Self::Seconds(_) => self.to_string(),
        }
    }
}

/// The word of stores for the end of recordings.
const STORED_END: &str = "paper";

impl std::str::FromStr for Lead {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if ["end", STORED_END].contains(&text) {
            return Ok(Self::Paper);
        }
        match text.parse::<f64>() {
            Ok(seconds) if seconds > 0.0 && seconds <= MAX_LEAD_SECONDS => {
                Ok(Self::Seconds(seconds))
            }
            _ => Err(format!(
                "expected `end` or seconds above 0, at most {MAX_LEAD_SECONDS}: the window ends before the collision"
            )),
        }
    }
}

/// No recording is longer, seconds.
const MAX_LEAD_SECONDS: f64 = 3600.0;

impl FieldValue for Lead {
    fn read(value: &Value, _: &Takes) -> Result<Self, Wrong> {
        let seconds = value.as_integer().map(|seconds| seconds.to_string());
        let seconds = seconds.or_else(|| value.as_float().map(|seconds| seconds.to_string()));
        let word = seconds.or_else(|| value.as_str().map(Into::into));
        word.ok_or(Wrong::kind())?.parse().map_err(Wrong::because)
    }

    fn write(&self) -> Option<Value> {
        Some(match self {
            Self::Paper => "end".into(),
            Self::Seconds(seconds) => (*seconds).into(),
        })
    }

    fn describe(_: &Takes) -> (String, serde_json::Value) {
        let seconds = serde_json::json!({ "type": "number", "exclusiveMinimum": 0, "maximum": MAX_LEAD_SECONDS });
        (
            format!("seconds above 0, at most {MAX_LEAD_SECONDS}, or `end`"),
            serde_json::json!({ "anyOf": [seconds, { "const": "end" }] }),
        )
    }
}

/// An answer, with how long before the collision its window ended.
#[derive(Debug, Clone, Copy)]
pub struct Timed<'a> {
    /// The answer.
    pub scored: &'a Scored,
    /// Seconds from the end of the window to the collision; leads are told apart by milliseconds.
    pub lead: f64,
}

/// The answers of one way at one lead; all but the false alarms are about scenarios that are collisions in truth.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LeadPoint {
    /// Seconds before the collision.
    pub lead: f64,
    /// Those that say yes, of all asked, whomever they name; who says nothing does not say yes.
    pub yes: Share,
    /// Those that say yes and name an obstacle that is truly critical, of all asked about a scenario whose critical
    /// obstacles are known.
    pub named: Share,
    /// Those that say yes, of those with a verdict about windows that are safe in truth. Of older batches these are the
    /// same at every lead and asked once: with the first lead, or where the batch was begun without one, apart.
    pub false_alarms: Share,
    /// All verdicts beside the truth, those about safe windows, too.
    pub counts: Confusion,
    /// Obstacles that these verdicts name.
    pub naming: Naming,
    /// Answers in which no verdict could be read.
    pub unparsed: u32,
    /// Questions without a whole answer.
    pub failed: u32,
    /// Questions that were not asked, or not yet.
    pub unasked: u32,
}

/// Verdicts of one prompt configuration at all leads.
#[derive(Debug, Clone, PartialEq)]
pub struct LeadCurve {
    /// How it was asked.
    pub configuration: PromptConfig,
    /// By lead, the longest first.
    pub points: Vec<LeadPoint>,
}

/// The curves of answers, by way. Answers about scenarios that are no collision in truth are false alarms of a lead, or
/// none; those without a truth are left out.
#[must_use]
pub fn lead_curves<'a>(answers: impl IntoIterator<Item = Timed<'a>>) -> Vec<LeadCurve> {
    let mut configurations: BTreeMap<&PromptConfig, Vec<Timed<'a>>> = BTreeMap::new();
    for timed in answers {
        if timed.scored.truth.is_some() && timed.lead.is_finite() {
            configurations
                .entry(&timed.scored.configuration)
                .or_default()
                .push(timed);
        }
    }
    let curve = |(configuration, answers): (&PromptConfig, Vec<Timed<'a>>)| LeadCurve {
        configuration: configuration.clone(),
        points: points(&answers),
    };
    configurations.into_iter().map(curve).collect()
}

/// Counts at one lead.
#[derive(Default)]
struct Counts<'a> {
    point: LeadPoint,
    yes: Tally<'a>,
    named: Tally<'a>,
    false_alarms: Tally<'a>,
}

fn points(answers: &[Timed<'_>]) -> Vec<LeadPoint> {
    let mut points: BTreeMap<i64, Counts<'_>> = BTreeMap::new();
    for timed in answers {
        let milliseconds = (timed.lead * 1000.0).round();
        let counts = points.entry(milliseconds as i64).or_default();
        let (unit, point) = (timed.scored.unit(), &mut counts.point);
        point.lead = milliseconds / 1000.0;
        if let (Some(yes), Some(truth)) = (timed.scored.positive(), timed.scored.is_collision()) {
            point.counts.count(yes, truth);
        }
        point.naming.count(timed.scored);
        if timed.scored.is_collision() != Some(true) {
            if let Some(yes) = timed.scored.positive() {
                counts.false_alarms.count(unit, yes);
            }
            continue;
        }
        match &timed.scored.status {
            AnswerStatus::Unparsed(_) => point.unparsed += 1,
            AnswerStatus::Failed(_) => point.failed += 1,
            AnswerStatus::Unasked(_) => {
                point.unasked += 1;
                continue;
            }
            AnswerStatus::Verdict(_) => {}
        }
        let verdict = match &timed.scored.status {
            AnswerStatus::Verdict(verdict) if verdict.dangerous => Some(verdict),
            _ => None,
        };
        counts.yes.count(unit, verdict.is_some());
        let critical = &timed.scored.critical;
        if !critical.is_empty() {
            let named = verdict
                .is_some_and(|verdict| verdict.danger().iter().any(|id| critical.contains(id)));
            counts.named.count(unit, named);
        }
    }
    let point = |counts: Counts<'_>| LeadPoint {
        yes: counts.yes.share(),
        named: counts.named.share(),
        false_alarms: counts.false_alarms.share(),
        ..counts.point
    };
    points.into_values().rev().map(point).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::evaluation::Label;
    use crate::evaluation::tests_scored::{answer, failed};

    fn about(scenario: &str, dangerous: bool, risks: &[(i64, u8)], truth: Label) -> Scored {
        Scored {
            truth: Some(truth),
            critical: truth.critical(),
            ..answer(scenario, "m/x", dangerous, risks)
        }
    }

    #[test]
    fn a_curve_counts_yes_and_names_at_each_lead() {
        let truth = Label::Collision(Some(7));
        let answers = [
            // Seen at 3 s, lost at 2 s, seen from 1 s on.
            (about("a", true, &[(7, 1)], truth), 3.0),
            (about("a", false, &[], truth), 2.0),
            (about("a", true, &[(7, 0)], truth), 1.0),
            (about("a", true, &[(8, 0)], truth), 0.5),
            // Seen from 2 s on; nothing came at 1 s.
            (about("b", false, &[(7, 3)], Label::Collision(None)), 3.0),
            (about("b", true, &[], Label::Collision(None)), 2.0),
            (
                Scored {
                    truth: Some(truth),
                    ..failed("b", "m/x")
                },
                1.0,
            ),
            (about("b", true, &[], Label::Collision(None)), 0.500_2),
            // Never seen.
            (about("c", false, &[], truth), 0.5),
            // No collision.
            (about("d", true, &[], Label::Safe), 1.0),
            (about("e", false, &[(4, 1)], Label::Safe), 1.0),
            // The truth is unknown.
            (answer("f", "m/x", true, &[]), 1.0),
        ];
        let timed = answers.iter().map(|(scored, lead)| Timed {
            scored,
            lead: *lead,
        });
        let curves = lead_curves(timed);
        assert_eq!(curves.len(), 1);
        let curve = &curves[0];
        let leads: Vec<f64> = curve.points.iter().map(|p| p.lead).collect();
        assert_eq!(leads, [3.0, 2.0, 1.0, 0.5]);
        let yes: Vec<_> = curve
            .points
            .iter()
            .map(|p| (p.yes.hits, p.yes.of))
            .collect();
        assert_eq!(yes, [(1, 2), (1, 2), (1, 2), (2, 3)]);
        let named: Vec<_> = curve
            .points
            .iter()
            .map(|p| (p.named.hits, p.named.of))
            .collect();
        assert_eq!(named, [(1, 1), (0, 1), (1, 1), (0, 2)]);
        let alarms: Vec<_> = curve.points.iter().map(|p| p.false_alarms).collect();
        let alarms: Vec<_> = alarms.iter().map(|s| (s.hits, s.of)).collect();
        assert_eq!(alarms, [(0, 0), (0, 0), (1, 2), (0, 0)]);
        assert_eq!((curve.points[2].failed, curve.points[2].unparsed), (1, 0));
    }
}
