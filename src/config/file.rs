//! `config.toml`: what it may say, and clear words for what it may not.

use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::Keys;
use super::text_file::text_if_there;

/// The configuration.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// Name of the theme; `auto` for dark or light, as the terminal's background is, where it is not set.
    pub theme: Option<String>,
    /// Which signs are drawn: `unicode`, `ascii`, or `auto` for what the locale says, where it is not set.
    pub glyphs: Option<String>,
    /// Whether the mouse is used.
    pub mouse: bool,
    /// Whether the workbench comes back as it was left.
    pub session: bool,
    /// Keys of the template editor: `plain`, `vim` or `emacs`.
    pub editor: Keys,
    /// The model asked first, as `provider/model`.
    pub model: Option<String>,
    /// Steps of history in a window; the template's default where it is not set.
    pub history: Option<usize>,
    /// Obstacles farther from the ego than this are not described, metres; the template's default where it is not set.
    pub radius: Option<f64>,
    /// Sampling temperature sent to models; the server's default where it is not set.
    pub temperature: Option<f64>,
    /// Most tokens an answer may have; the server's default where it is not set.
    pub max_tokens: Option<u32>,
    /// How much models are to reason: `off`, `low`, `medium` or `high`; the server's default where it is not set.
    pub effort: Option<String>,
    /// Requests of a batch that may be on their way to one provider at once; its own `concurrency` holds too.
    pub concurrency: std::num::NonZeroU32,
    /// Most US dollars that one session of the workbench may cost; without it there is no bound.
    pub budget: Option<f64>,
    /// Who rates answers; the user's name where it is not set.
    pub person: Option<String>,
    /// Where pictures are saved; the current folder where it is not set.
    pub pictures: Option<PathBuf>,
    /// Providers of language models, beside and over the built-in ones.
    #[serde(rename = "provider")]
    pub providers: toml::Table,
}

impl Default for Config {
    fn default() -> Self {
        Self {
            theme: None,
            glyphs: None,
            mouse: true,
            session: true,
            editor: Keys::Plain,
            model: None,
            history: None,
            radius: None,
            temperature: None,
            max_tokens: None,
            effort: None,
            concurrency: std::num::NonZeroU32::new(4).unwrap_or(std::num::NonZeroU32::MIN),
            budget: None,
            person: None,
            pictures: None,
            providers: toml::Table::new(),
        }
    }
}

/// Why a configuration file is not in use.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{file}{}: {message}; the defaults are in use", line.map(|l| format!(":{l}")).unwrap_or_default())]
pub struct ConfigError {
    /// Which file.
    pub file: String,
    /// Line from 1.
    pub line: Option<usize>,
    /// What is wrong, with the key.
    pub message: String,
}

impl ConfigError {
    /// What is wrong and where, without what is done about it.
    #[must_use]
    pub fn mistake_in_words(&self) -> String {
        let line = self.line.map(|l| format!(":{l}")).unwrap_or_default();
        format!("{}{line}: {}", self.file, self.message)
    }
}

impl Config {
    /// Reads a configuration file; one that does not exist says nothing.
    ///
    /// # Errors
    /// It cannot be read, or says something that is not known: with file, line and key.
    pub fn read(path: &Path) -> Result<Self, ConfigError> {
        let file = path.display().to_string();
        let text = match text_if_there(path) {
            Ok(Some(text)) => text,
            Ok(None) => return Ok(Self::default()),
            Err(message) => {
                return Err(ConfigError {
                    file,
                    line: None,
                    message,
                });
            }
        };
        let config: Self = toml::from_str(&text).map_err(|error| ConfigError {
            file: file.clone(),
            line: error
                .span()
                .map(|s| 1 + text[..s.start.min(text.len())].matches('\n').count()),
            message: describe(&text, &error),
        })?;
        match config.mistake() {
            None => Ok(config),
            Some((key, message)) => Err(ConfigError {
                file,
                line: text
                    .lines()
                    .position(|l| l.trim_start().starts_with(key))
                    .map(|l| l + 1),
                message: format!("{key} {message}"),
            }),
        }
    }

    /// Who rates answers: as configured, else the user's name of the system, else `unknown`.
    #[must_use]
    pub fn person(&self) -> String {
        let system = || {
            let names = ["USER", "LOGNAME", "USERNAME"].into_iter();
            let mut found = names.filter_map(|name| std::env::var(name).ok());
            found.find(|name| !name.trim().is_empty())
        };
        let person = self.person.clone().filter(|p| !p.trim().is_empty());
        person.or_else(system).unwrap_or_else(|| "unknown".into())
    }

    /// A value that cannot be meant, by its key.
    fn mistake(&self) -> Option<(&'static str, &'static str)> {
        let model = |id: &str| {
            id.split_once('/')
                .is_some_and(|(p, m)| !p.is_empty() && !m.is_empty())
        };
        let glyphs = |word: &str| ["auto", "unicode", "ascii"].contains(&word);
        let effort = |word: &str| ["off", "low", "medium", "high"].contains(&word);
        if self.radius.is_some_and(|r| !(r.is_finite() && r > 0.0)) {
            Some(("radius", "must be a positive number of metres"))
        } else if self.history == Some(0) {
            Some(("history", "must be at least 1"))
        } else if self.temperature.is_some_and(|t| !(0.0..=2.0).contains(&t)) {
            Some(("temperature", "must lie between 0 and 2"))
        } else if self.max_tokens == Some(0) {
            Some(("max_tokens", "must be at least 1"))
        } else if self
            .budget
            .is_some_and(|usd| !(usd.is_finite() && usd > 0.0))
        {
            Some(("budget", "must be a positive number of US dollars"))
        } else if self.effort.as_deref().is_some_and(|e| !effort(e)) {
            Some(("effort", "must be off, low, medium or high"))
        } else if self.glyphs.as_deref().is_some_and(|g| !glyphs(g)) {
            Some(("glyphs", "must be auto, unicode or ascii"))
        } else if self.model.as_deref().is_some_and(|id| !model(id)) {
            Some(("model", "must be provider/model"))
        } else {
            None
        }
    }
}

/// What is wrong, with the line that it is in: messages alone do not always name the key.
fn describe(text: &str, error: &toml::de::Error) -> String {
    let message = error
        .message()
        .trim()
        .replace('\n', " ")
        .replace("usize", "a whole number");
    let line = error
        .span()
        .and_then(|span| text.get(..span.start))
        .map(|before| {
            let start = before.rfind('\n').map_or(0, |i| i + 1);
            text[start..]
                .lines()
                .next()
                .unwrap_or_default()
                .trim()
                .to_string()
        });
    match line {
        Some(line) if !line.is_empty() => format!("{message}, in `{line}`"),
        _ => message,
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_wrong_key_is_named_with_its_line() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("config.toml");
        assert_eq!(Config::read(&path), Ok(Config::default()));
        std::fs::write(&path, "mouse = false\nradios = 20\n").unwrap();
        let error = Config::read(&path).unwrap_err();
        assert_eq!(error.line, Some(2));
        assert!(error.message.contains("radios"), "{error}");
        for (wrong, key) in [
            ("theme = 3", "theme"),
            ("history = -1", "history"),
            ("effort = \"max\"", "effort"),
            ("concurrency = 0", "concurrency"),
            ("budget = -1.0", "budget"),
            ("editor = \"ed\"", "editor"),
            ("model = \"x\"", "model"),
            ("glyphs = \"emoji\"", "glyphs"),
        ] {
            std::fs::write(&path, format!("mouse = false\n{wrong}\n")).unwrap();
            let error = Config::read(&path).unwrap_err();
            assert!(
                error.line == Some(2) && error.message.contains(key),
                "{error}"
            );
        }
        std::fs::write(
            &path,
            "mouse = false\n[provider.lab]\nbase_url = \"http://x\"\n",
        )
        .unwrap();
        assert!(!Config::read(&path).unwrap().mouse);
    }
}
