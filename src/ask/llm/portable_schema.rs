//! JSON schemas reduced to the subset every provider supports, the rest moved to descriptions.

use serde_json::{Map, Value};

/// Keywords that mean the same everywhere.
const PORTABLE_KEYWORDS: [&str; 12] = [
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
const BOUND_KEYWORDS: [(&str, &str); 9] = [
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

/// Characters of a text that a bounded schema allows where it names no bound: a small model that repeats itself comes to an
/// end. llama.cpp takes no more repetitions than 2000.
const MAX_TEXT_LENGTH: u64 = 2000;

/// The same of a text in a list.
const MAX_LISTED_LENGTH: u64 = 400;

/// Elements of a list, likewise.
const MAX_ELEMENTS: u64 = 16;

/// The schema in the subset that every API with structured output accepts: all properties required, no others allowed,
/// and bounds moved to descriptions. The reader of an answer must validate it against the full schema.
pub(super) fn portable(schema: &Value) -> Value {
    reduced(schema, None)
}

/// The same with its bounds, and with bounds of all texts and lists.
pub(super) fn bounded(schema: &Value) -> Value {
    reduced(schema, Some(MAX_TEXT_LENGTH))
}

/// With the bounds, where texts are bounded to so many characters.
fn reduced(schema: &Value, longest: Option<u64>) -> Value {
    let portable = |part: &Value| reduced(part, longest);
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
            ("items", part) => reduced(part, longest.map(|_| MAX_LISTED_LENGTH)),
            ("anyOf" | "oneOf" | "prefixItems", Value::Array(parts)) => {
                parts.iter().map(portable).collect()
            }
            (key, value) if PORTABLE_KEYWORDS.contains(&key) => value.clone(),
            (key, value)
                if longest.is_some() && BOUND_KEYWORDS.iter().any(|(bound, _)| *bound == key) =>
            {
                value.clone()
            }
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
    if let Some(longest) = longest {
        bound(&mut kept, longest);
    }
    let bounds = BOUND_KEYWORDS
        .iter()
        .filter(|_| few.is_none())
        .filter_map(|(key, word)| {
            let bound = schema.get(*key)?;
            let bound = bound
                .as_str()
                .map_or_else(|| bound.to_string(), str::to_owned);
            Some(format!("{word} {bound}"))
        });
    let bounds: Vec<_> = bounds.collect();
    if !bounds.is_empty() {
        let told = kept
            .get("description")
            .and_then(Value::as_str)
            .map(|d| format!("{d} "))
            .unwrap_or_default();
        let described = format!("{told}({})", bounds.join(", "));
        kept.insert("description".into(), described.into());
    }
    if let Some(Value::Object(properties)) = kept.get("properties") {
        let names: Vec<_> = properties.keys().cloned().collect();
        kept.insert("required".into(), names.into());
        kept.insert("additionalProperties".into(), false.into());
    }
    Value::Object(kept)
}

/// Bounds a text or list that has no bound: a list by the ids that its elements can have, where these are listed.
fn bound(schema: &mut Map<String, Value>, longest: u64) {
    let ids = schema
        .get("items")
        .and_then(|items| items.pointer("/properties/id/enum"))
        .and_then(Value::as_array)
        .map(|ids| ids.len() as u64);
    let is_free = !schema.contains_key("enum") && !schema.contains_key("const");
    let (key, most) = match schema.get("type").and_then(Value::as_str) {
        Some("string") if is_free => ("maxLength", longest),
        Some("array") => ("maxItems", ids.unwrap_or(MAX_ELEMENTS).min(MAX_ELEMENTS)),
        _ => return,
    };
    schema.entry(key).or_insert_with(|| most.into());
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
    use serde_json::json;

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

    #[test]
    fn what_a_server_here_gets_comes_to_an_end() {
        let full = json!({"type": "object", "properties": {
            "why": {"type": "string"},
            "p": {"type": "number", "minimum": 0.0, "maximum": 1.0},
            "names": {"type": "array", "maxItems": 2, "items": {"type": "string", "maxLength": 9}},
            "whys": {"type": "array", "items": {"type": "string"}},
            "list": {"type": "array", "items": {"type": "object", "properties": {
                "id": {"type": "integer", "enum": [7, 9, 12]}, "kind": {"enum": ["a", "b"]},
            }}},
        }});
        let sent = bounded(&full);
        let at = |place: &str| sent.pointer(place).cloned().unwrap_or_default();
        assert_eq!(at("/properties/why/maxLength"), 2000);
        assert_eq!(at("/properties/whys/items/maxLength"), 400);
        assert_eq!(at("/properties/p/maximum"), 1.0);
        assert_eq!(at("/properties/names/maxItems"), 2);
        assert_eq!(at("/properties/names/items/maxLength"), 9);
        assert_eq!(
            at("/properties/list/maxItems"),
            3,
            "as many as there are ids"
        );
        assert_eq!(
            at("/properties/list/items/properties/kind/maxLength"),
            Value::Null
        );
        assert_eq!(portable(&full).pointer("/properties/why/maxLength"), None);
    }
}
