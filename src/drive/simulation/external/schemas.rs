//! JSON schemas of the messages of the planner protocol.

use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use serde_json::{Value, json};

use super::protocol::{Bye, Hello, PlanMessage, Ready, Refusal, Trajectory};

/// A message: its name, what it is, and its schema without the type.
type Described = (&'static str, &'static str, fn() -> Value);

/// The names of the messages with what each is, in the order of a drive.
const MESSAGES: [Described; 6] = [
    (
        "hello",
        "nearmiss to the planner, once a drive",
        schema::<Hello<'static>>,
    ),
    ("ready", "the planner's answer to `hello`", answer::<Ready>),
    (
        "plan",
        "nearmiss to the planner, each cycle",
        schema::<PlanMessage>,
    ),
    (
        "trajectory",
        "the planner's answer to `plan`",
        answer::<Trajectory>,
    ),
    (
        "error",
        "the planner has no trajectory, or cannot drive",
        answer::<Refusal>,
    ),
    ("bye", "nearmiss to the planner: the end", schema::<Bye>),
];

/// The messages of the protocol by name, each with what it is.
pub fn planner_message_names() -> impl Iterator<Item = (&'static str, &'static str)> {
    MESSAGES.iter().map(|(name, about, _)| (*name, *about))
}

/// The JSON schema of a message of the protocol.
#[must_use]
pub fn planner_message_schema(name: &str) -> Option<Value> {
    let (name, _, schema) = MESSAGES.iter().find(|(known, ..)| *known == name)?;
    let mut schema = schema();
    // The type of a message is said by its tag, which is no field of it.
    let mut properties = serde_json::Map::new();
    properties.insert("type".into(), json!({ "const": name }));
    if let Some(fields) = schema["properties"].as_object() {
        properties.extend(fields.clone());
    }
    schema["properties"] = Value::Object(properties);
    let mut required = vec![json!("type")];
    required.extend(schema["required"].as_array().cloned().unwrap_or_default());
    schema["required"] = Value::Array(required);
    Some(schema)
}

fn schema<T: JsonSchema>() -> Value {
    of::<T>(SchemaSettings::draft2020_12().for_serialize())
}

fn answer<T: JsonSchema>() -> Value {
    of::<T>(SchemaSettings::draft2020_12().for_deserialize())
}

fn of<T: JsonSchema>(settings: SchemaSettings) -> Value {
    let settings = settings.with(|s| s.inline_subschemas = true);
    settings
        .into_generator()
        .into_root_schema_for::<T>()
        .to_value()
}
