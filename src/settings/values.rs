//! The keys of `config.toml` one by one: what each may be, its value, and what holds where it is not set.

use toml::Value;

use super::Config;

/// A key of `config.toml`.
#[derive(Debug, Clone, PartialEq)]
pub struct Setting {
    /// The key.
    pub key: &'static str,
    /// Its value; `None` if unset and without a default.
    pub value: Option<Value>,
    /// What holds where it is not set.
    pub unset: &'static str,
}

/// A key of the file: what it may be, what holds where it is not set, and its value.
pub(super) struct Key {
    pub name: &'static str,
    /// What is needed behind it.
    pub needed: &'static str,
    unset: &'static str,
    value: fn(&Config) -> Option<Value>,
}

const fn key(
    name: &'static str,
    needed: &'static str,
    unset: &'static str,
    value: fn(&Config) -> Option<Value>,
) -> Key {
    Key {
        name,
        needed,
        unset,
        value,
    }
}

const BOOLEAN: &str = "true or false is needed";
const COUNT: &str = "a whole number of at least 1 (and less than 4294967296) is needed";

/// Every key, in the order of the documentation.
pub(super) const KEYS: [Key; 19] = [
    key(
        "theme",
        "a text is needed, the name of a theme such as \"dark\"",
        "auto: dark or light, as the terminal's background is",
        |config| text(&config.theme),
    ),
    key(
        "glyphs",
        "\"auto\", \"unicode\" or \"ascii\" is needed",
        "auto: what the locale says",
        |config| text(&config.glyphs),
    ),
    key(
        "map",
        "\"auto\", \"pixels\", \"cells\", \"braille\" or \"ascii\" is needed",
        "auto: the best that the terminal can do",
        |config| text(&config.map),
    ),
    key(
        "map_blocks",
        "\"auto\", \"quadrants\", \"sextants\" or \"octants\" is needed",
        "auto: those that the terminal is known to draw",
        |config| text(&config.map_blocks),
    ),
    key("mouse", BOOLEAN, "", |config| Some(config.mouse.into())),
    key("session", BOOLEAN, "", |config| Some(config.session.into())),
    key(
        "editor",
        "\"plain\", \"vim\" or \"emacs\" is needed",
        "",
        |config| Some(config.editor.name().into()),
    ),
    key(
        "model",
        "a text is needed, provider/model, such as \"openai/gpt-4o\"",
        "the built-in judge, reference/geometry",
        |config| text(&config.model),
    ),
    key(
        "history",
        "a whole number of at least 1 is needed",
        "the template's",
        |config| Some(i64::try_from(config.history?).ok()?.into()),
    ),
    key(
        "radius",
        "a number is needed, metres, more than 0",
        "the template's",
        |config| config.radius.map(Value::Float),
    ),
    key(
        "temperature",
        "a number from 0 to 2 is needed",
        "the template's, else not sent",
        |config| config.temperature.map(Value::Float),
    ),
    key("max_tokens", COUNT, "not sent", |config| {
        Some(config.max_tokens?.into())
    }),
    key(
        "effort",
        "\"off\", \"low\", \"medium\" or \"high\" is needed",
        "not sent",
        |config| text(&config.effort),
    ),
    key("concurrency", COUNT, "", |config| {
        Some(config.concurrency.get().into())
    }),
    key(
        "budget",
        "a number is needed, US dollars, more than 0",
        "no bound",
        |config| config.budget.map(Value::Float),
    ),
    key(
        "person",
        "a text is needed, a name",
        "the user's name",
        |config| text(&config.person),
    ),
    key(
        "pictures",
        "a text is needed, a folder",
        "the current folder",
        |config| Some(config.pictures.as_ref()?.display().to_string().into()),
    ),
    // These are printed as sections.
    key(
        "provider",
        "a table for each is needed: [provider.NAME]",
        "",
        |_| None,
    ),
    key("planner", "a table is needed: [planner]", "", |_| None),
];

fn text(text: &Option<String>) -> Option<Value> {
    text.clone().map(Value::String)
}

impl Config {
    /// Every setting but the providers and those of the planner, in the order of the documentation.
    #[must_use]
    pub fn settings(&self) -> Vec<Setting> {
        let flat = |key: &&Key| !["provider", "planner"].contains(&key.name);
        let setting = |key: &Key| Setting {
            key: key.name,
            value: (key.value)(self),
            unset: key.unset,
        };
        KEYS.iter().filter(flat).map(setting).collect()
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn every_key_of_the_file_is_a_setting() {
        let error = toml::from_str::<Config>("no_such_key = 1")
            .unwrap_err()
            .to_string();
        // The message lists all that there are, each in backticks.
        let (_, expected) = error.split_once("expected one of ").unwrap();
        let mut known: Vec<&str> = expected.split('`').skip(1).step_by(2).collect();
        known.retain(|key| !["provider", "planner"].contains(key));
        let settings = Config::default().settings();
        let mut listed: Vec<&str> = settings.iter().map(|s| s.key).collect();
        known.sort_unstable();
        listed.sort_unstable();
        assert_eq!(listed, known);
        for setting in settings {
            assert!(
                setting.value.is_some() == setting.unset.is_empty(),
                "{setting:?}"
            );
        }
    }
}
