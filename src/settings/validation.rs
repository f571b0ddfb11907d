//! What is wrong with `config.toml`: all of it, key by key, in plain words.

use serde::Deserialize;
use toml::{Table, Value};

use super::values::KEYS;
use super::{Config, planner};
use nearmiss_base::system::{KeyLines, Mistake, nearest, toml_mistake};

/// Everything that is wrong with a text, in its order; of a text that is no TOML, where it stops being one.
pub fn mistakes(text: &str) -> Vec<Mistake> {
    let table: Table = match toml::from_str(text) {
        Ok(table) => table,
        Err(error) => return vec![no_toml(text, &error)],
    };
    let lines = KeyLines::new(text);
    let section = table.get("planner").and_then(Value::as_table);
    let inner = section
        .map_or_else(Vec::new, planner::wrong)
        .into_iter()
        .map(|(path, words)| {
            let path = std::iter::once("planner").chain(path.iter().map(String::as_str));
            let line = lines.line(&path.collect::<Vec<_>>());
            Mistake { line, words }
        });
    let mut found: Vec<Mistake> = inner.collect();
    found.extend(table.into_iter().filter_map(|(key, value)| {
        let words = wrong(&key, value)?;
        let line = lines.line(&[&key]);
        Some(Mistake { line, words })
    }));
    found.sort_by_key(|mistake| mistake.line);
    found
}

/// What is wrong with a key and its value, if anything is.
fn wrong(key: &str, value: Value) -> Option<String> {
    let Some(known) = KEYS.iter().find(|known| known.name == key) else {
        let all: Vec<&str> = KEYS.iter().map(|known| known.name).collect();
        return Some(format!("unknown key `{key}`{}", near(key, &all)));
    };
    let shown = shown(&value);
    let alone = Table::from_iter([(key.to_string(), value)]);
    match Config::deserialize(alone) {
        Ok(config) if can_be_meant(&config) => None,
        _ => Some(format!("{key} = {shown}: {}", known.needed)),
    }
}

/// The words for how much models are to reason.
const EFFORTS: [&str; 7] = ["off", "minimal", "low", "medium", "high", "xhigh", "max"];

/// Whether values of the right kind are in their bounds, too.
fn can_be_meant(config: &Config) -> bool {
    let positive = |number: Option<f64>| number.is_none_or(|x| x.is_finite() && x > 0.0);
    let one_of = |word: &Option<String>, all: &[&str]| {
        let word = word.as_deref();
        word.is_none_or(|word| all.contains(&word))
    };
    let model = |id: &str| {
        let parts = id.split_once('/');
        parts.is_some_and(|(provider, model)| !provider.is_empty() && !model.is_empty())
    };
    config
        .radius
        .is_none_or(|metres| metres > 0.0 && metres <= 1e6)
        && positive(Some(config.attack_within))
        && positive(config.budget)
        && config
            .history
            .is_none_or(|steps| (1..=100_000).contains(&steps))
        && config.max_tokens != Some(0)
        && config.temperature.is_none_or(|t| (0.0..=2.0).contains(&t))
        && one_of(&config.effort, &EFFORTS)
        && one_of(&config.glyphs, &["auto", "unicode", "ascii"])
        && one_of(
            &config.map,
            &["auto", "pixels", "cells", "braille", "ascii"],
        )
        && one_of(
            &config.map_blocks,
            &["auto", "quadrants", "sextants", "octants"],
        )
        && one_of(&config.attack_style, &["human", "limit"])
        && config.attackers.is_none_or(|n| (1..=3).contains(&n))
        && config.model.as_deref().is_none_or(model)
}

/// The one of all keys that was probably meant, or all of them.
pub(super) fn near(key: &str, all: &[&str]) -> String {
    match nearest(key, all.iter().copied()) {
        Some(known) => format!("; did you mean `{known}`?"),
        None => format!("; available: {}", all.join(", ")),
    }
}

/// A value as the file has it.
pub(super) fn shown(value: &Value) -> String {
    match value {
        Value::Array(_) => "a list".into(),
        Value::Table(_) => "a table".into(),
        other => other.to_string(),
    }
}

/// Where a text stops being TOML; of its line only the key is told: the value may be a secret in the wrong place.
fn no_toml(text: &str, error: &toml::de::Error) -> Mistake {
    let Mistake { line, words } = toml_mistake(text, error);
    let written = line.and_then(|line| text.lines().nth(line - 1));
    let key = written.and_then(|written| Some(written.split_once('=')?.0.trim()));
    let words = match key.filter(|key| !key.is_empty()) {
        Some(key) => format!("{key}: invalid TOML: {words}"),
        None => format!("invalid TOML: {words}"),
    };
    Mistake { line, words }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn said(text: &str) -> Vec<String> {
        let found = mistakes(text).into_iter();
        found
            .map(|m| format!("{}: {}", m.line.unwrap_or_default(), m.words))
            .collect()
    }

    #[test]
    fn all_are_named_in_plain_words() {
        let text = "radius = \"lots\"\nmouse = 1\nmodell = \"a/b\"\n\nhistory = 3\nmax_tokens = 5_000_000_000\n\
            temperature = 3\neditor = \"ed\"\nqwrtz = 1\nprovider = [1]\n";
        let found = said(text);
        let starts = [
            "1: radius = \"lots\": expected a number",
            "2: mouse = 1: expected true or false",
            "3: unknown key `modell`; did you mean `model`?",
            "6: max_tokens = 5000000000: expected a whole number",
            "7: temperature = 3: expected a number from 0 to 2",
            "8: editor = \"ed\": expected \"plain\", \"vim\"",
            "9: unknown key `qwrtz`; available: theme, glyphs,",
            "10: provider = a list: expected a table for each",
        ];
        assert_eq!(found.len(), starts.len(), "{found:#?}");
        for (found, start) in found.iter().zip(starts) {
            assert!(found.starts_with(start), "{found}");
        }
        assert_eq!(said("# nothing\n"), [""; 0]);
    }

    #[test]
    fn what_is_no_toml_is_named_without_its_value() {
        let found = said("mouse = true\napi_key = sk-secret\n");
        assert!(
            found[0].starts_with("2: api_key: invalid TOML: "),
            "{found:?}"
        );
        assert!(!found[0].contains("secret"), "{found:?}");
        assert!(said("mouse = true\nmouse = true\n")[0].starts_with("2: mouse: "));
    }
}
