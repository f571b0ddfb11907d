//! The JSON schemas of what commands print: one for each output, with keys from one vocabulary.

use std::collections::BTreeMap;

use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};

use super::SCHEMA_VERSION;
use super::derived::Derived;
use super::list::DERIVED;

/// Schemas of outputs that are not one type, as JSON: their keys refer to the vocabulary.
const OUTPUTS: &str = include_str!("outputs.json");

/// Keys that mean the same wherever they stand.
const VOCABULARY: &str = include_str!("vocabulary.json");

/// An output in the table.
#[derive(Deserialize)]
struct Output {
    title: String,
    required: Vec<String>,
    optional: Vec<String>,
    /// Keys with another meaning than in the vocabulary.
    keys: Map<String, Value>,
    /// The schema of all other keys.
    more: Value,
}

/// The schema of a type as far as it is used.
#[derive(Default, Deserialize)]
#[serde(default)]
struct Fields {
    properties: Map<String, Value>,
    required: Vec<String>,
}

/// The program's own files are right; a test reads them.
fn read<T: DeserializeOwned + Default>(text: &str) -> T {
    serde_json::from_str(text).unwrap_or_default()
}

fn outputs() -> BTreeMap<String, Output> {
    read(OUTPUTS)
}

fn vocabulary() -> Map<String, Value> {
    read(VOCABULARY)
}

/// What a key of the vocabulary means.
fn meaning(key: &Value) -> &str {
    let words = key.get("description").and_then(Value::as_str);
    words.unwrap_or_default()
}

/// The outputs that have a schema, with what they are.
pub fn names() -> Vec<(String, String)> {
    let written = outputs().into_iter();
    let outputs = written.map(|(name, output)| (name, output.title));
    let derived = DERIVED.iter().map(|d| (d.name.into(), d.title.into()));
    let mut all: Vec<(String, String)> = outputs.chain(derived).collect();
    all.sort();
    all
}

/// The keys of the vocabulary, with what they mean.
pub fn keys() -> Vec<(String, String)> {
    let keys = vocabulary().into_iter();
    keys.map(|(name, key)| (name, meaning(&key).to_string()))
        .collect()
}

/// The JSON schema of an output, complete.
pub fn document(name: &str) -> Option<Value> {
    match DERIVED.iter().find(|derived| derived.name == name) {
        Some(derived) => Some(of_type(derived)),
        None => outputs().remove(name).map(written),
    }
}

/// The schema of an output that is one type.
fn of_type(derived: &Derived) -> Value {
    let vocabulary = vocabulary();
    let fields: Fields = serde_json::from_value((derived.schema)()).unwrap_or_default();
    let mut properties = first_properties();
    for (key, field) in fields.properties {
        let mut field = match field {
            Value::Object(field) => field,
            // What a value of any kind may be.
            _ => Map::new(),
        };
        let own_words = !derived.common_words && field.contains_key("description");
        if let (false, Some(known)) = (own_words, vocabulary.get(&key)) {
            field.insert("description".into(), meaning(known).into());
        }
        properties.insert(key, field.into());
    }
    complete(derived.title, properties, fields.required, false.into())
}

/// The schema of an output in the table.
fn written(mut output: Output) -> Value {
    let mut vocabulary = vocabulary();
    let mut properties = first_properties();
    for name in output.required.iter().chain(&output.optional) {
        let meaning = output.keys.remove(name).or_else(|| vocabulary.remove(name));
        properties.insert(name.clone(), meaning.unwrap_or(true.into()));
    }
    complete(&output.title, properties, output.required, output.more)
}

/// The property that every object begins with.
fn first_properties() -> Map<String, Value> {
    let version =
        serde_json::json!({ "const": SCHEMA_VERSION, "description": "The version of this form." });
    Map::from_iter([("schema_version".to_string(), version)])
}

/// A schema of an object.
fn complete(
    title: &str,
    properties: Map<String, Value>,
    mut required: Vec<String>,
    more: Value,
) -> Value {
    required.insert(0, "schema_version".into());
    serde_json::json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": title,
        "type": "object",
        "properties": properties,
        "required": required,
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
        for key in vocabulary().keys() {
            let used = |schema: &Value| schema["properties"].get(key).is_some();
            assert!(all.iter().any(used), "{key}");
        }
    }
}
