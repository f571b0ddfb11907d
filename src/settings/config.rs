//! `config.toml`: its keys with their meaning, bounds and defaults, and everything that is wrong with a file, with its line.

use std::num::NonZeroU32;
use std::path::{Path, PathBuf};

use nearmiss_base::system::{KeyLines, Mistake, available, toml_mistake};
use nearmiss_drive::generation::AttackStyle;
use nearmiss_record::fields::Fields;
use strum::{IntoStaticStr, VariantArray};
use toml::{Table, Value};

use super::folders::text_if_there;
use super::{measures, planner, tracks};

nearmiss_record::fields! {
    /// The configuration.
    pub struct Config {
        "config" {
            /// Theme [default: auto, dark or light to match the terminal background].
            theme: Option<String>;
            /// Character set: unicode or ascii [default: auto, from the locale].
            glyphs: Option<String>, Takes::OneOf(&["auto", "unicode", "ascii"]);
            /// Map drawing: pixels, cells, braille or ascii [default: auto, the best that the terminal supports].
            map: Option<String>, Takes::OneOf(&["auto", "pixels", "cells", "braille", "ascii"]);
            /// Block characters for a map of cells: quadrants, sextants or octants [default: auto, those that the
            /// terminal is known to draw].
            map_blocks: Option<String>, Takes::OneOf(&["auto", "quadrants", "sextants", "octants"]);
            /// Use the mouse [default: true].
            mouse: bool = true;
            /// Restore the workbench as it was left [default: true].
            session: bool = true;
            /// Key bindings of the template editor: plain, vim or emacs [default: plain].
            editor: Keys;
            /// First model to ask, as provider/model [default: reference/geometry, the built-in judge].
            model: Option<String>, Takes::Checked(provider_and_model);
            /// Steps in a window [default: from the template].
            history: Option<usize>, Takes::Whole(1, 100_000);
            /// Radius around the ego in metres within which obstacles are described; farther ones only if they can
            /// reach it soon [default: from the template].
            radius: Option<f64>, Takes::Above(0.0, 1e6), "m";
            /// Sampling temperature [default: from the template, else not sent].
            temperature: Option<f64>, Takes::Number(0.0, 2.0);
            /// Maximum number of tokens per answer [default: not sent].
            max_tokens: Option<u32>, Takes::Whole(1, 4_294_967_295);
            /// Reasoning effort of models: off, minimal, low, medium, high, xhigh or max [default: not sent].
            effort: Option<String>, Takes::OneOf(&["off", "minimal", "low", "medium", "high", "xhigh", "max"]);
            /// Let models call tools that compute [default: false].
            tools: bool;
            /// Request the log probabilities of answers from models that support them [default: false].
            log_probabilities: bool;
            /// Concurrent requests of a batch to each provider; `concurrency` of a provider applies as well [default:
            /// 4].
            concurrency: u32 = 4, Takes::Whole(1, 4_294_967_295);
            /// Limits of attacker motion in variants: human (what people do) or limit (what vehicles can) [default:
            /// human].
            attack_style: Option<AttackStyle>;
            /// Range in metres within which a model chooses attackers, ahead of the ego or beside it [default: 30].
            attack_within: f64 = 30.0, Takes::Above(0.0, 1e6), "m";
            /// Maximum number of obstacles that attack together, 1 to 3 [default: 1].
            attackers: Option<usize>, Takes::Whole(1, 3);
            /// Maximum cost of a command or a workbench session in US dollars [default: none].
            budget: Option<f64>, Takes::Above(0.0, 1e12);
            /// Name of the person who rates answers [default: the user name].
            person: Option<String>;
            /// Folder for saved pictures [default: the current folder].
            pictures: Option<PathBuf>;
            /// Index folder that the workbench opens with [default: none].
            index: Option<PathBuf>;
            /// Map file (Lanelet2 for drone recordings, GeoPackage for nuPlan), or a folder of them, for recordings
            /// without a map beside them [default: none].
            maps: Option<PathBuf>;
            /// Program that simulates OpenSCENARIO files without timed trajectories, or off [default: esmini, if on
            /// PATH].
            esmini: Option<String>;
        }
        "tables" {
            /// Language model providers, in addition to the built-in ones or overriding them.
            provider: toml::Table;
            /// Planner settings, and external planners by name; see `nearmiss help planners`.
            planner: toml::Table;
            /// Tables of tracks by name, with the role of each column; see `nearmiss help tracks`.
            tracks: toml::Table;
            /// Your own measures by id; see `nearmiss help measures`.
            measure: toml::Table;
        }
    }
}

/// A path that a file in this folder says; one that only the current folder has is of that, as all were before.
fn placed(folder: &Path, said: &Path) -> PathBuf {
    let beside = folder.join(said);
    if said.as_os_str().is_empty() || !beside.exists() && said.exists() {
        return said.to_path_buf();
    }
    beside
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
        let mut config: Self = toml::from_str(&text).map_err(|error| {
            let words = error.message().trim().replace('\n', " ");
            ConfigError::one(file, None, words)
        })?;
        if let Some(folder) = path.parent() {
            config.place_in(folder);
        }
        Ok(config)
    }

    /// What a file in this folder reads is relative to it, wherever the program runs; pictures are written where it runs.
    fn place_in(&mut self, folder: &Path) {
        let places = [&mut self.index, &mut self.maps];
        for place in places.into_iter().flatten() {
            *place = placed(folder, place);
        }
        let said = |text: &str| {
            placed(folder, Path::new(text))
                .to_string_lossy()
                .into_owned()
        };
        // A program without a folder is one of PATH.
        if let Some(program) = &mut self.esmini
            && Path::new(program.as_str()).components().count() > 1
        {
            *program = said(program);
        }
        let tables = self
            .tracks
            .iter_mut()
            .filter_map(|(_, table)| table.get_mut("map"));
        for map in tables {
            if let Value::String(map) = map {
                *map = said(map);
            }
        }
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

/// Keys of the template editor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "lowercase")]
pub enum Keys {
    /// Those of most programs: Ctrl-Z, Ctrl-X, Ctrl-V, selecting with Shift.
    #[default]
    Plain,
    /// Modes, as in vim.
    Vim,
    /// Ctrl-A, Ctrl-E, Ctrl-K, as in Emacs and shells.
    Emacs,
}

nearmiss_record::named!(Keys, "editor");

/// Everything that is wrong with a text, in its order; of a text that is no TOML, where it stops being one.
fn mistakes(text: &str) -> Vec<Mistake> {
    let table: Table = match toml::from_str(text) {
        Ok(table) => table,
        Err(error) => return vec![no_toml(text, &error)],
    };
    let lines = KeyLines::new(text);
    let section = |name: &str| table.get(name).and_then(Value::as_table);
    let of_planner = section("planner").map_or_else(Vec::new, planner::mistakes);
    let of_tracks = section("tracks").map_or_else(Vec::new, tracks::mistakes);
    let of_measures = section("measure").map_or_else(Vec::new, measures::mistakes);
    let inner = [
        ("planner", of_planner),
        ("tracks", of_tracks),
        ("measure", of_measures),
    ];
    let inner = inner.into_iter().flat_map(|(name, found)| {
        let mistake = |(path, words): (Vec<String>, String)| {
            let path = std::iter::once(name).chain(path.iter().map(String::as_str));
            let line = lines.line(&path.collect::<Vec<_>>());
            Mistake { line, words }
        };
        found.into_iter().map(mistake).collect::<Vec<_>>()
    });
    let mut found: Vec<Mistake> = inner.collect();
    found.extend(table.into_iter().filter_map(|(key, value)| {
        let words = wrong::<Config>("", &key, &value)?;
        let line = lines.line(&[&key]);
        Some(Mistake { line, words })
    }));
    found.sort_by_key(|mistake| mistake.line);
    found
}

/// What is wrong with a key of a table and its value, if anything is; `table` is the name of the table with its dot.
pub(super) fn wrong<F: Fields>(table: &str, key: &str, value: &Value) -> Option<String> {
    // What only a command line sets is no key of the file.
    let rows = || F::rows().iter().filter(|row| !row.is("run"));
    let Some(row) = rows().find(|row| row.key == key) else {
        let known: Vec<&str> = rows().map(|row| row.key).collect();
        return Some(format!(
            "unknown key `{table}{key}`{}",
            available(key, known)
        ));
    };
    let wrong = F::default().set(key, value).err()?;
    Some(format!(
        "{table}{key}{}",
        wrong.first(value, &row.expected())
    ))
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

    #[test]
    fn paths_are_relative_to_the_file_that_says_them() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("config.toml");
        let read = |text: &str| {
            std::fs::write(&path, text).unwrap();
            Config::read(&path).unwrap()
        };
        let config = read(
            "maps = \"lanelets\"\npictures = \"figures\"\nindex = \"/data/index\"\nesmini = \"./esmini\"\n\
             [tracks.lab]\ncolumns = \"time=t\"\nmap = \"../lab.osm\"\n",
        );
        let at = |name: &str| Some(folder.path().join(name));
        assert_eq!(config.maps, at("lanelets"));
        assert_eq!(config.pictures, Some("figures".into()), "where it runs");
        assert_eq!(config.index, Some("/data/index".into()));
        assert_eq!(config.esmini.as_deref().map(PathBuf::from), at("./esmini"));
        assert_eq!(config.track_tables()[0].1.map, at("../lab.osm"));
        // Tests run in the folder of the crate: a configuration of before goes on.
        assert_eq!(
            read("maps = \"Cargo.toml\"\n").maps,
            Some("Cargo.toml".into())
        );
        assert_eq!(read("maps = \"\"\n").maps, Some("".into()));
        let plain = read("esmini = \"off\"\n").esmini;
        assert_eq!(plain.as_deref(), Some("off"));
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
            "8: editor: unknown editor `ed`; available: plain, vim, emacs",
            "9: unknown key `qwrtz`; available: theme, glyphs,",
            "10: provider = a list: expected a table",
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
