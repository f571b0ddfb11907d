//! What a report is about, and names of prompt configurations in it.

use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;

use super::super::{Cluster, PromptConfig};
use crate::evaluation::Provenance;

/// The model of a way with the values of its axes: `lab/model · effort low`.
#[must_use]
pub fn model(configuration: &PromptConfig) -> String {
    match configuration.settings.to_stored() {
        None => configuration.model.clone(),
        Some(settings) => format!("{} · {settings}", configuration.model),
    }
}

/// A way in short: `ego · cp+cot · lab/model · effort low · collision-ego@3fa2c1`.
#[must_use]
pub fn configuration_name(configuration: &PromptConfig) -> String {
    let frame = configuration.frame.map(|f| f.name().to_string());
    let parts = [
        frame,
        configuration.techniques.map(|used| used.to_string()),
        Some(model(configuration)),
        configuration.template.as_ref().map(ToString::to_string),
    ];
    parts.into_iter().flatten().collect::<Vec<_>>().join(" · ")
}

/// A p value: three decimals, and none so small that they would be 0.
pub(crate) fn p_value(p: f64) -> String {
    if p < 0.001 {
        "< 0.001".into()
    } else {
        format!("{p:.3}")
    }
}

/// The column of how many units there are.
pub(super) fn units(unit: Cluster) -> &'static str {
    match unit {
        Cluster::Scenario => "Scenarios",
        Cluster::Map => "Maps",
    }
}

/// Subject of a report.
#[derive(Debug, Clone, PartialEq, Default, Serialize, JsonSchema)]
pub struct ReportSubject {
    /// The batch, such as `b7`; null if the report is not of one.
    pub batch: Option<String>,
    /// What the batch is about, in a line: the title of documents.
    #[serde(skip)]
    pub title: Option<String>,
    /// The part of the batch's split, `dev` or `test`; `None` for all of it.
    #[serde(skip)]
    pub split: Option<&'static str>,
    /// How the batch asks, as it was begun; null if the report is not of one.
    pub asked: Option<Value>,
    /// The ground truth.
    pub truth: TruthSubject,
    /// Notes for the reader, in sentences.
    pub notes: Vec<String>,
    /// What it was made from: program, batch, days of the answers, models as returned, hashes of templates, scenarios and
    /// thresholds.
    pub provenance: Option<Provenance>,
}

/// The ground truth of a report.
#[derive(Debug, Clone, PartialEq, Default, Serialize, JsonSchema)]
pub struct TruthSubject {
    /// Its description.
    pub words: String,
    /// The same as words of `--truth`: `auto`, `layout`, files.
    pub sources: Vec<String>,
}
