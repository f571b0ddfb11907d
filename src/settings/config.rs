//! `config.toml`: what it may say, and clear words for what it may not.

use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::Keys;
use super::text_file::text_if_there;
use super::validation::mistakes;
use nearmiss_base::system::Mistake;

/// The configuration.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// Name of the theme; `auto` for dark or light, as the terminal's background is, where it is not set.
    pub theme: Option<String>,
    /// Which signs are drawn: `unicode`, `ascii`, or `auto` for what the locale says, where it is not set.
    pub glyphs: Option<String>,
    /// How the map is drawn: `pixels`, `cells`, `braille`, `ascii`, or `auto` for the best that the terminal can do,
    /// where it is not set.
    pub map: Option<String>,
    /// Block characters of the map as cells: `quadrants`, `sextants`, `octants`, or `auto` for those that the terminal
    /// is known to draw, where it is not set.
    pub map_blocks: Option<String>,
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
    /// How much models are to reason: `off`, `minimal`, `low`, `medium`, `high`, `xhigh` or `max`; the server's default
    /// where it is not set.
    pub effort: Option<String>,
    /// Whether the log probabilities of answers are asked for, where a model gives them.
    pub log_probabilities: bool,
    /// Whether models may call tools that compute.
    pub tools: bool,
    /// Requests of a batch that may be on their way to one provider at once; its own `concurrency` holds too.
    pub concurrency: std::num::NonZeroU32,
    /// How attackers of variants move: `human` or `limit`; `human` where it is not set.
    pub attack_style: Option<String>,
    /// A model chooses attackers among obstacles this near ahead of the ego or beside it, metres.
    pub attack_within: f64,
    /// At most so many obstacles of a variant attack together, 1 to 3; 1 where it is not set.
    pub attackers: Option<u8>,
    /// Most US dollars that one session of the workbench, or one `ask`, may cost; without it there is no bound.
    pub budget: Option<f64>,
    /// Who rates answers; the user's name where it is not set.
    pub person: Option<String>,
    /// Where pictures are saved; the current folder where it is not set.
    pub pictures: Option<PathBuf>,
    /// Folder of the index that the workbench opens with; none where it is not set.
    pub index: Option<PathBuf>,
    /// A map (Lanelet2 of drone recordings, GeoPackage of nuPlan), or a folder of them, for recordings whose map does not lie
    /// with them; none where it is not set.
    pub maps: Option<PathBuf>,
    /// Providers of language models, beside and over the built-in ones.
    #[serde(rename = "provider")]
    pub providers: toml::Table,
    /// How motions are planned, as the file says it; see [`Config::planning`].
    pub planner: toml::Table,
}

impl Default for Config {
    fn default() -> Self {
        Self {
            theme: None,
            glyphs: None,
            map: None,
            map_blocks: None,
            mouse: true,
            session: true,
            editor: Keys::Plain,
            model: None,
            history: None,
            radius: None,
            temperature: None,
            max_tokens: None,
            effort: None,
            log_probabilities: false,
            tools: false,
            concurrency: std::num::NonZeroU32::new(4).unwrap_or(std::num::NonZeroU32::MIN),
            attack_style: None,
            attack_within: 30.0,
            attackers: None,
            budget: None,
            person: None,
            pictures: None,
            index: None,
            maps: None,
            providers: toml::Table::new(),
            planner: toml::Table::new(),
        }
    }
}

/// Why a configuration file is not in use.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{}; using the defaults", self.in_short())]
pub struct ConfigError {
    /// Which file.
    pub file: String,
    /// What is wrong, in the order of the file: at least one mistake.
    pub mistakes: Vec<Mistake>,
}

impl ConfigError {
    fn one(file: String, line: Option<usize>, words: String) -> Self {
        Self {
            file,
            mistakes: vec![Mistake { line, words }],
        }
    }

    /// Every mistake with its place, without what is done about it.
    pub fn mistakes_in_words(&self) -> impl Iterator<Item = String> {
        self.mistakes.iter().map(|mistake| {
            let line = mistake
                .line
                .map_or(String::new(), |line| format!(":{line}"));
            format!("{}{line}: {}", self.file, mistake.words)
        })
    }

    /// The first mistake, and in which lines there are others.
    #[must_use]
    pub fn in_short(&self) -> String {
        let first = self.mistakes_in_words().next().unwrap_or_default();
        let others = self.mistakes.iter().skip(1);
        let lines: Vec<String> = others
            .filter_map(|mistake| Some(mistake.line?.to_string()))
            .collect();
        match &lines[..] {
            [] => first,
            [one] => format!("{first} (and another error in line {one})"),
            more => format!("{first} (and more in lines {})", more.join(", ")),
        }
    }
}

impl Config {
    /// Reads a configuration file; one that does not exist says nothing.
    ///
    /// ```
    /// use nearmiss_settings::Config;
    ///
    /// let folder = tempfile::tempdir()?;
    /// let file = folder.path().join("config.toml");
    /// std::fs::write(&file, "modle = \"openai/gpt-6-luna\"")?;
    /// let error = Config::read(&file).unwrap_err().to_string();
    /// assert!(error.contains("config.toml:1: unknown key `modle`; did you mean `model`?"), "{error}");
    /// # Ok::<(), std::io::Error>(())
    /// ```
    ///
    /// # Errors
    /// It cannot be read, or says something that is not known or cannot be meant: every mistake with line and key.
    pub fn read(path: &Path) -> Result<Self, ConfigError> {
        let file = path.display().to_string();
        let text = match text_if_there(path) {
            Ok(Some(text)) => text,
            Ok(None) => return Ok(Self::default()),
            Err(why) => return Err(ConfigError::one(file, None, why)),
        };
        let mistakes = mistakes(&text);
        if !mistakes.is_empty() {
            return Err(ConfigError { file, mistakes });
        }
        // Every key alone can be used; were they not together, this says it.
        toml::from_str(&text).map_err(|error| {
            let words = error.message().trim().replace('\n', " ");
            ConfigError::one(file, None, words)
        })
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
        assert_eq!(error.mistakes.len(), 1);
        assert!(
            error
                .to_string()
                .contains("config.toml:2: unknown key `radios`"),
            "{error}"
        );
        for (wrong, key) in [
            ("theme = 3", "theme"),
            ("history = -1", "history"),
            ("effort = \"huge\"", "effort"),
            ("concurrency = 0", "concurrency"),
            ("attackers = 4", "attackers"),
            ("budget = -1.0", "budget"),
            ("editor = \"ed\"", "editor"),
            ("model = \"x\"", "model"),
            ("glyphs = \"emoji\"", "glyphs"),
        ] {
            std::fs::write(&path, format!("mouse = false\n{wrong}\n")).unwrap();
            let error = Config::read(&path).unwrap_err();
            assert!(
                error.mistakes[0].line == Some(2) && error.mistakes[0].words.starts_with(key),
                "{error}"
            );
        }
        std::fs::write(&path, "mouse = 1\ntheme = 2\nradius = 0\n").unwrap();
        let error = Config::read(&path).unwrap_err();
        assert_eq!(error.mistakes_in_words().count(), 3);
        assert!(
            error
                .to_string()
                .contains("(and more in lines 2, 3); using the defaults"),
            "{error}"
        );
        std::fs::write(
            &path,
            "mouse = false\n[provider.lab]\nbase_url = \"http://x\"\n",
        )
        .unwrap();
        assert!(!Config::read(&path).unwrap().mouse);
    }
}
