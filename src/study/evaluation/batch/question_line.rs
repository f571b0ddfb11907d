//! The questions of a batch as JSON lines, without sending them.

use std::collections::BTreeSet;

use schemars::JsonSchema;
use serde::Serialize;

use crate::evaluation::Lead;
use nearmiss_store::NewItem;

/// A question.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct QuestionLine {
    /// Name of the scenario.
    pub scenario: String,
    /// File of the scenario, or the name of a bundled one.
    pub file: String,
    /// First 12 digits of the SHA-256 of its content; null where it was not read.
    pub hash: Option<String>,
    /// Where the ego's motion is from; null where it was not read.
    pub ego: Option<String>,
    /// The task.
    pub task: String,
    /// The frame of the description; null for the built-in judge.
    pub frame: Option<String>,
    /// The prompting techniques; null for the built-in judge.
    pub techniques: Option<String>,
    /// Seconds from the end of the window to the contact, `end` for the paper's windows; null without a lead. Of a safe
    /// window, those of the dangerous one that it is like.
    pub lead: serde_json::Value,
    /// Values of the axes of the batch, such as `form compact`; null without axes.
    pub settings: Option<String>,
    /// What is changed about the scene; null for the scene as it is.
    pub transform: Option<String>,
    /// What is true: `dangerous` or `safe`; null where that is unknown.
    pub label: Option<&'static str>,
    /// Obstacles that the ego touches in the window or within the horizon after it, the first one first.
    pub critical: Vec<i64>,
    /// First time step of the window in the recording.
    pub first_step: i64,
    /// Its last one.
    pub last_step: i64,
    /// Obstacles near the ego at one of its steps.
    pub obstacles: u64,
    /// The ego's speed at its end, m/s.
    pub ego_speed: f64,
    /// Tokens of the question, estimated.
    pub tokens: u64,
    /// SHA-256 of the template and its fragments.
    pub template_hash: String,
}

impl QuestionLine {
    /// Every question once, however many models are asked and however often; those that cannot be asked are left out.
    #[must_use]
    pub fn of_items(items: &[NewItem]) -> Vec<Self> {
        let mut once = BTreeSet::new();
        let mut lines = Vec::new();
        for item in items {
            let Some(facts) = &item.facts else { continue };
            let how = (item.frame.as_deref(), item.techniques.as_deref());
            let which = (
                item.settings.as_deref(),
                item.lead.as_deref(),
                item.transform.as_deref(),
                facts.steps,
            );
            if !once.insert((&item.path, item.task, how, which)) {
                continue;
            }
            lines.push(Self {
                scenario: item.scenario.clone(),
                file: item.path.clone(),
                hash: item
                    .scenario_hash
                    .as_ref()
                    .map(|hash| hash.chars().take(12).collect()),
                ego: item.ego.clone(),
                task: item.task.name().into(),
                frame: item.frame.clone(),
                techniques: item.techniques.clone(),
                lead: lead(item.lead.as_deref()),
                settings: item.settings.clone(),
                transform: item.transform.clone(),
                label: item
                    .collides
                    .map(|collides| if collides { "dangerous" } else { "safe" }),
                critical: match item.collides {
                    Some(true) => facts.critical.clone(),
                    _ => Vec::new(),
                },
                first_step: facts.steps.0,
                last_step: facts.steps.1,
                obstacles: facts.obstacles,
                ego_speed: facts.speed,
                tokens: facts.tokens,
                template_hash: facts.template_hash.clone(),
            });
        }
        lines
    }
}

/// A number of seconds, or the word.
fn lead(stored: Option<&str>) -> serde_json::Value {
    match stored.map(str::parse::<Lead>) {
        Some(Ok(Lead::Seconds(seconds))) => seconds.into(),
        Some(Ok(lead)) => lead.to_string().into(),
        _ => serde_json::Value::Null,
    }
}
