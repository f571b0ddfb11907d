//! The session: workbench state kept from one start to the next, and its file.
//!
//! Every set of paths has its own file, so sessions do not mix.

pub mod file;
pub mod restore;

use std::collections::HashSet;
use std::path::{Component, Path, PathBuf};

use nearmiss_base::system::crash::Subject;
use nearmiss_formats::{Entry, EntryLocation};
use nearmiss_scene::scenario::ContentHash;
use serde::{Deserialize, Serialize};

use crate::model::{Layers, Sizes};

/// The version of the files that are written.
const VERSION: u32 = 1;

/// Saved state of the workbench.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Session {
    /// The version of the file.
    pub version: u32,
    /// Paths the workbench was started with, in order; empty for the bundled scenarios.
    pub paths: Vec<SavedLocation>,
    /// The task.
    pub task: String,
    /// The frame.
    pub frame: String,
    /// The techniques, where they were chosen.
    pub techniques: Option<String>,
    /// Whether models may call tools, `on` or `off`, where it is not as the configuration says. Older sessions do not say.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tools: Option<Override>,
    /// The model, where it is not the one of the configuration.
    pub model: Option<Override>,
    /// The theme, where it is not the one of the configuration.
    pub theme: Option<Override>,
    /// The pane that has the keys.
    pub focus: String,
    /// Whether it is shown alone.
    pub zoomed: bool,
    /// The filter of the list.
    pub filter: String,
    /// By what the list is sorted, and whether the other way around.
    pub sort: (String, bool),
    /// By what it is grouped.
    pub group: String,
    /// The measure that is plotted.
    pub plot: String,
    /// The marked scenarios, in order.
    pub marks: Vec<SavedLocation>,
    /// How big the panes are.
    pub sizes: Sizes,
    /// The layers of the map.
    pub layers: Layers,
    /// Whether the map is split in two.
    #[serde(default, skip_serializing_if = "is_off")]
    pub split_map: bool,
    /// Experiment files that were opened, the last one first.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub experiments: Vec<PathBuf>,
    /// The folder of the index, where it is not the one of the configuration; empty for none. Older sessions do not say.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub index: Option<Override>,
    /// The opened scenario.
    pub opened: Option<SavedScenario>,
}

/// The opened scenario and how it was looked at.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SavedScenario {
    /// Which one.
    pub scenario: SavedLocation,
    /// The obstacle that was taken as its ego.
    pub ego: Option<i64>,
    /// The time step; none where a variant was open, which has steps of its own: then the scenario opens anew.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub step: Option<i64>,
    /// The picked obstacle.
    pub picked: Option<i64>,
    /// The step that the second map was pinned to.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pinned: Option<i64>,
    /// How the map was seen.
    pub camera: View,
}

/// Saved camera of the map; metres.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct View {
    /// Width of a cell.
    pub cell: f64,
    /// The middle.
    pub center: [f64; 2],
    /// The middle seen from the ego.
    pub shift: [f64; 2],
    /// Whether the ego is followed.
    pub follow: bool,
    /// The direction that is up on a map that is turned and does not follow the ego.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub up: Option<f64>,
    /// Whether the map turns with the ego.
    pub ego_up: bool,
    /// Whether the map chooses its zoom; older sessions do not say, so that what was seen stays.
    #[serde(default)]
    pub auto: bool,
}

/// Location of a scenario or folder.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum SavedLocation {
    /// A file or folder, from the root.
    File(PathBuf),
    /// A bundled scenario, by its name.
    Bundled(String),
}

/// A choice that overrides the configuration value of its time.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Override {
    /// The chosen value.
    pub chosen: String,
    /// The configured value at that time; `None` without one.
    pub of: Option<String>,
}

impl SavedLocation {
    /// Where an entry lies, of a program that was started in the folder `here`. Links are not followed.
    #[must_use]
    pub fn from_entry(entry: &Entry, here: &Path) -> Self {
        match &entry.place {
            EntryLocation::File(path) => Self::File(plain(&here.join(path))),
            EntryLocation::Bundled(_) => Self::Bundled(entry.name.clone()),
        }
    }

    /// The same scenario at the next start, for what ended the program.
    #[must_use]
    pub fn subject(&self) -> Subject {
        match self {
            Self::File(path) => Subject::scenario(&path.display().to_string()),
            Self::Bundled(name) => Subject::scenario(&format!("{name} (bundled)")),
        }
    }

    /// The paths that the workbench is started with, each once and in order. Looks at the disk: they are the same by
    /// another name of a folder on their way, too.
    #[must_use]
    pub fn of_arguments(paths: &[PathBuf], here: &Path) -> Vec<Self> {
        let wheres = paths.iter().map(|path| {
            let lies = Self::from_entry(&Entry::of_argument(path), here);
            match &lies {
                Self::File(file) => file.canonicalize().map_or(lies, Self::File),
                Self::Bundled(_) => lies,
            }
        });
        let mut all: Vec<Self> = wheres.collect();
        all.sort();
        all.dedup();
        all
    }
}

/// What is off is not written, so that older versions can read the file.
#[allow(clippy::trivially_copy_pass_by_ref, reason = "as serde calls it")]
fn is_off(on: &bool) -> bool {
    !on
}

/// A path without detours.
fn plain(path: &Path) -> PathBuf {
    let mut plain = PathBuf::new();
    for part in path.components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir => drop(plain.pop()),
            part => plain.push(part),
        }
    }
    plain
}

impl Override {
    /// The choice, if the configuration still has the value that it overrode.
    #[must_use]
    pub fn still(&self, of: Option<&String>) -> Option<&str> {
        (self.of.as_ref() == of).then_some(self.chosen.as_str())
    }

    /// The choice, if it differs from the configuration.
    #[must_use]
    pub fn chosen(chosen: &str, of: Option<&String>, usual: &str) -> Option<Self> {
        let said = of.map_or(usual, String::as_str);
        (said != chosen).then(|| Self {
            chosen: chosen.to_string(),
            of: of.cloned(),
        })
    }
}

impl Default for Session {
    fn default() -> Self {
        Self {
            version: VERSION,
            paths: Vec::new(),
            task: String::new(),
            frame: String::new(),
            techniques: None,
            tools: None,
            model: None,
            theme: None,
            focus: String::new(),
            zoomed: false,
            filter: String::new(),
            sort: (String::new(), false),
            group: String::new(),
            plot: String::new(),
            marks: Vec::new(),
            sizes: Sizes::default(),
            layers: Layers::default(),
            split_map: false,
            experiments: Vec::new(),
            index: None,
            opened: None,
        }
    }
}

impl Session {
    /// The name of the file of these paths.
    #[must_use]
    pub fn file_name(paths: &[SavedLocation]) -> String {
        if paths.is_empty() {
            return "bundled.json".into();
        }
        let said = format!("{paths:?}");
        let hash = ContentHash::digest(said.as_bytes()).to_string();
        format!("{}.json", &hash[..16])
    }

    /// The text of its file.
    ///
    /// # Errors
    /// A path is no text.
    pub fn text(&self) -> Result<String, String> {
        let text = serde_json::to_string_pretty(self).map_err(|error| error.to_string())?;
        Ok(text + "\n")
    }

    /// Reads the text of the file of these paths.
    ///
    /// # Errors
    /// The text is no session, of another version, or of other paths.
    pub fn parse(text: &str, paths: &[SavedLocation]) -> Result<Self, String> {
        let value: serde_json::Value =
            serde_json::from_str(text).map_err(|error| format!("it is damaged ({error})"))?;
        let version = value.get("version").and_then(serde_json::Value::as_u64);
        if version != Some(u64::from(VERSION)) {
            return Err("another version of nearmiss wrote it".into());
        }
        let session: Self =
            serde_json::from_value(value).map_err(|error| format!("it is damaged ({error})"))?;
        if session.paths != paths {
            return Err("it belongs to other scenarios".into());
        }
        let of = |instead: &Option<Override>| instead.as_ref().map(|i| i.chosen.clone());
        let words = [
            of(&session.tools),
            of(&session.model),
            of(&session.theme),
            of(&session.index),
            Some(session.filter.clone()),
        ];
        if words
            .iter()
            .flatten()
            .any(|word| word.chars().any(char::is_control))
        {
            return Err("it is damaged (there are control characters in it)".into());
        }
        Ok(session)
    }
}

/// State of session saving and restoring.
#[derive(Debug, Default)]
pub struct SessionState {
    /// Whether this session is kept.
    pub on: bool,
    /// The folder that the program was started in.
    pub here: PathBuf,
    /// Paths the workbench was started with.
    pub paths: Vec<SavedLocation>,
    /// Scenarios of the list that were looked at for what has yet to come back.
    pub seen: usize,
    /// Marked scenarios that are not found again yet.
    pub marks: HashSet<SavedLocation>,
    /// The scenario that was open last time, until it is open again or another one is chosen.
    pub wanted: Option<SavedScenario>,
    /// The session last saved.
    pub kept: Option<Box<Session>>,
    /// Whether something may have changed since.
    pub changed: bool,
    /// Whether keeping is already asked for.
    pub asked: bool,
    /// Whether a first-time user sees the hint towards a verdict.
    pub hint: bool,
}
