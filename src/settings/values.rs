//! The settings one by one: their values, and where in the file they are said.

use toml::Value;
use toml::de::DeTable;

use super::Config;

/// A key of `config.toml`.
#[derive(Debug, Clone, PartialEq)]
pub struct Setting {
    /// The key.
    pub key: &'static str,
    /// Its value; nothing where it is not set and has no value of its own.
    pub value: Option<Value>,
    /// What holds where it is not set.
    pub unset: &'static str,
}

impl Config {
    /// Every setting but the providers and those of the planner, in the order of the documentation.
    #[must_use]
    pub fn settings(&self) -> Vec<Setting> {
        let text = |text: &Option<String>| text.clone().map(Value::String);
        let whole = |number: Option<usize>| {
            number.and_then(|n| Some(Value::Integer(i64::try_from(n).ok()?)))
        };
        let pictures = self
            .pictures
            .as_ref()
            .map(|path| path.display().to_string());
        let setting = |key, value, unset| Setting { key, value, unset };
        vec![
            setting(
                "theme",
                text(&self.theme),
                "auto: dark or light, as the terminal's background is",
            ),
            setting("glyphs", text(&self.glyphs), "auto: what the locale says"),
            setting("mouse", Some(Value::Boolean(self.mouse)), ""),
            setting("session", Some(Value::Boolean(self.session)), ""),
            setting("editor", Some(Value::String(self.editor.name().into())), ""),
            setting(
                "model",
                text(&self.model),
                "the built-in judge, reference/geometry",
            ),
            setting("history", whole(self.history), "the template's"),
            setting("radius", self.radius.map(Value::Float), "the template's"),
            setting(
                "temperature",
                self.temperature.map(Value::Float),
                "the template's, else not sent",
            ),
            setting(
                "max_tokens",
                self.max_tokens.map(|n| Value::Integer(n.into())),
                "not sent",
            ),
            setting("effort", text(&self.effort), "not sent"),
            setting(
                "concurrency",
                Some(Value::Integer(self.concurrency.get().into())),
                "",
            ),
            setting("budget", self.budget.map(Value::Float), "no bound"),
            setting("person", text(&self.person), "the user's name"),
            setting("pictures", text(&pictures), "the current folder"),
        ]
    }
}

/// Where in a file its keys stand.
#[derive(Debug)]
pub struct Lines<'a> {
    text: &'a str,
    table: DeTable<'a>,
}

impl<'a> Lines<'a> {
    /// The keys of a text; none where it is no TOML.
    #[must_use]
    pub fn of(text: &'a str) -> Self {
        let table = DeTable::parse(text).map(toml::Spanned::into_inner);
        Self {
            text,
            table: table.unwrap_or_default(),
        }
    }

    /// The line, from 1, of a key that is reached by these names; nothing where the text does not say it.
    #[must_use]
    pub fn line(&self, names: &[&str]) -> Option<usize> {
        let (last, tables) = names.split_last()?;
        let mut table = &self.table;
        for name in tables {
            table = table.get(*name)?.get_ref().as_table()?;
        }
        let (key, _) = table.iter().find(|(key, _)| key.get_ref() == last)?;
        let before = self.text.get(..key.span().start)?;
        Some(1 + before.matches('\n').count())
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

    #[test]
    fn lines_of_keys() {
        let text = "# a\nmouse = true\n\n[provider.lab]\nbase_url = \"http://x\"\n[provider]\nb.key_env = \"B\"\n";
        let lines = Lines::of(text);
        assert_eq!(lines.line(&["mouse"]), Some(2));
        assert_eq!(lines.line(&["provider", "lab", "base_url"]), Some(5));
        assert_eq!(lines.line(&["provider", "b", "key_env"]), Some(7));
        assert_eq!(lines.line(&["provider", "c", "key_env"]), None);
        assert_eq!(lines.line(&["theme"]), None);
        assert_eq!(Lines::of("= =").line(&["theme"]), None);
    }
}
