//! Outputs that are one type each: what is written and what the schema says come from the same fields.

use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use serde::Serialize;
use serde_json::Value;

use super::with_old_names;
use nearmiss_base::system::KeyBinding;
use nearmiss_study::evaluation::Standing;
use nearmiss_study::evaluation::batch::QuestionLine;

/// An output of a command as one type. Fields without a doc comment have the meaning that the vocabulary gives their key.
pub trait Output: Serialize + JsonSchema {
    /// Its name in `nearmiss help json`.
    const NAME: &'static str;
    /// What it is, in one line.
    const TITLE: &'static str;
    /// Deprecated keys that are still written, each with that of today.
    const OLD_NAMES: &'static [(&'static str, &'static str)] = &[];
    /// Whether keys of the vocabulary have its words, whatever the fields say: for types from outside the commands.
    const COMMON_WORDS: bool = false;

    /// The object that is written.
    ///
    /// # Errors
    /// A map in it has keys that JSON does not allow.
    fn document(&self) -> serde_json::Result<Value> {
        let mut value = serde_json::to_value(self)?;
        with_old_names(&mut value, Self::OLD_NAMES);
        Ok(value)
    }
}

/// An output with its schema.
pub struct Derived {
    pub name: &'static str,
    pub title: &'static str,
    pub old_names: &'static [(&'static str, &'static str)],
    pub common_words: bool,
    pub schema: fn() -> Value,
}

pub const fn derived<T: Output>() -> Derived {
    Derived {
        name: T::NAME,
        title: T::TITLE,
        old_names: T::OLD_NAMES,
        common_words: T::COMMON_WORDS,
        schema: schema::<T>,
    }
}

impl Output for QuestionLine {
    const NAME: &'static str = "evaluate-questions";
    const TITLE: &'static str = "`evaluate --questions`: one question a line";
}

impl Output for Standing {
    const NAME: &'static str = "ratings";
    const TITLE: &'static str = "`ratings --json`: one model or prompt a line";
}

impl Output for KeyBinding {
    const NAME: &'static str = "keys";
    const TITLE: &'static str = "`keys --json`: one action a line";
}

fn schema<T: JsonSchema>() -> Value {
    let settings = SchemaSettings::draft2020_12().for_serialize().with(|s| {
        s.inline_subschemas = true;
        s.meta_schema = None;
    });
    settings
        .into_generator()
        .into_root_schema_for::<T>()
        .to_value()
}
