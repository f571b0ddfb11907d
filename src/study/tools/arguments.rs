//! Arguments of tools: the types of ids, reading what a model wrote, JSON schema and documentation.

use nearmiss_record::fields::{FieldValue, Fields, Takes, Wrong};
use serde_json::{Map, Value, json};
use toml::Value as Toml;

use super::Tool;

/// Why a call has no result, in words that the model reads.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct ToolError(String);

impl ToolError {
    /// An error with this message.
    pub(super) fn new(message: impl Into<String>) -> Self {
        Self(message.into())
    }
}

/// An id, and what is expected where there is none.
macro_rules! ids {
    ($($(#[$of:meta])* $name:ident, $read:expr, $expected:literal;)+) => {$(
        $(#[$of])*
        #[derive(Debug, Clone, Copy, PartialEq, Default)]
        pub struct $name(pub i64);

        impl FieldValue for $name {
            fn read(value: &Toml, _: &Takes) -> Result<Self, Wrong> {
                $read(value).map(Self).ok_or(Wrong::kind())
            }

            fn write(&self) -> Option<Toml> {
                Some(self.0.into())
            }

            fn describe(_: &Takes) -> (String, Value) {
                ($expected.into(), json!({ "type": "integer" }))
            }
        }
    )+};
}

ids! {
    /// The id of an obstacle.
    ObstacleId, parse_id, "the id of an obstacle, such as 304";
    /// The id of an obstacle, or 0 for the ego.
    ParticipantId, parse_participant, "the id of an obstacle, or 0 for the ego";
}

fn parse_participant(value: &Toml) -> Option<i64> {
    match value.as_str().map(str::trim) {
        Some("ego") => Some(0),
        _ => parse_id(value),
    }
}

/// An id as a number, as a whole float, or as text, as it is in descriptions.
fn parse_id(value: &Toml) -> Option<i64> {
    match value {
        Toml::Integer(id) => Some(*id),
        Toml::Float(id) => (id.fract() == 0.0 && id.abs() < 9e15).then_some(*id as i64),
        Toml::String(text) => text.trim().parse().ok(),
        _ => None,
    }
}

/// Most bytes that arguments may have: the tools need far fewer.
const MAX_BYTES: usize = 16 << 10;

/// Reads a JSON object; nothing, as models write it for tools without required arguments, is an empty one.
///
/// # Errors
/// It is no object, or an argument is unknown, missing, or not as expected.
pub(super) fn parse<A: Fields>(text: &str) -> Result<A, ToolError> {
    if text.len() > MAX_BYTES {
        return Err(ToolError::new(format!(
            "the arguments have {} bytes; at most {MAX_BYTES} are read",
            text.len()
        )));
    }
    let text = match text.trim() {
        "" => "{}",
        text => text,
    };
    let value: Value = serde_json::from_str(text)
        .map_err(|why| ToolError::new(format!("the arguments are no JSON: {why}")))?;
    let mut given = match value {
        Value::Object(map) => map,
        Value::Null => Map::new(),
        _ => return Err(ToolError::new("the arguments are no JSON object")),
    };
    // Some models write null for what they leave out.
    given.retain(|_, value| !value.is_null());
    let names = || A::rows().iter().map(|row| row.key);
    for name in given.keys() {
        if !names().any(|known| known == name) {
            let name: String = name.chars().take(64).collect();
            return Err(ToolError::new(nearmiss_base::system::unknown(
                "argument",
                &name,
                names(),
            )));
        }
    }
    let mut arguments = A::default();
    for row in A::rows() {
        let Some(value) = given.get(row.key) else {
            if row.is("required") {
                let (name, about) = (row.key, row.doc());
                return Err(ToolError::new(format!(
                    "argument `{name}` is missing: {about}"
                )));
            }
            continue;
        };
        let read = Toml::try_from(value).ok();
        if read.is_none_or(|value| arguments.set(row.key, &value).is_err()) {
            let got: String = value.to_string().chars().take(80).collect();
            return Err(ToolError::new(format!(
                "argument `{}` is {got}; {}",
                row.key,
                row.expected()
            )));
        }
    }
    Ok(arguments)
}

/// The JSON schema of arguments, with their units.
pub(super) fn schema<A: Fields>() -> Value {
    let mut schema = A::json_schema();
    for row in A::rows() {
        let place = format!("/properties/{}/description", row.key);
        if let Some(about) = schema.pointer_mut(&place) {
            *about = with_unit(row.doc(), row.unit).into();
        }
    }
    schema
}

fn with_unit(about: &str, unit: &str) -> String {
    match unit {
        "" => about.to_string(),
        unit => format!("{about} [{unit}]"),
    }
}

/// Arguments and result of a tool as lists.
pub(super) fn lines(tool: &Tool) -> String {
    let mut text = "\nArguments:\n\n".to_string();
    for argument in (tool.arguments)() {
        let needed = if argument.is("required") {
            ", required"
        } else {
            ""
        };
        let about = with_unit(argument.doc(), argument.unit);
        text.push_str(&format!("- `{}`{needed}: {about}\n", argument.key));
    }
    text.push_str("\nResult:\n\n");
    list_fields(&(tool.result_schema)(), "", &mut text);
    text
}

/// The fields of a result, those of the objects of its lists below them.
fn list_fields(schema: &Value, indent: &str, text: &mut String) {
    let fields = schema.get("properties").and_then(Value::as_object);
    for (name, field) in fields.into_iter().flatten() {
        let words = |key| field.get(key).and_then(Value::as_str).unwrap_or_default();
        let about = with_unit(words("description"), words("unit"));
        text.push_str(&format!("{indent}- `{name}`: {about}\n"));
        if let Some(objects) = field.get("items") {
            list_fields(objects, "  ", text);
        }
    }
}
