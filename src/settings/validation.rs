//! What is wrong with `config.toml`: all of it, key by key, in plain words.

use serde::Deserialize;
use toml::{Table, Value};

use super::{Config, Lines, planner};

/// Something in the file that is not known or cannot be meant.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Mistake {
    /// Line from 1, where it has one.
    pub line: Option<usize>,
    /// What is wrong; begins with the key.
    pub words: String,
}

/// Every key, and what is needed behind it.
const NEEDED: [(&str, &str); 17] = [
    (
        "theme",
        "a text is needed, the name of a theme such as \"dark\"",
    ),
    ("glyphs", "\"auto\", \"unicode\" or \"ascii\" is needed"),
    ("mouse", "true or false is needed"),
    ("session", "true or false is needed"),
    ("editor", "\"plain\", \"vim\" or \"emacs\" is needed"),
    (
        "model",
        "a text is needed, provider/model, such as \"openai/gpt-4o\"",
    ),
    ("history", "a whole number of at least 1 is needed"),
    ("radius", "a number is needed, metres, more than 0"),
    ("temperature", "a number from 0 to 2 is needed"),
    (
        "max_tokens",
        "a whole number of at least 1 (and less than 4294967296) is needed",
    ),
    (
        "effort",
        "\"off\", \"low\", \"medium\" or \"high\" is needed",
    ),
    (
        "concurrency",
        "a whole number of at least 1 (and less than 4294967296) is needed",
    ),
    ("budget", "a number is needed, US dollars, more than 0"),
    ("person", "a text is needed, a name"),
    ("pictures", "a text is needed, a folder"),
    ("provider", "a table for each is needed: [provider.NAME]"),
    ("planner", "a table is needed: [planner]"),
];

/// Everything that is wrong with a text, in its order; of a text that is no TOML, where it stops being one.
pub fn mistakes(text: &str) -> Vec<Mistake> {
    let table: Table = match toml::from_str(text) {
        Ok(table) => table,
        Err(error) => return vec![no_toml(text, &error)],
    };
    let lines = Lines::of(text);
    let section = table.get("planner").and_then(Value::as_table);
    let inner = section.map_or_else(Vec::new, planner::wrong).into_iter();
    let inner = inner.map(|(path, words)| {
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
    let Some((_, needed)) = NEEDED.iter().find(|(known, _)| *known == key) else {
        let all = NEEDED.map(|(known, _)| known);
        return Some(format!("{key} is not known{}", near(key, &all)));
    };
    let shown = shown(&value);
    let alone = Table::from_iter([(key.to_string(), value)]);
    match Config::deserialize(alone) {
        Ok(config) if can_be_meant(&config) => None,
        _ => Some(format!("{key} = {shown}: {needed}")),
    }
}

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
    positive(config.radius)
        && positive(config.budget)
        && config.history != Some(0)
        && config.max_tokens != Some(0)
        && config.temperature.is_none_or(|t| (0.0..=2.0).contains(&t))
        && one_of(&config.effort, &["off", "low", "medium", "high"])
        && one_of(&config.glyphs, &["auto", "unicode", "ascii"])
        && config.model.as_deref().is_none_or(model)
}

/// The one of all keys that was probably meant, or all of them.
pub(super) fn near(key: &str, all: &[&str]) -> String {
    let like = |other: &str| strsim::jaro(key, other);
    let best = all.iter().max_by(|a, b| like(a).total_cmp(&like(b)));
    match best.filter(|known| like(known) > 0.75) {
        Some(known) => format!("; did you mean {known}?"),
        None => format!("; there are {}", all.join(", ")),
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

/// Where a text stops being TOML; of its line only the key is said: the value may be a secret in the wrong place.
fn no_toml(text: &str, error: &toml::de::Error) -> Mistake {
    let words = error.message().trim().replace('\n', " ");
    let before = error.span().and_then(|span| text.get(..span.start));
    let line = before.map(|before| 1 + before.matches('\n').count());
    let said = line.and_then(|line| text.lines().nth(line - 1));
    let key = said.and_then(|said| Some(said.split_once('=')?.0.trim()));
    let words = match key.filter(|key| !key.is_empty()) {
        Some(key) => format!("{key}: this is not TOML: {words}"),
        None => format!("this is not TOML: {words}"),
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
            "1: radius = \"lots\": a number is needed",
            "2: mouse = 1: true or false is needed",
            "3: modell is not known; did you mean model?",
            "6: max_tokens = 5000000000: a whole number",
            "7: temperature = 3: a number from 0 to 2",
            "8: editor = \"ed\": \"plain\", \"vim\"",
            "9: qwrtz is not known; there are theme, glyphs,",
            "10: provider = a list: a table for each",
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
            found[0].starts_with("2: api_key: this is not TOML: "),
            "{found:?}"
        );
        assert!(!found[0].contains("secret"), "{found:?}");
        assert!(said("mouse = true\nmouse = true\n")[0].starts_with("2: mouse: "));
    }

    #[test]
    fn every_setting_has_its_words() {
        let mut known: Vec<&str> = NEEDED.iter().map(|(key, _)| *key).collect();
        let settings = Config::default().settings();
        let mut keys: Vec<&str> = settings.iter().map(|s| s.key).collect();
        keys.extend(["provider", "planner"]);
        known.sort_unstable();
        keys.sort_unstable();
        assert_eq!(known, keys);
    }
}
