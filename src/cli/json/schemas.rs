//! The JSON schemas of what commands print: one for each output, with keys from one vocabulary.

use serde_json::{Map, Value};

use super::SCHEMA_VERSION;

/// Schemas by name, as JSON: their keys refer to the vocabulary.
const OUTPUTS: &str = include_str!("outputs.json");

/// Keys that mean the same wherever they stand.
const VOCABULARY: &str = include_str!("vocabulary.json");

/// The program's own files are right; a test reads them.
fn read(text: &str) -> Map<String, Value> {
    match serde_json::from_str(text) {
        Ok(Value::Object(object)) => object,
        _ => Map::new(),
    }
}

/// The outputs that have a schema, with what they are.
pub fn names() -> Vec<(String, String)> {
    let title = |schema: &Value| schema["title"].as_str().unwrap_or_default().to_string();
    let outputs = read(OUTPUTS).into_iter();
    outputs
        .map(|(name, schema)| (name, title(&schema)))
        .collect()
}

/// The keys of the vocabulary, with what they mean.
pub fn keys() -> Vec<(String, String)> {
    let about = |key: &Value| key["description"].as_str().unwrap_or_default().to_string();
    let keys = read(VOCABULARY).into_iter();
    keys.map(|(name, key)| (name, about(&key))).collect()
}

/// The JSON schema of an output, complete.
pub fn document(name: &str) -> Option<Value> {
    let output = read(OUTPUTS).remove(name)?;
    let vocabulary = read(VOCABULARY);
    let mut schema = Map::from_iter([
        (
            "$schema".to_string(),
            "https://json-schema.org/draft/2020-12/schema".into(),
        ),
        ("title".to_string(), output["title"].clone()),
        ("type".to_string(), "object".into()),
    ]);
    let mut properties = Map::from_iter([(
        "schema_version".to_string(),
        serde_json::json!({ "const": SCHEMA_VERSION, "description": "The version of this form." }),
    )]);
    let mut required = vec![Value::from("schema_version")];
    for (list, needed) in [("required", true), ("optional", false)] {
        for key in output[list].as_array().into_iter().flatten() {
            let name = key.as_str().unwrap_or_default();
            let meaning = output["keys"].get(name).or_else(|| vocabulary.get(name));
            properties.insert(name.into(), meaning.cloned().unwrap_or(true.into()));
            if needed {
                required.push(key.clone());
            }
        }
    }
    for (old, new) in output["deprecated"].as_object().into_iter().flatten() {
        let meaning = serde_json::json!({ "deprecated": true, "description": new });
        properties.insert(old.clone(), meaning);
    }
    schema.insert("properties".into(), properties.into());
    schema.insert("required".into(), required.into());
    schema.insert(
        "additionalProperties".into(),
        output.get("more").cloned().unwrap_or(false.into()),
    );
    Some(schema.into())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn every_key_of_every_output_is_described() {
        assert!(names().len() > 20);
        for (name, title) in names() {
            assert!(!title.is_empty(), "{name}");
            let schema = document(&name).unwrap();
            for (key, meaning) in schema["properties"].as_object().unwrap() {
                let about = meaning["description"].as_str().unwrap_or_default();
                assert!(!about.is_empty(), "{name}: {key} has no description");
            }
        }
    }

    #[test]
    fn the_vocabulary_has_no_key_that_no_output_has() {
        let all: Vec<Value> = names().iter().map(|(n, _)| document(n).unwrap()).collect();
        for key in read(VOCABULARY).keys() {
            let used = |schema: &Value| schema["properties"].get(key).is_some();
            assert!(all.iter().any(used), "{key}");
        }
    }
}
