//! Structured answers requested from models, their JSON schemas, and whether an answer holds to one.

use std::collections::BTreeMap;
use std::sync::OnceLock;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::parsed_answer::Notes;
use super::trajectory::TrajectoryAnswer;
use super::values::Object;
use super::{AttackerChoice, CriticalObstacle, ObstacleRisk, Task, Verdict};

/// The answer to the collision task.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct CollisionAnswer {
    /// Why, with times and numbers, before you decide.
    pub justification: String,
    /// The obstacles that matter, most dangerous first.
    pub obstacles: Vec<ObstacleRisk>,
    /// The obstacles that touch the ego, the first contact first; empty if none does.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Vec<CriticalObstacle>")]
    pub critical_obstacles: Option<Vec<CriticalObstacle>>,
    /// The probability that the ego collides, 0 to 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "f64", range(min = 0.0, max = 1.0))]
    pub probability: Option<f64>,
    /// Whether the ego collides.
    pub collision: bool,
}

/// The answer to the safety task.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct SafetyAnswer {
    /// Why, with times and numbers, before you decide.
    pub justification: String,
    /// The obstacles that matter, most dangerous first.
    pub obstacles: Vec<ObstacleRisk>,
    /// The obstacles that touch the ego within the horizon with a probability of 0.5 or more, most critical first; empty
    /// if none does.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Vec<CriticalObstacle>")]
    pub critical_obstacles: Option<Vec<CriticalObstacle>>,
    /// The probability that the ego touches another body within the horizon, 0 to 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "f64", range(min = 0.0, max = 1.0))]
    pub probability: Option<f64>,
    /// Whether the scene is safety-critical: true if `probability` is 0.5 or more, else false.
    pub safety_critical: bool,
}

/// The answer to the recording task.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct RecordingAnswer {
    /// Why, with times and numbers, before you decide.
    pub justification: String,
    /// The obstacles that matter, each with its worst risk score, most dangerous first.
    pub obstacles: Vec<ObstacleRisk>,
    /// The obstacles of extreme risk or in contact at some time, the first one first; empty if there are none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Vec<CriticalObstacle>")]
    pub critical_obstacles: Option<Vec<CriticalObstacle>>,
    /// The probability that the recording is of high risk, 0 to 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "f64", range(min = 0.0, max = 1.0))]
    pub probability: Option<f64>,
    /// Whether the recording is of high risk: true if `probability` is 0.5 or more; else it is safe.
    pub high_risk: bool,
}

/// The verdict of an answer, whose yes or no is in this field.
macro_rules! verdicts {
    ($($answer:ident, $dangerous:ident, $task:expr;)+) => {$(
        impl From<$answer> for Verdict {
            fn from(answer: $answer) -> Self {
                Self {
                    task: $task,
                    dangerous: answer.$dangerous,
                    obstacles: answer.obstacles,
                    justification: answer.justification,
                    critical: answer.critical_obstacles,
                    probability: answer.probability,
                    token_probability: None,
                    unknown: Vec::new(),
                }
            }
        }
    )+};
}

verdicts! {
    CollisionAnswer, collision, Task::Collision;
    SafetyAnswer, safety_critical, Task::Safety;
    RecordingAnswer, high_risk, Task::Recording;
}

/// The same where obstacles can only have these ids; without any, ids are free.
#[must_use]
pub fn schema_with_ids(task: Task, ids: &[i64]) -> serde_json::Value {
    let mut schema = schema(task);
    if Task::VERDICTS.contains(&task) && !ids.is_empty() {
        for list in ["obstacles", "critical_obstacles"] {
            let id = schema.pointer_mut(&format!("/properties/{list}/items/properties/id"));
            if let Some(id) = id.and_then(serde_json::Value::as_object_mut) {
                id.insert("enum".into(), ids.into());
            }
        }
    }
    schema
}

/// The JSON schema of a task's answer, with every part in place (no `$ref`).
#[must_use]
pub fn schema(task: Task) -> serde_json::Value {
    let settings = schemars::generate::SchemaSettings::draft2020_12().with(|s| {
        s.inline_subschemas = true;
        s.meta_schema = None;
    });
    let generator = settings.into_generator();
    let schema = match task {
        Task::Collision => generator.into_root_schema_for::<CollisionAnswer>(),
        Task::Safety => generator.into_root_schema_for::<SafetyAnswer>(),
        Task::Recording => generator.into_root_schema_for::<RecordingAnswer>(),
        Task::Attacker => generator.into_root_schema_for::<AttackerChoice>(),
        Task::Trajectory => generator.into_root_schema_for::<TrajectoryAnswer>(),
    };
    let mut value = schema.to_value();
    require_all(&mut value);
    list_words(&mut value);
    value
}

/// Keys that are asked for and that older answers do not have.
const OPTIONAL_KEYS: [&str; 2] = ["critical_obstacles", "probability"];

/// The keywords of JSON Schema that say what is valid.
#[derive(Debug, Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
struct Validity {
    r#type: Option<Types>,
    r#enum: Option<Vec<Value>>,
    minimum: Option<f64>,
    maximum: Option<f64>,
    required: Vec<String>,
    properties: BTreeMap<String, Self>,
    additional_properties: Option<bool>,
    items: Option<Box<Self>>,
}

#[derive(Debug, Deserialize)]
#[serde(untagged)]
enum Types {
    One(String),
    Several(Vec<String>),
}

/// The schema of a task, as answers are held against it.
fn kept_schema(task: Task) -> &'static Validity {
    static ALL: OnceLock<BTreeMap<Task, Validity>> = OnceLock::new();
    let all = ALL.get_or_init(|| {
        let make = |task| {
            let mut kept: Validity = serde_json::from_value(schema(task)).unwrap_or_default();
            kept.required
                .retain(|key| !OPTIONAL_KEYS.contains(&key.as_str()));
            (task, kept)
        };
        Task::ALL.map(make).into()
    });
    &all[&task]
}

/// Whether an answer keeps to the schema of its task.
pub(super) fn is_valid(task: Task, answer: &serde_json::Value) -> bool {
    departures(kept_schema(task), answer).is_empty()
}

/// Most violations that are named.
const MAX_LISTED: usize = 3;

/// Names where an answer departs from the schema of its task.
pub(super) fn violations(task: Task, answer: &Object, notes: &mut Notes) {
    let value = serde_json::Value::Object(answer.clone());
    for (place, what) in departures(kept_schema(task), &value)
        .into_iter()
        .take(MAX_LISTED)
    {
        let place = if place.is_empty() {
            "the object"
        } else {
            &place
        };
        notes.add(format!("against the schema, {place}: {what}"));
    }
}

fn require_all(value: &mut serde_json::Value) {
    match value {
        serde_json::Value::Object(map) => {
            if let Some(properties) = map.get("properties").and_then(|p| p.as_object()) {
                let names = properties
                    .keys()
                    .cloned()
                    .map(serde_json::Value::String)
                    .collect();
                map.insert("required".into(), serde_json::Value::Array(names));
            }
            map.values_mut().for_each(require_all);
        }
        serde_json::Value::Array(items) => items.iter_mut().for_each(require_all),
        _ => {}
    }
}

/// Makes a choice between constants an `enum`, which more servers know, and keeps what the constants mean in words.
fn list_words(value: &mut serde_json::Value) {
    match value {
        serde_json::Value::Object(map) => {
            if let Some(serde_json::Value::Array(choices)) = map.shift_remove("oneOf") {
                let text = |choice: &serde_json::Value, key: &str| {
                    choice[key].as_str().unwrap_or_default().to_string()
                };
                let explained = choices
                    .iter()
                    .map(|c| format!("{}: {}", text(c, "const"), text(c, "description")));
                let meant = map
                    .get("description")
                    .and_then(|d| d.as_str())
                    .unwrap_or_default();
                let description = format!("{meant} {}", explained.collect::<Vec<_>>().join(" "));
                map.insert("type".into(), "string".into());
                let words: Vec<_> = choices
                    .iter()
                    .filter_map(|c| c.get("const").cloned())
                    .collect();
                map.insert("enum".into(), words.into());
                map.insert("description".into(), description.trim().into());
            }
            map.values_mut().for_each(list_words);
        }
        serde_json::Value::Array(items) => items.iter_mut().for_each(list_words),
        _ => {}
    }
}

/// Where a value departs from a schema: places as JSON pointers, and what is wrong there, without the values, which may
/// be long.
fn departures(schema: &Validity, value: &Value) -> Vec<(String, String)> {
    let mut found = Vec::new();
    check(schema, value, "", &mut found);
    found
}

fn check(schema: &Validity, value: &Value, place: &str, found: &mut Vec<(String, String)>) {
    let mut wrong = |what: String| found.push((place.to_string(), what));
    let types = match &schema.r#type {
        None => &[][..],
        Some(Types::One(one)) => std::slice::from_ref(one),
        Some(Types::Several(several)) => several,
    };
    if !types.is_empty() && !types.iter().any(|name| is_of_type(value, name)) {
        return wrong(format!("is not of type {}", types.join(" or ")));
    }
    if schema
        .r#enum
        .as_ref()
        .is_some_and(|all| !all.contains(value))
    {
        wrong("is none of the values of the schema".into());
    }
    if let Some(number) = value.as_f64() {
        if let Some(least) = schema.minimum.filter(|least| number < *least) {
            wrong(format!("is less than {least}"));
        }
        if let Some(most) = schema.maximum.filter(|most| number > *most) {
            wrong(format!("is more than {most}"));
        }
    }
    match value {
        Value::Object(object) => {
            for key in schema
                .required
                .iter()
                .filter(|key| !object.contains_key(*key))
            {
                wrong(format!("has no `{key}`"));
            }
            for (key, value) in object {
                match schema.properties.get(key) {
                    Some(schema) => check(schema, value, &format!("{place}/{key}"), found),
                    None if schema.additional_properties == Some(false) => {
                        found.push((place.into(), "has keys that the schema has not".into()));
                    }
                    None => {}
                }
            }
        }
        Value::Array(items) => {
            let Some(schema) = &schema.items else { return };
            for (number, item) in items.iter().enumerate() {
                check(schema, item, &format!("{place}/{number}"), found);
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

    #[test]
    fn every_schema_is_portable() {
        for task in Task::ALL {
            let text = schema(task).to_string();
            assert!(!text.contains("$ref") && !text.contains("oneOf"), "{text}");
        }
        let kind = &schema(Task::Trajectory)["properties"]["manoeuvre"]["properties"]["kind"];
        assert_eq!(kind["enum"][0], "cut-in");
        assert_eq!(kind["enum"].as_array().map(Vec::len), Some(7));
    }

    #[test]
    fn reasons_come_first_and_the_decision_last() {
        for task in Task::VERDICTS {
            let schema = schema(task);
            let keys: Vec<&String> = schema["properties"]
                .as_object()
                .into_iter()
                .flat_map(|o| o.keys())
                .collect();
            assert_eq!(
                keys[..4],
                [
                    "justification",
                    "obstacles",
                    "critical_obstacles",
                    "probability"
                ]
            );
            assert_eq!(keys[4..], [task.key()]);
            let critical = &schema["properties"]["critical_obstacles"]["items"];
            assert_eq!(
                critical["required"],
                serde_json::json!(["id", "probability"])
            );
            for probability in [&schema["properties"], &critical["properties"]] {
                let probability = &probability["probability"];
                assert_eq!(probability["type"], "number");
                assert_eq!(probability["maximum"], 1.0);
            }
        }
    }

    #[test]
    fn the_schema_is_strict_and_inline() {
        let schema = schema(Task::Collision);
        let text = schema.to_string();
        assert!(!text.contains("$ref"), "{text}");
        assert_eq!(schema["required"].as_array().map(Vec::len), Some(5));
        assert_eq!(schema["additionalProperties"], false);
        let obstacle = &schema["properties"]["obstacles"]["items"];
        assert_eq!(obstacle["required"].as_array().map(Vec::len), Some(3));
        assert_eq!(obstacle["additionalProperties"], false);
    }

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
            assert!(serde_json::from_value::<Validity>(schema(task)).is_ok());
            assert!(found.len() > 10, "{task:?}");
            for key in found {
                assert!(KNOWN.contains(&key.as_str()), "{task:?}: {key}");
            }
        }
    }

    #[test]
    fn departures_are_named_with_their_places() {
        let schema = serde_json::from_value(json!({
            "type": "object",
            "properties": {
                "a": {"type": "integer", "minimum": 0, "maximum": 5, "enum": [0, 1, 2, 6]},
                "b": {"type": ["array", "null"], "items": {"type": "string"}},
            },
            "required": ["a", "b"],
            "additionalProperties": false,
        }))
        .unwrap_or_default();
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
