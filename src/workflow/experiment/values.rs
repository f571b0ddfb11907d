//! What values the keys of experiment files have: in words for errors, and as JSON schemas.

use serde_json::{Value, json};

use super::keys::{ABOVE_ZERO, Values};
use nearmiss_study::evaluation::report::{Axis, Measure};

impl Values {
    /// Whether a single value stands for a list with one member.
    pub(super) fn takes_one(self) -> bool {
        matches!(
            self,
            Self::OneOrMoreWords(_)
                | Self::OneOrMoreWhole(..)
                | Self::OneOrMoreNumbers(..)
                | Self::OneOrMoreBooleans
        )
    }

    /// What is expected, for errors.
    pub(super) fn expected(&self) -> String {
        match self {
            Self::Text => "expected a text".into(),
            Self::Texts => "expected a list of texts".into(),
            Self::Word(known) => format!("expected one of {}", known().join(", ")),
            Self::Words(known) => format!("expected a list out of {}", known().join(", ")),
            Self::OneOrMoreWords(known) => {
                format!("expected one of {}, or a list of them", known().join(", "))
            }
            Self::OneOrMoreWhole(least, most) if *most == i64::MAX => {
                format!("expected a whole number from {least}, or a list of them")
            }
            Self::OneOrMoreWhole(least, most) => {
                format!("expected a whole number from {least} to {most}, or a list of them")
            }
            Self::OneOrMoreNumbers(least, most) => {
                format!("expected a number from {least} to {most}, or a list of them")
            }
            Self::TableOfTexts => "expected a table of names and hashes".into(),
            Self::Split => {
                "expected a table such as { test = 0.5, seed = 7 }, with a share above 0 and below 1".into()
            }
            Self::Tables => {
                "expected a list of tables such as { rows = \"techniques\", columns = \"model\" }, with measure and against \
                 if wanted"
                    .into()
            }
            Self::Pair => "expected a list of two different names".into(),
            Self::Leads => "expected a list of seconds from 0 to 3600 and `end`".into(),
            Self::Boolean => "expected true or false".into(),
            Self::OneOrMoreBooleans => "expected true, false or [false, true]".into(),
            Self::Whole(least, most) => format!("expected a whole number from {least} to {most}"),
            Self::Number(least, most) if *least == ABOVE_ZERO => {
                format!("expected a number above 0, at most {most}")
            }
            Self::Number(least, most) => format!("expected a number from {least} to {most}"),
        }
    }

    pub(super) fn schema(&self) -> Value {
        match self {
            Self::Text => json!({ "type": "string" }),
            Self::Word(known) => json!({ "enum": known() }),
            Self::OneOrMoreWords(known) => one_or_more(&json!({ "enum": known() })),
            Self::OneOrMoreBooleans => one_or_more(&json!({ "type": "boolean" })),
            Self::OneOrMoreWhole(least, most) => {
                one_or_more(&json!({ "type": "integer", "minimum": least, "maximum": most }))
            }
            Self::OneOrMoreNumbers(least, most) => {
                one_or_more(&json!({ "type": "number", "minimum": least, "maximum": most }))
            }
            Self::TableOfTexts => json!({
                "type": "object",
                "additionalProperties": one_or_more(&json!({ "type": "string" })),
            }),
            Self::Split => json!({
                "type": "object",
                "properties": {
                    "test": { "type": "number", "exclusiveMinimum": 0, "exclusiveMaximum": 1 },
                    "seed": { "type": "integer", "minimum": 0, "maximum": i64::MAX },
                },
                "required": ["test"],
                "additionalProperties": false,
            }),
            Self::Words(known) => {
                json!({ "type": "array", "items": { "enum": known() }, "uniqueItems": true })
            }
            Self::Texts => json!({ "type": "array", "items": { "type": "string" } }),
            Self::Tables => {
                let axes = Axis::ALL.map(Axis::name);
                json!({ "type": "array", "items": {
                    "type": "object",
                    "properties": {
                        "rows": { "enum": axes },
                        "columns": { "enum": axes },
                        "measure": { "enum": Measure::ALL.map(Measure::name) },
                        "against": { "type": "string" },
                    },
                    "required": ["rows"],
                    "additionalProperties": false,
                } })
            }
            Self::Pair => {
                json!({ "type": "array", "items": { "type": "string" }, "minItems": 2, "maxItems": 2 })
            }
            Self::Leads => json!({ "type": "array", "items": { "anyOf": [
                { "type": "number", "minimum": 0, "maximum": 3600 },
                { "const": "end" },
            ] } }),
            Self::Boolean => json!({ "type": "boolean" }),
            Self::Whole(least, most) => {
                json!({ "type": "integer", "minimum": least, "maximum": most })
            }
            Self::Number(least, most) => {
                json!({ "type": "number", "minimum": least, "maximum": most })
            }
        }
    }
}

/// A value, or a list of such values.
fn one_or_more(one: &Value) -> Value {
    json!({ "anyOf": [one, { "type": "array", "items": one, "minItems": 1, "uniqueItems": true }] })
}
