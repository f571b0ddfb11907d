//! `config.toml`: what it may say, and clear words for what it may not.

use std::path::Path;

use serde::Deserialize;

/// The configuration.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// Name of the theme.
    pub theme: Option<String>,
    /// Whether the mouse is used.
    pub mouse: bool,
    /// The model asked first, as `provider/model`.
    pub model: Option<String>,
    /// Steps of history in a window.
    pub history: usize,
    /// Obstacles farther from the ego than this are not described, metres.
    pub radius: f64,
    /// Sampling temperature sent to models; the server's default where it is not set.
    pub temperature: Option<f64>,
    /// Most tokens an answer may have; the server's default where it is not set.
    pub max_tokens: Option<u32>,
    /// Providers of language models, beside and over the built-in ones.
    #[serde(rename = "provider")]
    pub providers: toml::Table,
}

impl Default for Config {
    fn default() -> Self {
        Self {
            theme: None,
            mouse: true,
            model: None,
            history: 10,
            radius: 30.0,
            temperature: None,
            max_tokens: None,
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

impl Config {
    /// Reads a configuration file; one that does not exist says nothing.
    ///
    /// # Errors
    /// It cannot be read, or says something that is not known: with file, line and key.
    pub fn read(path: &Path) -> Result<Self, ConfigError> {
        let file = path.display().to_string();
        let text = match std::fs::read_to_string(path) {
            Ok(text) => text,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
                return Ok(Self::default());
            }
            Err(error) => {
                return Err(ConfigError {
                    file,
                    line: None,
                    message: error.to_string(),
                });
            }
        };
        let config: Self = toml::from_str(&text).map_err(|error| ConfigError {
            file: file.clone(),
            line: error
                .span()
                .map(|s| 1 + text[..s.start.min(text.len())].matches('\n').count()),
            message: error.message().trim().replace('\n', " "),
        })?;
        if !(config.radius.is_finite() && config.radius > 0.0) || config.history == 0 {
            return Err(ConfigError {
                file,
                line: None,
                message: "radius and history must be positive".into(),
            });
        }
        Ok(config)
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
        std::fs::write(
            &path,
            "mouse = false\n[provider.lab]\nbase_url = \"http://x\"\n",
        )
        .unwrap();
        assert!(!Config::read(&path).unwrap().mouse);
    }
}
