//! Names of prompt configurations in reports.

use super::super::{Cluster, PromptConfig};
use nearmiss_ask::prompts::Techniques;

/// Techniques as reports name them: `base`, `cp`, `cp+cot`, `all`.
#[must_use]
pub fn technique(techniques: Techniques) -> String {
    if techniques == Techniques::ALL {
        "all".into()
    } else {
        techniques.to_string()
    }
}

/// The frame of a way, or a dash.
pub(super) fn frame(way: &PromptConfig) -> String {
    way.frame.map_or_else(|| NONE.into(), |f| f.name().into())
}

/// The techniques of a way, or a dash.
pub(super) fn techniques(way: &PromptConfig) -> String {
    way.techniques.map_or_else(|| NONE.into(), technique)
}

/// The version of the template, or a dash.
pub(super) fn template(way: &PromptConfig) -> String {
    let version = way.template.as_ref();
    version.map_or_else(|| NONE.into(), ToString::to_string)
}

/// The values of the axes of a way, or a dash.
pub(super) fn settings(way: &PromptConfig) -> String {
    way.settings.words().unwrap_or_else(|| NONE.into())
}

/// The model of a way with the values of its axes: `lab/model · effort low`.
#[must_use]
pub fn model(way: &PromptConfig) -> String {
    match way.settings.words() {
        None => way.model.clone(),
        Some(settings) => format!("{} · {settings}", way.model),
    }
}

/// A way in short: `ego · cp+cot · lab/model · effort low · collision-ego@3fa2c1`.
#[must_use]
pub fn way(way: &PromptConfig) -> String {
    let frame = way.frame.map(|f| f.name().to_string());
    let parts = [
        frame,
        way.techniques.map(technique),
        Some(model(way)),
        way.template.as_ref().map(ToString::to_string),
    ];
    parts.into_iter().flatten().collect::<Vec<_>>().join(" · ")
}

/// Stands where there is no value.
pub(crate) const NONE: &str = "–";

/// Formats with this many decimals, or a dash.
pub(crate) fn number(value: Option<f64>, decimals: usize) -> String {
    value.map_or_else(|| NONE.into(), |v| format!("{v:.decimals$}"))
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
