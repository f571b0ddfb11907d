//! The JSON schemas of what commands print: one for each output, with keys from one vocabulary.

use serde_json::{Map, Value};

use super::SCHEMA_VERSION;
use super::derived::Derived;
use super::list::DERIVED;

/// Schemas of outputs that are not one type, as JSON: their keys refer to the vocabulary.
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
    let outputs = read(OUTPUTS)
        .into_iter()
        .map(|(name, schema)| (name, title(&schema)));
    let derived = DERIVED.iter().map(|d| (d.name.into(), d.title.into()));
    let mut all: Vec<(String, String)> = outputs.chain(derived).collect();
    all.sort();
    all
}

/// The keys of the vocabulary, with what they mean.
pub fn keys() -> Vec<(String, String)> {
    let about = |key: &Value| key["description"].as_str().unwrap_or_default().to_string();
    let keys = read(VOCABULARY).into_iter();
    keys.map(|(name, key)| (name, about(&key))).collect()
}

/// The JSON schema of an output, complete.
pub fn document(name: &str) -> Option<Value> {
    match DERIVED.iter().find(|derived| derived.name == name) {
        Some(derived) => Some(of_type(derived)),
        None => written(name),
    }
}

/// The schema of an output that is one type.
fn of_type(derived: &Derived) -> Value {
    let vocabulary = read(VOCABULARY);
    let mut schema = (derived.schema)();
    let mut properties = first_properties();
    for (key, meaning) in schema["properties"].as_object().into_iter().flatten() {
        let mut meaning = match meaning {
            // What a value of any kind may be.
            Value::Bool(_) => Map::new(),
            other => other.as_object().cloned().unwrap_or_default(),
        };
        let known = vocabulary.get(key).map(|known| &known["description"]);
        let own_words = !derived.common_words && meaning.contains_key("description");
        if let (false, Some(known)) = (own_words, known) {
            meaning.insert("description".into(), known.clone());
        }
        properties.insert(key.clone(), meaning.into());
    }
    let required = schema["required"]
        .take()
        .as_array()
        .cloned()
        .unwrap_or_default();
    complete(derived.title.into(), properties, required, false.into())
}

/// The schema of an output in the table.
fn written(name: &str) -> Option<Value> {
    let output = read(OUTPUTS).remove(name)?;
    let vocabulary = read(VOCABULARY);
    let mut properties = first_properties();
    let mut required = Vec::new();
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
    Some(complete(
        output["title"].clone(),
        properties,
        required,
        output.get("more").cloned().unwrap_or(false.into()),
    ))
}

/// The property that every object begins with.
fn first_properties() -> Map<String, Value> {
    let version =
        serde_json::json!({ "const": SCHEMA_VERSION, "description": "The version of this form." });
    Map::from_iter([("schema_version".to_string(), version)])
}

/// A schema of an object.
fn complete(
    title: Value,
    properties: Map<String, Value>,
    required: Vec<Value>,
    more: Value,
) -> Value {
    let first = std::iter::once(Value::from("schema_version"));
    serde_json::json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": title,
        "type": "object",
        "properties": properties,
        "required": first.chain(required).collect::<Vec<_>>(),
        "additionalProperties": more,
    })
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
