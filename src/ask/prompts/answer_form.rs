//! Describes the form of an answer from its JSON schema, so that prompt and schema cannot disagree.

use serde_json::Value;

/// The answer as a person would write it down: the keys of the JSON, with what goes there in angle brackets.
///
/// Alternatives of a whole answer stand one below the other, divided by a line that says `or`. What this does
/// not know of JSON schema stands there as it is.
#[must_use]
pub fn answer_form(schema: &Value) -> String {
    match alternatives(schema) {
        Some(several) if several.iter().all(|s| s.get("properties").is_some()) => {
            let forms: Vec<String> = several.iter().map(|s| form(s, 0)).collect();
            forms.join("\nor\n")
        }
        _ => form(schema, 0),
    }
}

/// A line for each key that the schema describes: `` - `obstacles[].id`: … ``.
#[must_use]
pub fn answer_keys(schema: &Value) -> String {
    let mut lines = Vec::new();
    keys(schema, "", &mut lines);
    lines.join("\n")
}

fn alternatives(schema: &Value) -> Option<&Vec<Value>> {
    let several = ["anyOf", "oneOf"].iter().find_map(|k| schema.get(k));
    several.and_then(Value::as_array)
}

fn form(schema: &Value, depth: usize) -> String {
    if let Some(properties) = schema.get("properties").and_then(Value::as_object) {
        let indent = "  ".repeat(depth + 1);
        let lines: Vec<String> = properties
            .iter()
            .map(|(key, value)| format!("{indent}{}: {}", quoted(key), form(value, depth + 1)))
            .collect();
        let object = format!("{{\n{}\n{}}}", lines.join(",\n"), "  ".repeat(depth));
        return or_null(schema, object);
    }
    if let Some(items) = schema.get("items") {
        return or_null(schema, format!("[{}, …]", form(items, depth)));
    }
    if let Some(several) = alternatives(schema) {
        let forms: Vec<String> = several.iter().map(|s| form(s, depth)).collect();
        return forms.join(" or ");
    }
    if let Some(constant) = schema.get("const") {
        return constant.to_string();
    }
    if let Some(values) = schema.get("enum").and_then(Value::as_array) {
        let values: Vec<String> = values.iter().map(Value::to_string).collect();
        return values.join(" or ");
    }
    match types(schema) {
        Some(types) if !types.is_empty() => {
            let words = types.iter().filter(|t| **t != "null");
            let words: Vec<String> = words.map(|t| type_label(t, schema)).collect();
            if words.is_empty() {
                "null".into()
            } else {
                or_null(schema, format!("<{}>", words.join(" or ")))
            }
        }
        _ => schema.to_string(),
    }
}

fn or_null(schema: &Value, form: String) -> String {
    match types(schema) {
        Some(types) if types.contains(&"null") => form + " or null",
        _ => form,
    }
}

fn types(schema: &Value) -> Option<Vec<&str>> {
    match schema.get("type")? {
        Value::String(one) => Some(vec![one]),
        Value::Array(several) => several.iter().map(Value::as_str).collect(),
        _ => None,
    }
}

fn type_label(name: &str, schema: &Value) -> String {
    let noun = match name {
        "boolean" => return "true or false".into(),
        "string" => return "text".into(),
        "integer" => "whole number",
        other => other,
    };
    let bound = |key: &str| schema.get(key).filter(|b| b.is_number());
    match (bound("minimum"), bound("maximum")) {
        (Some(low), Some(high)) => format!("{noun} from {low} to {high}"),
        (Some(low), None) => format!("{noun}, at least {low}"),
        (None, Some(high)) => format!("{noun}, at most {high}"),
        (None, None) => noun.into(),
    }
}

fn keys(schema: &Value, path: &str, lines: &mut Vec<String>) {
    if let Some(properties) = schema.get("properties").and_then(Value::as_object) {
        for (key, value) in properties {
            let below = if path.is_empty() {
                key.clone()
            } else {
                format!("{path}.{key}")
            };
            add_description(&format!("`{below}`"), value, lines);
            keys(value, &below, lines);
        }
    }
    if let Some(items) = schema.get("items") {
        keys(items, &format!("{path}[]"), lines);
    }
    for one in alternatives(schema).into_iter().flatten() {
        if let Some(constant) = one.get("const") {
            add_description(&format!("`{path}` {constant}"), one, lines);
        }
        keys(one, path, lines);
    }
}

fn add_description(what: &str, schema: &Value, lines: &mut Vec<String>) {
    if let Some(words) = schema.get("description").and_then(Value::as_str) {
        let line = format!(
            "- {what}: {}",
            words.split_whitespace().collect::<Vec<_>>().join(" ")
        );
        if !lines.contains(&line) {
            lines.push(line);
        }
    }
}

fn quoted(key: &str) -> String {
    Value::from(key).to_string()
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn an_object_with_a_list() {
        let schema = json!({
            "type": "object",
            "properties": {
                "yes": {"type": "boolean", "description": "Whether\nit is."},
                "list": {"type": "array", "items": {
                    "type": "object",
                    "properties": {
                        "score": {"type": "integer", "minimum": 0, "maximum": 5, "description": "How bad."},
                        "kind": {"oneOf": [
                            {"const": "a", "description": "The first."}, {"const": "b"}
                        ]},
                    },
                }},
                "why": {"type": ["string", "null"]},
            },
        });
        assert_eq!(
            answer_form(&schema),
            "{\n  \"yes\": <true or false>,\n  \"list\": [{\n    \"score\": <whole number from 0 to 5>,\n    \
             \"kind\": \"a\" or \"b\"\n  }, …],\n  \"why\": <text> or null\n}"
        );
        assert_eq!(
            answer_keys(&schema),
            "- `yes`: Whether it is.\n- `list[].score`: How bad.\n- `list[].kind` \"a\": The first."
        );
    }

    #[test]
    fn alternatives_stand_below_each_other_and_what_is_unknown_as_it_is() {
        let one = |key: &str| json!({"type": "object", "properties": {key: {"type": "number"}}});
        let schema = json!({"anyOf": [one("a"), one("b")]});
        assert_eq!(
            answer_form(&schema),
            "{\n  \"a\": <number>\n}\nor\n{\n  \"b\": <number>\n}"
        );
        assert_eq!(answer_form(&json!({"not": {}})), "{\"not\":{}}");
    }
}
