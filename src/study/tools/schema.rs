//! JSON schemas and documentation of tools, made from the table.

use serde_json::{Map, Value, json};

use super::{Argument, ArgumentKind, Tool};

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
