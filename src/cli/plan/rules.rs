//! The rule report of a drive for programs, and counts over drives.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::document::{DriveRecord, thousandths};
use nearmiss_scene::traffic_rules::{Finding, Rule, RuleReport, Violation};

/// What became of a traffic rule.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct RuleRecord {
    /// Its name.
    pub rule: String,
    /// Its number in the formalisation.
    pub number: String,
    /// broken, obeyed, not_applicable or undecided.
    pub status: String,
    /// Why.
    pub reason: Option<String>,
    /// When and where it was broken.
    pub violations: Vec<ViolationRecord>,
}

/// When and where a rule was broken.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct ViolationRecord {
    from_step: i64,
    until_step: i64,
    from_seconds: f64,
    until_seconds: f64,
    x: f64,
    y: f64,
    lanelet: Option<i64>,
    obstacle: Option<i64>,
    /// By how much.
    amount: f64,
    unit: String,
}

impl RuleRecord {
    /// Of each rule, where a step takes `dt` seconds.
    pub fn all(report: &RuleReport, dt: f64) -> Vec<Self> {
        let findings = report.findings.iter();
        findings.map(|finding| Self::new(finding, dt)).collect()
    }

    fn new(finding: &Finding, dt: f64) -> Self {
        let violations = finding.violations.iter();
        Self {
            rule: finding.rule.name().into(),
            number: finding.rule.number().into(),
            status: finding.status.name().into(),
            reason: finding.reason.map(String::from),
            violations: violations
                .map(|violation| ViolationRecord::new(finding.rule, violation, dt))
                .collect(),
        }
    }
}

impl ViolationRecord {
    fn new(rule: Rule, violation: &Violation, dt: f64) -> Self {
        Self {
            from_step: violation.from,
            until_step: violation.until,
            from_seconds: thousandths(violation.from as f64 * dt),
            until_seconds: thousandths(violation.until as f64 * dt),
            x: thousandths(violation.at.x),
            y: thousandths(violation.at.y),
            lanelet: violation.lanelet,
            obstacle: violation.obstacle,
            amount: thousandths(violation.amount),
            unit: rule.unit().into(),
        }
    }
}

/// The rules that a drive broke.
fn broken(drive: &DriveRecord) -> impl Iterator<Item = Rule> {
    let named = drive.rules_broken.iter();
    named.filter_map(|name| Rule::ALL.into_iter().find(|rule| name == rule.name()))
}

/// The rules that a drive broke, in a few words; nothing where it broke none.
pub fn words(drive: &DriveRecord) -> Option<String> {
    let broken: Vec<&str> = broken(drive).map(Rule::text).collect();
    (!broken.is_empty()).then(|| format!("breaks {}", broken.join(", ")))
}

/// How many drives broke which rule.
#[derive(Debug, Default)]
pub struct RuleCounts([usize; Rule::ALL.len()]);

impl RuleCounts {
    /// Counts a drive.
    pub fn add(&mut self, drive: &DriveRecord) {
        for (count, rule) in self.0.iter_mut().zip(Rule::ALL) {
            *count += usize::from(broken(drive).any(|broken| broken == rule));
        }
    }

    /// The counts on a line; nothing where no rule was broken.
    pub fn line(&self) -> Option<String> {
        let counted = self
            .0
            .iter()
            .zip(Rule::ALL)
            .filter(|(count, _)| **count > 0);
        let parts: Vec<String> = counted
            .map(|(count, rule)| format!("{} {count}", rule.text()))
            .collect();
        (!parts.is_empty()).then(|| format!("drives that break a rule: {}\n", parts.join(", ")))
    }
}
