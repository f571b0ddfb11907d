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

const BOOLEAN: &str = "expected true or false";
const COUNT: &str = "expected a whole number from 1 to 4294967295";

/// Every key, in the order of the documentation.
pub(super) const KEYS: [Key; 26] = [
    key(
        "theme",
        "expected the name of a theme, such as \"dark\"",
        "auto: dark or light, as the terminal's background is",
        |config| text(&config.theme),
    ),
    key(
        "glyphs",
        "expected \"auto\", \"unicode\" or \"ascii\"",
        "auto: what the locale says",
        |config| text(&config.glyphs),
    ),
    key(
        "map",
        "expected \"auto\", \"pixels\", \"cells\", \"braille\" or \"ascii\"",
        "auto: the best that the terminal can do",
        |config| text(&config.map),
    ),
    key(
        "map_blocks",
        "expected \"auto\", \"quadrants\", \"sextants\" or \"octants\"",
        "auto: those that the terminal is known to draw",
        |config| text(&config.map_blocks),
    ),
    key("mouse", BOOLEAN, "", |config| Some(config.mouse.into())),
    key("session", BOOLEAN, "", |config| Some(config.session.into())),
    key(
        "editor",
        "expected \"plain\", \"vim\" or \"emacs\"",
        "",
        |config| Some(config.editor.name().into()),
    ),
    key(
        "model",
        "expected provider/model, such as \"openai/gpt-6-luna\"",
        "the built-in judge, reference/geometry",
        |config| text(&config.model),
    ),
    key(
        "history",
        "expected a whole number from 1 to 100000",
        "the template's",
        |config| Some(i64::try_from(config.history?).ok()?.into()),
    ),
    key(
        "radius",
        "expected a number of metres above 0, at most 1000000",
        "the template's",
        |config| config.radius.map(Value::Float),
    ),
    key(
        "temperature",
        "expected a number from 0 to 2",
        "the template's, else not sent",
        |config| config.temperature.map(Value::Float),
    ),
    key("max_tokens", COUNT, "not sent", |config| {
        Some(config.max_tokens?.into())
    }),
    key(
        "effort",
        "expected \"off\", \"minimal\", \"low\", \"medium\", \"high\", \"xhigh\" or \"max\"",
        "not sent",
        |config| text(&config.effort),
    ),
    key("tools", BOOLEAN, "", |config| Some(config.tools.into())),
    key("log_probabilities", BOOLEAN, "", |config| {
        Some(config.log_probabilities.into())
    }),
    key("concurrency", COUNT, "", |config| {
        Some(config.concurrency.get().into())
    }),
    key(
        "attack_style",
        "expected \"human\" or \"limit\"",
        "human: within what people do",
        |config| text(&config.attack_style),
    ),
    key(
        "attack_within",
        "expected a number of metres above 0",
        "",
        |config| Some(Value::Float(config.attack_within)),
    ),
    key(
        "attackers",
        "expected a whole number from 1 to 3",
        "1: one obstacle attacks",
        |config| Some(config.attackers?.into()),
    ),
    key(
        "budget",
        "expected a number of US dollars above 0",
        "no bound",
        |config| config.budget.map(Value::Float),
    ),
    key("person", "expected a name", "the user's name", |config| {
        text(&config.person)
    }),
    key(
        "pictures",
        "expected a folder",
        "the current folder",
        |config| Some(config.pictures.as_ref()?.display().to_string().into()),
    ),
    key(
        "index",
        "expected the folder of an index",
        "no index",
        |config| Some(config.index.as_ref()?.display().to_string().into()),
    ),
    key(
        "maps",
        "expected a folder of maps of recordings, or one map",
        "only those beside recordings",
        |config| Some(config.maps.as_ref()?.display().to_string().into()),
    ),
    // These are printed as sections.
    key(
        "provider",
        "expected a table for each: [provider.NAME]",
        "",
        |_| None,
    ),
    key("planner", "expected a table: [planner]", "", |_| None),
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
