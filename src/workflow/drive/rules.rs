//! What became of the traffic rules in a drive, as records for programs.

use nearmiss_scene::traffic_rules::{Finding, Rule, RuleReport, Violation};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::record::thousandths;

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
