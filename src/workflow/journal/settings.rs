//! Settings of a run as its files keep them, and where those of two runs differ.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

use serde::{Deserialize, Serialize};
use serde_json::Value;

/// The settings of a run by their keys, those of a table by the keys on the way to them: `search.seed`. What is not
/// given is left out.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct RunSettings(BTreeMap<String, Value>);

/// A setting that two runs do not share.
#[derive(Debug, Clone, PartialEq)]
pub struct SettingDifference {
    /// Its key.
    pub key: String,
    /// Its value in the earlier run; `None` where it was not given.
    pub then: Option<Value>,
    /// Its value now.
    pub now: Option<Value>,
}

impl RunSettings {
    /// Those that a value has when it is written to a file and read again: digits that no file keeps make no
    /// difference.
    ///
    /// # Errors
    /// It cannot be written as JSON.
    pub fn new(settings: &impl Serialize) -> serde_json::Result<Self> {
        let mut all = BTreeMap::new();
        let written = serde_json::to_string(settings)?;
        flatten(String::new(), serde_json::from_str(&written)?, &mut all);
        Ok(Self(all))
    }

    /// Settings of which only words are known.
    pub(super) fn of_words(words: impl IntoIterator<Item = (String, String)>) -> Self {
        let value = |word: String| word.parse::<f64>().map_or(Value::String(word), Value::from);
        let all = words.into_iter().map(|(key, word)| (key, value(word)));
        Self(all.collect())
    }

    /// The same, with no more known than words.
    pub(super) fn in_words(&self) -> Self {
        let word = |value: &Value| value.as_str().map_or(value.to_string(), String::from);
        Self::of_words(self.0.iter().map(|(key, value)| (key.clone(), word(value))))
    }

    /// Where these of an earlier run are others than those of now.
    #[must_use]
    pub fn differences(&self, now: &Self) -> Vec<SettingDifference> {
        let keys: BTreeSet<&String> = self.0.keys().chain(now.0.keys()).collect();
        let differ = keys
            .into_iter()
            .filter(|key| self.0.get(*key) != now.0.get(*key));
        differ
            .map(|key| SettingDifference {
                key: key.clone(),
                then: self.0.get(key).cloned(),
                now: now.0.get(key).cloned(),
            })
            .collect()
    }
}

impl fmt::Display for SettingDifference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let word = |value: &Option<Value>| match value {
            Some(value) => value.to_string(),
            None => "not given".into(),
        };
        write!(
            f,
            "{} {}, now {}",
            self.key,
            word(&self.then),
            word(&self.now)
        )
    }
}

fn flatten(path: String, value: Value, all: &mut BTreeMap<String, Value>) {
    match value {
        Value::Null => {}
        Value::Object(table) => {
            for (key, value) in table {
                let dot = if path.is_empty() { "" } else { "." };
                flatten(format!("{path}{dot}{key}"), value, all);
            }
        }
        value => {
            all.insert(path, value);
        }
    }
}
