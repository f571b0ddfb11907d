//! JSON schemas reduced to the subset every provider supports, the rest moved to descriptions.

use serde_json::{Map, Value, json};

/// Keywords that mean the same everywhere.
const KEPT: [&str; 12] = [
    "type",
    "description",
    "enum",
    "const",
    "items",
    "prefixItems",
    "anyOf",
    "properties",
    "$ref",
    "$defs",
    "additionalProperties",
    "required",
];

/// Keywords that bound a value; their words for the description.
const BOUNDS: [(&str, &str); 9] = [
    ("minimum", "at least"),
    ("maximum", "at most"),
    ("exclusiveMinimum", "more than"),
    ("exclusiveMaximum", "less than"),
    ("minLength", "characters at least"),
    ("maxLength", "characters at most"),
    ("minItems", "items at least"),
    ("maxItems", "items at most"),
    ("pattern", "of the form"),
];

/// The schema in the subset that every API with structured output accepts: all properties required, no others allowed,
/// and bounds moved to descriptions. The reader of an answer must validate it against the full schema.
pub(super) fn portable(schema: &Value) -> Value {
    let Value::Object(schema) = schema else {
        return schema.clone();
    };
    let mut kept = Map::new();
    for (key, value) in schema {
        let value = match (key.as_str(), value) {
            ("properties" | "$defs", Value::Object(parts)) => {
                let parts = parts.iter().map(|(k, v)| (k.clone(), portable(v)));
                Value::Object(parts.collect())
            }
            ("items", part) => portable(part),
            ("anyOf" | "oneOf" | "prefixItems", Value::Array(parts)) => {
                parts.iter().map(portable).collect()
            }
            (key, value) if KEPT.contains(&key) => value.clone(),
            _ => continue,
        };
        let key = if key == "oneOf" { "anyOf" } else { key };
        kept.insert(key.to_owned(), value);
    }
    // Whole numbers between narrow bounds can be listed, which every API enforces.
    let few = few(schema);
    if let Some(few) = &few {
        kept.insert("enum".into(), few.clone());
    }
    let bounds = BOUNDS.iter().filter(|_| few.is_none());
    let bounds = bounds.filter_map(|(key, word)| {
        let bound = schema.get(*key)?;
        let bound = bound
            .as_str()
            .map_or_else(|| bound.to_string(), str::to_owned);
        Some(format!("{word} {bound}"))
    });
    let bounds: Vec<_> = bounds.collect();
    if !bounds.is_empty() {
        let told = kept.get("description").and_then(Value::as_str);
        let told = told.map(|d| format!("{d} ")).unwrap_or_default();
        kept.insert(
            "description".into(),
            json!(format!("{told}({})", bounds.join(", "))),
        );
    }
    if let Some(Value::Object(properties)) = kept.get("properties") {
        let names: Vec<_> = properties.keys().cloned().collect();
        kept.insert("required".into(), json!(names));
        kept.insert("additionalProperties".into(), json!(false));
    }
    Value::Object(kept)
}

/// Numbers that are listed at most.
const MOST_LISTED: i64 = 16;

/// All values of a whole number with narrow bounds.
fn few(schema: &Map<String, Value>) -> Option<Value> {
    let bound = |key: &str| schema.get(key)?.as_i64();
    let (least, most) = (bound("minimum")?, bound("maximum")?);
    let is_few = (0..MOST_LISTED).contains(&most.saturating_sub(least));
    let is_whole = schema.get("type")?.as_str()? == "integer";
    let is_new = !schema.contains_key("enum");
    (is_few && is_whole && is_new).then(|| (least..=most).collect())
}

/// A schema's name as it may stand on the wire: 64 letters, digits, `_` and `-`.
pub(super) fn name(name: &str) -> String {
    let fits = |c: char| {
        let known = c.is_ascii_alphanumeric() || matches!(c, '_' | '-');
        if known { c } else { '_' }
    };
    name.chars().map(fits).take(64).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_not_everybody_knows_becomes_words() {
        let full = json!({
            "$schema": "https://json-schema.org/draft/2020-12/schema",
            "title": "Verdict",
            "type": "object",
            "properties": {
                "minimum": {"type": "integer", "format": "uint8", "minimum": 0, "maximum": 5, "description": "The risk."},
                "name": {"type": ["string", "null"], "pattern": "^a", "default": ""},
                "list": {"type": "array", "minItems": 1, "items": {"type": "object", "properties": {"x": {"oneOf": [
                    {"type": "number", "exclusiveMinimum": 0.5}, {"enum": ["minimum"]},
                ]}}}},
            },
            "required": ["name"],
        });
        assert_eq!(
            portable(&full),
            json!({
                "type": "object",
                "properties": {
                    "minimum": {"type": "integer", "description": "The risk.", "enum": [0, 1, 2, 3, 4, 5]},
                    "name": {"type": ["string", "null"], "description": "(of the form ^a)"},
                    "list": {"type": "array", "description": "(items at least 1)", "items": {
                        "type": "object",
                        "properties": {"x": {"anyOf": [
                            {"type": "number", "description": "(more than 0.5)"}, {"enum": ["minimum"]},
                        ]}},
                        "required": ["x"],
                        "additionalProperties": false,
                    }},
                },
                "required": ["minimum", "name", "list"],
                "additionalProperties": false,
            })
        );
        assert_eq!(portable(&portable(&full)), portable(&full));
    }
}
