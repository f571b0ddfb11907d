//! The specification of a batch as JSON, the form in which the store keeps it.

use serde_json::{Map, Value};

use super::spec::{Spec, SpecError};

impl Spec {
    /// As JSON, the same for the same spec.
    #[must_use]
    pub fn to_json(&self) -> String {
        // Strings, numbers and lists can always be written.
        serde_json::to_string(self).unwrap_or_default()
    }

    /// From what [`Spec::to_json`] wrote, and from what was written before experiments and batches had the same keys.
    ///
    /// # Errors
    /// It is not of this form.
    pub fn from_json(json: &str) -> Result<Self, SpecError> {
        let unreadable = |error: serde_json::Error| SpecError::Unreadable(error.to_string());
        let mut spec: Map<String, Value> = serde_json::from_str(json).map_err(unreadable)?;
        if spec.contains_key("paths") {
            spec = with_keys_of_experiments(spec);
        }
        serde_json::from_value(Value::Object(spec)).map_err(unreadable)
    }
}

/// A specification whose keys were its own, with those of experiments.
fn with_keys_of_experiments(old: Map<String, Value>) -> Map<String, Value> {
    let mut spec = Map::new();
    let (mut leads, mut truth) = (Vec::new(), Vec::new());
    for (key, value) in old.into_iter().filter(|(_, value)| !value.is_null()) {
        match (key.as_str(), value) {
            ("paths", paths) => drop(spec.insert("scenarios".into(), paths)),
            ("lead", first) => leads.insert(0, first),
            ("more_leads", Value::Array(more)) => leads.extend(more),
            ("ego_axes", axes) => drop(spec.insert("axes".into(), axes)),
            ("measures", Value::String(ids)) => {
                let ids = ids.split([',', ' ']).filter(|id| !id.is_empty());
                spec.insert(key, ids.collect());
            }
            ("tools", Value::Object(limits)) => {
                spec.entry("tools").or_insert(true.into());
                spec.extend(
                    limits
                        .into_iter()
                        .map(|(key, most)| (format!("tool_{key}"), most)),
                );
            }
            ("axes", Value::Object(several)) => spec.extend(several),
            ("comparison", Value::Object(mut declared)) => {
                let primary = declared.shift_remove("primary");
                spec.extend(primary.map(|pair| ("compare".into(), pair)));
                spec.extend(declared);
            }
            ("truth", Value::String(word)) => truth.push(Value::String(match word.as_str() {
                "geometry" => "auto".into(),
                "files" => continue,
                other => other.into(),
            })),
            ("truth_files", Value::Array(files)) => truth.extend(files),
            (_, value) => drop(spec.insert(key, value)),
        }
    }
    spec.extend((!leads.is_empty()).then(|| ("leads".into(), leads.into())));
    spec.insert("truth".into(), truth.into());
    spec
}
