//! Verdicts by lead time before a collision: how early a prompt configuration detects it.

use std::collections::BTreeMap;

use super::share::{Share, Tally};
use super::{AnswerStatus, PromptConfig, Scored};

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
    pub way: PromptConfig,
    /// By lead, the longest first.
    pub points: Vec<LeadPoint>,
}

/// The curves of answers, by way. Answers about scenarios that are no collision in truth are false alarms of a lead, or
/// none; those without a truth are left out.
#[must_use]
pub fn lead_curves<'a>(answers: impl IntoIterator<Item = Timed<'a>>) -> Vec<LeadCurve> {
    let mut ways: BTreeMap<&PromptConfig, Vec<Timed<'a>>> = BTreeMap::new();
    for timed in answers {
        if timed.scored.truth.is_some() && timed.lead.is_finite() {
            ways.entry(&timed.scored.way).or_default().push(timed);
        }
    }
    let curve = |(way, answers): (&PromptConfig, Vec<Timed<'a>>)| LeadCurve {
        way: way.clone(),
        points: points(&answers),
    };
    ways.into_iter().map(curve).collect()
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
