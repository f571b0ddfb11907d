//! JSON that commands print: the version of its form, deprecated names of keys, and the schemas of `nearmiss help json`.

mod derived;
mod list;
mod schemas;

use serde_json::{Map, Value};

pub use derived::Output;
pub use schemas::{document, keys, names};

/// The version of the form of all JSON; it grows when a key goes or changes its meaning.
pub const SCHEMA_VERSION: u32 = 1;

/// An object with its `schema_version` in front; other values as they are.
pub fn versioned(value: Value) -> Value {
    match value {
        Value::Object(fields) => {
            let version = ("schema_version".to_string(), SCHEMA_VERSION.into());
            let mut object = Map::from_iter([version]);
            object.extend(fields);
            Value::Object(object)
        }
        other => other,
    }
}

/// Adds deprecated names of keys, which stay for one version: pairs of the old name and that of today.
pub fn with_old_names(value: &mut Value, names: &[(&str, &str)]) {
    for (old, new) in names {
        if let Some(same) = value.get(*new).cloned() {
            value[*old] = same;
        }
    }
}
