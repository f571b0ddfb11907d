//! Arguments of tools: what is expected, as JSON schema and documentation, and reading what a model wrote.

use serde_json::{Map, Value, json};

use super::Tool;

/// Kinds of argument.
#[derive(Debug, Clone, Copy)]
pub enum ArgumentKind {
    /// A number between two bounds, ends included.
    Number(f64, f64),
    /// The id of an obstacle.
    Obstacle,
    /// The id of an obstacle, or 0 for the ego.
    Participant,
    /// One of some words.
    Word(fn() -> Vec<&'static str>),
}

/// An argument of a tool.
#[derive(Debug, Clone, Copy)]
pub struct Argument {
    /// Its name.
    pub name: &'static str,
    /// What is expected.
    pub kind: ArgumentKind,
    /// Its unit; empty for ids and words.
    pub unit: &'static str,
    /// Whether it may not be left out.
    pub required: bool,
    /// What it means, and what holds where it is left out.
    pub about: &'static str,
}

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

/// The arguments of one call, checked.
#[derive(Debug, Clone, Default)]
pub struct Arguments(Map<String, Value>);

/// Most bytes that arguments may have: the tools need far fewer.
const MAX_BYTES: usize = 16 << 10;

impl Arguments {
    /// Reads a JSON object; nothing, as models write it for tools without required arguments, is an empty one.
    ///
    /// # Errors
    /// It is no object, or an argument is unknown, missing, or not as expected.
    pub fn parse(text: &str, expected: &[Argument]) -> Result<Self, ToolError> {
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
        Self::from_value(value, expected)
    }

    /// Takes over a JSON value.
    ///
    /// # Errors
    /// As [`Self::parse`].
    pub fn from_value(value: Value, expected: &[Argument]) -> Result<Self, ToolError> {
        let mut map = match value {
            Value::Object(map) => map,
            Value::Null => Map::new(),
            _ => return Err(ToolError::new("the arguments are no JSON object")),
        };
        // Some models write null for what they leave out.
        map.retain(|_, value| !value.is_null());
        let names = || expected.iter().map(|argument| argument.name);
        for name in map.keys() {
            if !names().any(|known| known == name) {
                let name: String = name.chars().take(64).collect();
                return Err(ToolError::new(match names().next() {
                    Some(_) => nearmiss_base::system::unknown("argument", &name, names()),
                    None => format!("unknown argument `{name}`; this tool has none"),
                }));
            }
        }
        for argument in expected {
            match map.get_mut(argument.name) {
                Some(value) => argument.check(value)?,
                None if argument.required => {
                    return Err(ToolError::new(format!(
                        "argument `{}` is missing: {}",
                        argument.name, argument.about
                    )));
                }
                None => {}
            }
        }
        Ok(Self(map))
    }

    /// A number.
    #[must_use]
    pub fn number(&self, name: &str) -> Option<f64> {
        self.0.get(name)?.as_f64()
    }

    /// An id.
    #[must_use]
    pub fn id(&self, name: &str) -> Option<i64> {
        self.0.get(name)?.as_i64()
    }

    /// A word.
    #[must_use]
    pub fn text(&self, name: &str) -> Option<&str> {
        self.0.get(name)?.as_str()
    }
}

impl Argument {
    /// Whether a value is as expected; ids written as text become numbers, as they are in descriptions.
    fn check(&self, value: &mut Value) -> Result<(), ToolError> {
        let wrong = |what: String| {
            let got: String = value.to_string().chars().take(80).collect();
            Err(ToolError::new(format!(
                "argument `{}` is {got}; expected {what}",
                self.name
            )))
        };
        match self.kind {
            ArgumentKind::Number(least, most) => match value.as_f64() {
                Some(number) if (least..=most).contains(&number) => Ok(()),
                _ => wrong(format!("a number from {least} to {most}{}", self.in_unit())),
            },
            ArgumentKind::Obstacle | ArgumentKind::Participant => {
                if let Some(id) = parse_id(value, matches!(self.kind, ArgumentKind::Participant)) {
                    *value = id.into();
                    return Ok(());
                }
                wrong(match self.kind {
                    ArgumentKind::Obstacle => "the id of an obstacle, such as 304".into(),
                    _ => "the id of an obstacle, or 0 for the ego".into(),
                })
            }
            ArgumentKind::Word(words) => match value.as_str() {
                Some(word) if words().contains(&word) => Ok(()),
                _ => wrong(format!("one of {}", words().join(", "))),
            },
        }
    }

    fn in_unit(&self) -> String {
        match self.unit {
            "" => String::new(),
            unit => format!(" {unit}"),
        }
    }
}

/// An id as a number, as a whole float, or as text; `ego` is 0 where the ego may be meant.
fn parse_id(value: &Value, ego: bool) -> Option<i64> {
    match value {
        Value::Number(number) => number.as_i64().or_else(|| {
            let whole = number
                .as_f64()
                .filter(|n| n.fract() == 0.0 && n.abs() < 9e15)?;
            Some(whole as i64)
        }),
        Value::String(text) if ego && text.trim() == "ego" => Some(0),
        Value::String(text) => text.trim().parse().ok(),
        _ => None,
    }
}

/// A field of a result.
#[derive(Debug, Clone, Copy)]
pub struct Field {
    /// Its name.
    pub name: &'static str,
    /// `number`, `integer`, `string`, `boolean` or, of objects with the fields that follow in `of`, `array`.
    pub kind: &'static str,
    /// Its unit; empty where it has none.
    pub unit: &'static str,
    /// What it means, and when it is missing.
    pub about: &'static str,
    /// The fields of the objects of an array.
    pub of: &'static [Field],
}

impl Field {
    /// A field that is no array.
    pub(super) const fn new(
        name: &'static str,
        kind: &'static str,
        unit: &'static str,
        about: &'static str,
    ) -> Self {
        let of = &[];
        Self {
            name,
            kind,
            unit,
            about,
            of,
        }
    }

    /// An array of objects.
    pub(super) const fn list(name: &'static str, about: &'static str, of: &'static [Self]) -> Self {
        let (kind, unit) = ("array", "");
        Self {
            name,
            kind,
            unit,
            about,
            of,
        }
    }

    fn schema(&self) -> Value {
        let about = with_unit(self.about, self.unit);
        match self.kind {
            "array" => json!({"type": "array", "description": about, "items": object(self.of)}),
            kind => json!({"type": kind, "description": about}),
        }
    }
}

impl Tool {
    /// The JSON schema of its arguments.
    #[must_use]
    pub fn arguments_schema(&self) -> Value {
        let properties = self.arguments.iter();
        let properties: Map<String, Value> = properties
            .map(|argument| (argument.name.to_string(), argument.schema()))
            .collect();
        let required = self.arguments.iter().filter(|argument| argument.required);
        let required: Vec<&str> = required.map(|argument| argument.name).collect();
        json!({
            "type": "object",
            "properties": properties,
            "required": required,
            "additionalProperties": false,
        })
    }

    /// The JSON schema of its result.
    #[must_use]
    pub fn result_schema(&self) -> Value {
        object(self.result)
    }
}

impl Argument {
    fn schema(&self) -> Value {
        let about = with_unit(self.about, self.unit);
        match self.kind {
            ArgumentKind::Number(least, most) => {
                json!({"type": "number", "description": about, "minimum": least, "maximum": most})
            }
            ArgumentKind::Obstacle | ArgumentKind::Participant => {
                json!({"type": "integer", "description": about})
            }
            ArgumentKind::Word(words) => {
                json!({"type": "string", "description": about, "enum": words()})
            }
        }
    }
}

fn with_unit(about: &str, unit: &str) -> String {
    match unit {
        "" => about.to_string(),
        unit => format!("{about} [{unit}]"),
    }
}

/// Fields may be missing where there is no value.
fn object(fields: &[Field]) -> Value {
    let properties = fields.iter();
    let properties: Map<String, Value> = properties
        .map(|field| (field.name.to_string(), field.schema()))
        .collect();
    json!({"type": "object", "properties": properties, "additionalProperties": false})
}

/// Arguments and result of a tool as lists.
pub(super) fn lines(tool: &Tool) -> String {
    let mut text = String::new();
    if !tool.arguments.is_empty() {
        text.push_str("\nArguments:\n\n");
    }
    for argument in tool.arguments {
        let needed = if argument.required { ", required" } else { "" };
        let about = with_unit(argument.about, argument.unit);
        text.push_str(&format!("- `{}`{needed}: {about}\n", argument.name));
    }
    text.push_str("\nResult:\n\n");
    for field in tool.result {
        text.push_str(&format!(
            "- `{}`: {}\n",
            field.name,
            with_unit(field.about, field.unit)
        ));
        for inner in field.of {
            let about = with_unit(inner.about, inner.unit);
            text.push_str(&format!("  - `{}`: {about}\n", inner.name));
        }
    }
    text
}
