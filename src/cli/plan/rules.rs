//! The rule report of a drive: as JSON, and in a few words.

use serde_json::{Value, json};

use super::document::thousandths;
use nearmiss_scene::traffic_rules::{Finding, Rule, RuleReport, Violation};

/// What became of each rule, where a step takes `dt` seconds.
pub fn document(report: &RuleReport, dt: f64) -> Vec<Value> {
    let findings = report.findings.iter();
    findings.map(|finding| of_finding(finding, dt)).collect()
}

fn of_finding(finding: &Finding, dt: f64) -> Value {
    let violations = finding
        .violations
        .iter()
        .map(|violation| of_violation(finding.rule, violation, dt));
    json!({
        "rule": finding.rule.name(),
        "number": finding.rule.number(),
        "status": finding.status.name(),
        "reason": finding.reason,
        "violations": violations.collect::<Vec<_>>(),
    })
}

fn of_violation(rule: Rule, violation: &Violation, dt: f64) -> Value {
    json!({
        "from_step": violation.from,
        "until_step": violation.until,
        "from_seconds": thousandths(violation.from as f64 * dt),
        "until_seconds": thousandths(violation.until as f64 * dt),
        "x": thousandths(violation.at.x),
        "y": thousandths(violation.at.y),
        "lanelet": violation.lanelet,
        "obstacle": violation.obstacle,
        "amount": thousandths(violation.amount),
        "unit": rule.unit(),
    })
}

/// The names of rules.
pub fn names(rules: impl Iterator<Item = Rule>) -> Vec<&'static str> {
    rules.map(Rule::name).collect()
}

/// The rules that a drive broke, as `plan --format json` prints it.
fn broken(drive: &Value) -> impl Iterator<Item = Rule> {
    let named = drive["rules_broken"].as_array().into_iter().flatten();
    named.filter_map(|name| Rule::ALL.into_iter().find(|rule| name == rule.name()))
}

/// The rules that a drive broke, in a few words; nothing where it broke none.
pub fn words(drive: &Value) -> Option<String> {
    let broken: Vec<&str> = broken(drive).map(Rule::words).collect();
    (!broken.is_empty()).then(|| format!("breaks {}", broken.join(", ")))
}

/// How many drives broke which rule.
#[derive(Debug, Default)]
pub struct RuleCounts([usize; Rule::ALL.len()]);

impl RuleCounts {
    /// Counts a drive.
    pub fn add(&mut self, drive: &Value) {
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
            .map(|(count, rule)| format!("{} {count}", rule.words()))
            .collect();
        (!parts.is_empty()).then(|| format!("drives that break a rule: {}\n", parts.join(", ")))
    }
}
