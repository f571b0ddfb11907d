//! The rule report of a drive: which rules applied, and which were broken, when, where and by how much.

use std::collections::BTreeSet;

use super::ego::{EgoAlong, Moment};
use super::{Rule, RuleStatus, distance, right_of_way, speed, stopping};
use crate::scenario::Scene;
use nearmiss_base::geometry::Point;

/// What became of all rules in a drive.
#[derive(Debug, Clone, PartialEq)]
pub struct RuleReport {
    /// One for each rule, in the order of [`Rule::ALL`].
    pub findings: Vec<Finding>,
}

/// What became of a rule.
#[derive(Debug, Clone, PartialEq)]
pub struct Finding {
    /// The rule.
    pub rule: Rule,
    /// What became of it.
    pub status: RuleStatus,
    /// Why it did not apply or cannot be decided.
    pub reason: Option<&'static str>,
    /// Each time that it was broken, in order.
    pub violations: Vec<Violation>,
}

/// A rule that was broken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Violation {
    /// The first time step.
    pub from: i64,
    /// The last time step.
    pub until: i64,
    /// Where the ego was at the worst moment, metres.
    pub at: Point,
    /// Its lanelet there.
    pub lanelet: Option<i64>,
    /// The obstacle that the rule protects, if it is about one.
    pub obstacle: Option<i64>,
    /// By how much at the worst moment, in [`Rule::unit`]: metres that were missing to the safe distance, m/s² of braking
    /// beyond what is not abrupt, m/s above the limit, seconds that were missing to the time at a stop sign or to the
    /// time between two vehicles, speed (m/s) at a red light.
    pub amount: f64,
}

impl RuleReport {
    /// The report of a scene's ego, recorded or planned.
    #[must_use]
    pub fn of(scene: &Scene) -> Self {
        let ego = match EgoAlong::new(scene) {
            Ok(ego) => ego,
            Err(_) => return Self::all_undecided("the lanes of the ego are not known"),
        };
        if ego.moments.len() < 2 {
            return Self::all_undecided("the ego does not move along its lanes");
        }
        let mut findings = distance::findings(&ego);
        findings.push(speed::finding(&ego));
        findings.extend(stopping::findings(&ego));
        findings.extend(right_of_way::findings(&ego));
        Self { findings }
    }

    /// The same without judging the ego at these steps: a rule that was broken at them alone cannot be decided.
    #[must_use]
    pub fn unjudged_at(mut self, steps: &BTreeSet<i64>, reason: &'static str) -> Self {
        for finding in &mut self.findings {
            let judged =
                |one: &Violation| !(one.from..=one.until).all(|step| steps.contains(&step));
            if finding.status != RuleStatus::Broken {
                continue;
            }
            finding.violations.retain(judged);
            if finding.violations.is_empty() {
                *finding = Finding::undecided(finding.rule, reason);
            }
        }
        self
    }

    fn all_undecided(reason: &'static str) -> Self {
        let findings = Rule::ALL.map(|rule| Finding::undecided(rule, reason));
        Self {
            findings: findings.into(),
        }
    }

    /// The rules that were broken.
    pub fn broken(&self) -> impl Iterator<Item = Rule> + '_ {
        self.with(RuleStatus::Broken)
    }

    /// The rules of which is not known whether they were broken.
    pub fn undecided(&self) -> impl Iterator<Item = Rule> + '_ {
        self.with(RuleStatus::Undecided)
    }

    fn with(&self, status: RuleStatus) -> impl Iterator<Item = Rule> + '_ {
        let all = self.findings.iter();
        all.filter(move |finding| finding.status == status)
            .map(|finding| finding.rule)
    }

    /// What became of a rule.
    #[must_use]
    pub fn finding(&self, rule: Rule) -> Option<&Finding> {
        self.findings.iter().find(|finding| finding.rule == rule)
    }
}

impl Finding {
    /// Of a rule that applied.
    pub(super) fn applied(rule: Rule, violations: Vec<Violation>) -> Self {
        let status = if violations.is_empty() {
            RuleStatus::Obeyed
        } else {
            RuleStatus::Broken
        };
        Self {
            rule,
            status,
            reason: None,
            violations,
        }
    }

    pub(super) fn not_applicable(rule: Rule, reason: &'static str) -> Self {
        Self {
            status: RuleStatus::NotApplicable,
            ..Self::undecided(rule, reason)
        }
    }

    pub(super) fn undecided(rule: Rule, reason: &'static str) -> Self {
        Self {
            rule,
            status: RuleStatus::Undecided,
            reason: Some(reason),
            violations: Vec::new(),
        }
    }
}

/// Violations of moments that follow each other, as one: the worst amount decides where. `amount` is what a moment breaks
/// a rule by, and towards which obstacle; nothing where it does not.
pub(super) fn merged(
    ego: &EgoAlong<'_>,
    mut amount: impl FnMut(usize, &Moment) -> Option<(f64, Option<i64>)>,
) -> Vec<Violation> {
    let mut found: Vec<Violation> = Vec::new();
    for (place, moment) in ego.moments.iter().enumerate() {
        let Some((amount, obstacle)) = amount(place, moment) else {
            continue;
        };
        let now = Violation {
            from: moment.step,
            until: moment.step,
            at: moment.position,
            lanelet: ego.lanelet(moment),
            obstacle,
            amount,
        };
        match found.last_mut() {
            Some(last) if last.until + 1 == moment.step && last.obstacle == obstacle => {
                let (from, worse) = (last.from, amount > last.amount);
                if worse {
                    *last = now;
                }
                (last.from, last.until) = (from, moment.step);
            }
            _ => found.push(now),
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rule_that_is_broken_at_unjudged_steps_alone_is_undecided() {
        let broken = |from, until| Violation {
            from,
            until,
            at: Point::new(0.0, 0.0),
            lanelet: None,
            obstacle: None,
            amount: 1.0,
        };
        let report = RuleReport {
            findings: vec![
                Finding::applied(Rule::UnnecessaryBraking, vec![broken(3, 4)]),
                Finding::applied(Rule::SpeedLimit, vec![broken(3, 4), broken(4, 5)]),
                Finding::applied(Rule::RedLight, Vec::new()),
            ],
        };
        let judged = report.unjudged_at(&BTreeSet::from([3, 4]), "jumps");
        let status: Vec<RuleStatus> = judged.findings.iter().map(|one| one.status).collect();
        let wanted = [
            RuleStatus::Undecided,
            RuleStatus::Broken,
            RuleStatus::Obeyed,
        ];
        assert_eq!(status, wanted);
        assert_eq!(judged.findings[0].reason, Some("jumps"));
        assert_eq!(judged.findings[1].violations, [broken(4, 5)]);
    }
}
