//! Texts that are JSON: text in the database, JSON in records, and the same text again when read back.

use serde::{Deserialize, Deserializer, Serialize, Serializer};
use serde_json::Value;

/// A text that may be JSON, or none.
pub trait Document: Sized {
    /// As JSON where it is an object or a list, else as a string.
    fn to_value(&self) -> Value;

    /// Of what [`Self::to_value`] made, or of the text itself; nothing where it must not be missing.
    fn from_value(value: Value) -> Option<Self>;
}

impl Document for String {
    fn to_value(&self) -> Value {
        match serde_json::from_str(self) {
            Ok(document @ (Value::Object(_) | Value::Array(_))) => document,
            _ => self.as_str().into(),
        }
    }

    fn from_value(value: Value) -> Option<Self> {
        match value {
            Value::Null => None,
            Value::String(text) => Some(text),
            document => Some(document.to_string()),
        }
    }
}

impl Document for Option<String> {
    fn to_value(&self) -> Value {
        self.as_ref().map_or(Value::Null, Document::to_value)
    }

    fn from_value(value: Value) -> Option<Self> {
        Some(String::from_value(value))
    }
}

pub fn serialize<S: Serializer>(document: &impl Document, to: S) -> Result<S::Ok, S::Error> {
    document.to_value().serialize(to)
}

/// The same, but what would not come back letter by letter stays text.
pub fn exact<S: Serializer>(document: &String, to: S) -> Result<S::Ok, S::Error> {
    let value = document.to_value();
    let written = value.to_string();
    if written == *document {
        value.serialize(to)
    } else {
        document.serialize(to)
    }
}

pub fn deserialize<'de, D: Deserializer<'de>, T: Document>(from: D) -> Result<T, D::Error> {
    let value = Value::deserialize(from)?;
    T::from_value(value).ok_or_else(|| serde::de::Error::custom("a text is missing"))
}
