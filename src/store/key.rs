//! Request keys: SHA-256 over canonical JSON.

use serde::{Deserialize, Serialize};
use serde_json::Value;
use sha2::{Digest, Sha256};

/// Identifies a request by everything that is in it.
#[derive(Debug, Clone, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, schemars::JsonSchema)]
pub struct Key(String);

impl Key {
    /// The key of a document: the hexadecimal SHA-256 of its canonical form.
    ///
    /// That form has no white space, and the names of every object are sorted by their code points.
    #[must_use]
    pub fn digest(document: &Value) -> Self {
        let mut text = String::new();
        write(document, &mut text);
        let digest = Sha256::digest(text.as_bytes());
        Self(digest.iter().map(|byte| format!("{byte:02x}")).collect())
    }

    /// A key as it was kept; nothing if it cannot be one.
    #[must_use]
    pub fn parse(text: &str) -> Option<Self> {
        let fits = text.len() == 64 && text.bytes().all(|b| matches!(b, b'0'..=b'9' | b'a'..=b'f'));
        fits.then(|| Self(text.to_string()))
    }

    /// Sixty-four hexadecimal digits.
    #[must_use]
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

/// A key as it was kept, if it can be one.
pub(super) fn kept<'de, D: serde::Deserializer<'de>>(from: D) -> Result<Option<Key>, D::Error> {
    let text = Option::<String>::deserialize(from)?;
    Ok(text.and_then(|text| Key::parse(&text)))
}

fn write(value: &Value, out: &mut String) {
    match value {
        Value::Object(map) => {
            let mut entries: Vec<_> = map.iter().collect();
            entries.sort_by_key(|(name, _)| name.as_str());
            out.push('{');
            for (place, (name, value)) in entries.into_iter().enumerate() {
                if place > 0 {
                    out.push(',');
                }
                out.push_str(&Value::from(name.as_str()).to_string());
                out.push(':');
                write(value, out);
            }
            out.push('}');
        }
        Value::Array(items) => {
            out.push('[');
            for (place, item) in items.iter().enumerate() {
                if place > 0 {
                    out.push(',');
                }
                write(item, out);
            }
            out.push(']');
        }
        plain => out.push_str(&plain.to_string()),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use serde_json::json;

    #[test]
    fn the_order_of_names_does_not_count_and_everything_else_does() {
        let a: Value =
            serde_json::from_str(r#"{"b": [1, {"d": 2, "c": "x\n"}], "a": null}"#).unwrap();
        let b: Value = serde_json::from_str(r#"{"a":null,"b":[1,{"c":"x\n","d":2}]}"#).unwrap();
        assert_eq!(Key::digest(&a), Key::digest(&b));
        for other in [
            json!({"a": null, "b": [{"c": "x\n", "d": 2}, 1]}),
            json!({"a": null, "b": [1, {"c": "x", "d": 2}]}),
            json!({"a": false, "b": [1, {"c": "x\n", "d": 2}]}),
            json!({"b": [1, {"c": "x\n", "d": 2}]}),
        ] {
            assert_ne!(Key::digest(&a), Key::digest(&other), "{other}");
        }
    }

    #[test]
    fn a_key_is_the_digest_of_the_canonical_text() {
        // printf '{"a":[1,"b"]}' | sha256sum
        let known = "ee70aef572200b15408cec63724334e0ccd6c2b5d1cd7225a7f6a3f2a9aa80a9";
        let key = Key::digest(&json!({"a": [1, "b"]}));
        assert_eq!(key.as_str(), known);
        assert_eq!(Key::parse(known), Some(key));
        assert_eq!(Key::parse(&known[1..]), None);
        assert_eq!(Key::parse(&known.to_uppercase()), None);
    }
}
