//! What a monitor said of a drive, as a record for programs.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::monitor::{MonitorAnswer, MonitorReport};

/// What a monitor said of a drive.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
pub struct MonitorRecord {
    /// The judge.
    pub model: String,
    /// It is asked so often.
    #[schemars(extend("unit" = "s"))]
    pub every_seconds: f64,
    /// First and last step of each warning.
    pub warnings: Vec<[i64; 2]>,
    /// Time of the first warning.
    #[schemars(extend("unit" = "s"))]
    pub first_warning_seconds: Option<f64>,
    /// contact or near_miss.
    pub incident: Option<String>,
    /// Its step.
    pub incident_step: Option<i64>,
    /// From the first warning to the incident.
    #[schemars(extend("unit" = "s"))]
    pub lead_seconds: Option<f64>,
    /// Warnings without an incident.
    pub false_alarms: usize,
    /// The same per minute of the drive.
    pub false_alarms_per_minute: Option<f64>,
    /// Median of the measured latency.
    #[schemars(extend("unit" = "s"))]
    pub median_latency_seconds: Option<f64>,
    /// The latency that the drive counts with.
    #[schemars(extend("unit" = "s"))]
    pub latency_in_force_seconds: Option<f64>,
    /// Questions.
    pub questions: usize,
    /// Questions without a verdict.
    pub without_verdict: usize,
    /// Steps in which a warning braked.
    pub braked_steps: usize,
    /// The same as a time.
    #[schemars(extend("unit" = "s"))]
    pub braked_seconds: Option<f64>,
    /// When it braked first.
    #[schemars(extend("unit" = "s"))]
    pub first_braking_seconds: Option<f64>,
    /// Each answer.
    pub answers: Vec<MonitorAnswerRecord>,
}

/// An answer of a monitor.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct MonitorAnswerRecord {
    step: i64,
    dangerous: Option<bool>,
    latency_seconds: f64,
    counts_from_step: i64,
    run: Option<i64>,
    stored: bool,
    cost_usd: Option<f64>,
}

impl From<&MonitorAnswer> for MonitorAnswerRecord {
    fn from(answer: &MonitorAnswer) -> Self {
        Self {
            step: answer.step,
            dangerous: answer.dangerous,
            latency_seconds: answer.latency,
            counts_from_step: answer.from,
            run: answer.run.map(|run| run.0),
            stored: answer.stored,
            cost_usd: answer.usd,
        }
    }
}

impl From<&MonitorReport> for MonitorRecord {
    fn from(report: &MonitorReport) -> Self {
        let warnings = report.warnings.iter();
        Self {
            model: report.judge.clone(),
            every_seconds: report.every,
            warnings: warnings.map(|w| [w.first, w.last]).collect(),
            first_warning_seconds: report.first_warning(),
            incident: report.incident.map(|incident| incident.name().into()),
            incident_step: report.incident.map(|incident| incident.step()),
            lead_seconds: report.lead,
            false_alarms: report.false_alarms,
            false_alarms_per_minute: report.false_alarms_per_minute(),
            median_latency_seconds: report.latency(),
            latency_in_force_seconds: report.latency_in_force(),
            questions: report.answers.len(),
            without_verdict: report.without_verdict(),
            braked_steps: report.braked,
            braked_seconds: Some(report.braking()),
            first_braking_seconds: report.first_braking(),
            answers: report
                .answers
                .iter()
                .map(MonitorAnswerRecord::from)
                .collect(),
        }
    }
}
