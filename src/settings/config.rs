//! `config.toml`: what it may say, and clear words for what it may not.

use std::path::{Path, PathBuf};

use nearmiss_base::system::{KeyLines, Mistake, nearest, toml_mistake};
use serde::Deserialize;
use strum::{IntoStaticStr, VariantArray};
use toml::{Table, Value};

use super::planner;
use super::user_files::text_if_there;
use super::values::KEYS;

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

/// Keys of the template editor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "lowercase")]
#[serde(rename_all = "lowercase")]
pub enum Keys {
    /// Those of most programs: Ctrl-Z, Ctrl-X, Ctrl-V, selecting with Shift.
    #[default]
    Plain,
    /// Modes, as in vim.
    Vim,
    /// Ctrl-A, Ctrl-E, Ctrl-K, as in Emacs and shells.
    Emacs,
}

nearmiss_record::named!(Keys);

/// Everything that is wrong with a text, in its order; of a text that is no TOML, where it stops being one.
fn mistakes(text: &str) -> Vec<Mistake> {
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
