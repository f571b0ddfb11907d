//! Outputs that are one type each: what is written and what the schema says come from the same fields.

use nearmiss_record::Record;
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;

/// An output of a command as one type. Fields without a doc comment have the meaning that the vocabulary gives their key.
pub trait Output: Serialize + JsonSchema {
    /// Its name in `nearmiss help json`.
    const NAME: &'static str;
    /// What it is, in one line.
    const TITLE: &'static str;
    /// Whether keys of the vocabulary have its words, whatever the fields say: for types from outside the commands.
    const COMMON_WORDS: bool = false;

    /// The object that is written.
    ///
    /// # Errors
    /// A map in it has keys that JSON does not allow.
    fn document(&self) -> serde_json::Result<Value> {
        serde_json::to_value(self)
    }
}

/// An output with its schema.
pub struct Derived {
    pub name: &'static str,
    pub title: &'static str,
    pub common_words: bool,
    pub schema: fn() -> Value,
}

pub const fn derived<T: Output>() -> Derived {
    Derived {
        name: T::NAME,
        title: T::TITLE,
        common_words: T::COMMON_WORDS,
        schema: nearmiss_record::schema::<T>,
    }
}

/// A noun from outside the commands.
pub const fn noun<T: Record>() -> Derived {
    Derived {
        name: T::NAME,
        title: T::TITLE,
        common_words: false,
        schema: nearmiss_record::schema::<T>,
    }
}
