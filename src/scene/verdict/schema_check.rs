//! Holds an answer against the schema that was sent with its question: the keywords that our schemas have, no others.

use serde_json::Value;

/// Where a value departs from a schema: places as JSON pointers, and what is wrong there, without the values, which may
/// be long.
pub(super) fn departures(schema: &Value, value: &Value) -> Vec<(String, String)> {
    let mut found = Vec::new();
    check(schema, value, "", &mut found);
    found
}

fn check(schema: &Value, value: &Value, place: &str, found: &mut Vec<(String, String)>) {
    let mut wrong = |what: String| found.push((place.to_string(), what));
    let types = match &schema["type"] {
        Value::Array(several) => several.iter().filter_map(Value::as_str).collect(),
        one => one.as_str().into_iter().collect::<Vec<_>>(),
    };
    if !types.is_empty() && !types.iter().any(|name| is_of_type(value, name)) {
        return wrong(format!("is not of type {}", types.join(" or ")));
    }
    if schema["enum"]
        .as_array()
        .is_some_and(|all| !all.contains(value))
    {
        wrong("is none of the values of the schema".into());
    }
    if let Some(number) = value.as_f64() {
        if let Some(least) = schema["minimum"].as_f64().filter(|least| number < *least) {
            wrong(format!("is less than {least}"));
        }
        if let Some(most) = schema["maximum"].as_f64().filter(|most| number > *most) {
            wrong(format!("is more than {most}"));
        }
    }
    match value {
        Value::Object(object) => {
            for key in schema["required"]
                .as_array()
                .into_iter()
                .flatten()
                .filter_map(Value::as_str)
            {
                if !object.contains_key(key) {
                    wrong(format!("has no `{key}`"));
                }
            }
            for (key, value) in object {
                match schema["properties"].get(key) {
                    Some(schema) => check(schema, value, &format!("{place}/{key}"), found),
                    None if schema["additionalProperties"] == false => {
                        found.push((place.into(), "has keys that the schema has not".into()));
                    }
                    None => {}
                }
            }
        }
        Value::Array(items) => {
            for (number, item) in items.iter().enumerate() {
                check(&schema["items"], item, &format!("{place}/{number}"), found);
            }
        }
        _ => {}
    }
}

fn is_of_type(value: &Value, name: &str) -> bool {
    match name {
        "object" => value.is_object(),
        "array" => value.is_array(),
        "string" => value.is_string(),
        "boolean" => value.is_boolean(),
        "null" => value.is_null(),
        "number" => value.is_number(),
        // Also 3.0, as the standard says.
        "integer" => value.is_i64() || value.as_f64().is_some_and(|n| n.fract() == 0.0),
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Task, schema};
    use super::*;
    use serde_json::json;

    /// Keywords that are checked, or say nothing about validity.
    const KNOWN: [&str; 12] = [
        "type",
        "enum",
        "minimum",
        "maximum",
        "required",
        "properties",
        "additionalProperties",
        "items",
        "title",
        "description",
        "format",
        "default",
    ];

    fn keywords(schema: &Value, found: &mut Vec<String>) {
        for (key, value) in schema.as_object().into_iter().flatten() {
            found.push(key.clone());
            match key.as_str() {
                "properties" => value
                    .as_object()
                    .into_iter()
                    .flatten()
                    .for_each(|(_, one)| keywords(one, found)),
                "items" => keywords(value, found),
                _ => {}
            }
        }
    }

    #[test]
    fn every_keyword_of_our_schemas_is_known() {
        for task in Task::ALL {
            let mut found = Vec::new();
            keywords(&schema(task), &mut found);
            assert!(found.len() > 10, "{task:?}");
            for key in found {
                assert!(KNOWN.contains(&key.as_str()), "{task:?}: {key}");
            }
        }
    }

    #[test]
    fn departures_are_named_with_their_places() {
        let schema = json!({
            "type": "object",
            "properties": {
                "a": {"type": "integer", "minimum": 0, "maximum": 5, "enum": [0, 1, 2, 6]},
                "b": {"type": ["array", "null"], "items": {"type": "string"}},
            },
            "required": ["a", "b"],
            "additionalProperties": false,
        });
        let found = |value: Value| -> Vec<String> {
            let all = departures(&schema, &value).into_iter();
            all.map(|(place, what)| format!("{place}: {what}"))
                .collect()
        };
        for fine in [json!({"a": 1, "b": ["x"]}), json!({"a": 2, "b": null})] {
            assert_eq!(found(fine), [""; 0]);
        }
        assert_eq!(found(json!([])), [": is not of type object"]);
        assert_eq!(
            found(json!({"a": 1.5, "b": []})),
            ["/a: is not of type integer"]
        );
        assert_eq!(found(json!({"a": 6, "b": []})), ["/a: is more than 5"]);
        assert_eq!(
            found(json!({"a": -1, "b": [1]})),
            [
                "/a: is none of the values of the schema",
                "/a: is less than 0",
                "/b/0: is not of type string"
            ]
        );
        assert_eq!(
            found(json!({"a": 0, "c": 1})),
            [": has no `b`", ": has keys that the schema has not"]
        );
    }
}
