//! Names of prompt configurations in reports.

use super::super::{Cluster, PromptConfig};

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
