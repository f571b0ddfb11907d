//! Words about drives: steps beyond the vehicle, and traffic rules that are broken.

use nearmiss_scene::traffic_rules::Rule;
use nearmiss_workflow::drive::{DriveRecord, DrivenScenario};

use crate::output;

/// That a drive has steps that the vehicle cannot do, in a few words.
pub fn beyond_words(driven: &DrivenScenario) -> Option<String> {
    let beyond = driven.beyond_vehicle()?;
    Some(format!(
        "{} beyond the vehicle",
        output::counted(beyond.steps, "step")
    ))
}

/// The rules that a drive broke.
fn broken_rules(drive: &DriveRecord) -> impl Iterator<Item = Rule> {
    let named = drive.rules_broken.iter();
    named.filter_map(|name| Rule::ALL.into_iter().find(|rule| name == rule.name()))
}

/// The rules that a drive broke, in a few words; nothing where it broke none.
pub fn broken_rules_note(drive: &DriveRecord) -> Option<String> {
    let broken: Vec<&str> = broken_rules(drive).map(Rule::text).collect();
    (!broken.is_empty()).then(|| format!("breaks {}", broken.join(", ")))
}

/// How many drives broke which rule.
#[derive(Debug, Default)]
pub struct RuleCounts([usize; Rule::ALL.len()]);

impl RuleCounts {
    /// Counts a drive.
    pub fn add(&mut self, drive: &DriveRecord) {
        for (count, rule) in self.0.iter_mut().zip(Rule::ALL) {
            *count += usize::from(broken_rules(drive).any(|broken| broken == rule));
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
