//! `config.toml`: what it may say, and clear words for what it may not.

use std::num::NonZeroU32;
use std::path::{Path, PathBuf};

use super::Keys;
use super::text_file::text_if_there;
use super::validation::mistakes;
use nearmiss_base::system::Mistake;
use nearmiss_drive::generation::AttackStyle;

nearmiss_record::fields! {
    /// The configuration.
    pub struct Config {
        "config" {
            /// Name of the theme; by default auto: dark or light, as the terminal's background is.
            theme: Option<String>;
            /// Which signs are drawn; by default auto: what the locale says.
            glyphs: Option<String>, Takes::OneOf(&["auto", "unicode", "ascii"]);
            /// How the map is drawn; by default auto: the best that the terminal can do.
            map: Option<String>, Takes::OneOf(&["auto", "pixels", "cells", "braille", "ascii"]);
            /// Block characters of the map as cells; by default auto: those that the terminal is known to draw.
            map_blocks: Option<String>, Takes::OneOf(&["auto", "quadrants", "sextants", "octants"]);
            /// Whether the mouse is used.
            mouse: bool = true;
            /// Whether the workbench comes back as it was left.
            session: bool = true;
            /// Keys of the template editor.
            editor: Keys;
            /// The model asked first, as provider/model; by default the built-in judge, reference/geometry.
            model: Option<String>, Takes::Checked(provider_and_model);
            /// Steps of history in a window; by default the template's.
            history: Option<usize>, Takes::Whole(1, 100_000);
            /// Obstacles farther from the ego than this are not described; by default the template's.
            radius: Option<f64>, Takes::Above(0.0, 1e6), "m";
            /// Sampling temperature sent to models; by default the template's, else it is not sent.
            temperature: Option<f64>, Takes::Number(0.0, 2.0);
            /// Most tokens an answer may have; by default it is not sent.
            max_tokens: Option<u32>, Takes::Whole(1, 4_294_967_295);
            /// How much models are to reason; by default it is not sent.
            effort: Option<String>, Takes::OneOf(&["off", "minimal", "low", "medium", "high", "xhigh", "max"]);
            /// Whether models may call tools that compute.
            tools: bool;
            /// Whether the log probabilities of answers are asked for, where a model gives them.
            log_probabilities: bool;
            /// Requests of a batch that may be on their way to one provider at once; its own `concurrency` holds too.
            concurrency: u32 = 4, Takes::Whole(1, 4_294_967_295);
            /// How attackers of variants move; by default human: within what people do.
            attack_style: Option<AttackStyle>;
            /// A model chooses attackers among obstacles this near ahead of the ego or beside it.
            attack_within: f64 = 30.0, Takes::Above(0.0, 1e6), "m";
            /// At most so many obstacles of a variant attack together; by default 1.
            attackers: Option<usize>, Takes::Whole(1, 3);
            /// Most US dollars that one session of the workbench, or one `ask`, may cost; by default there is no bound.
            budget: Option<f64>, Takes::Above(0.0, 1e12);
            /// Who rates answers; by default the user's name.
            person: Option<String>;
            /// Where pictures are saved; by default the current folder.
            pictures: Option<PathBuf>;
            /// Folder of the index that the workbench opens with; by default none.
            index: Option<PathBuf>;
            /// A map (Lanelet2 of drone recordings, GeoPackage of nuPlan), or a folder of them, for recordings whose map
            /// does not lie with them; by default none.
            maps: Option<PathBuf>;
        }
        "tables" {
            /// Providers of language models, beside and over the built-in ones.
            provider: toml::Table;
            /// How motions are planned, as the file says it; see [`Config::planning`].
            planner: toml::Table;
        }
    }
}

fn provider_and_model(id: &str) -> Result<(), String> {
    match id.split_once('/') {
        Some((provider, model)) if !provider.is_empty() && !model.is_empty() => Ok(()),
        _ => Err("expected provider/model, such as \"openai/gpt-6-luna\"".into()),
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

    /// Requests of a batch to one provider at once.
    #[must_use]
    pub fn at_once(&self) -> NonZeroU32 {
        NonZeroU32::new(self.concurrency).unwrap_or(NonZeroU32::MIN)
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
