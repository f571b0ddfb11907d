//! Where the user's configuration and data lie, and texts in files there.

use std::io::{Error, ErrorKind};
use std::path::{Path, PathBuf};

use etcetera::BaseStrategy;

use nearmiss_base::system::{self, SaveError};
use nearmiss_scene::metrics::Thresholds;

/// The name of the store.
const STORE: &str = "runs.sqlite";

/// The two folders of the program; neither is made before something is written there.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Folders {
    /// Configuration: `config.toml`, `prices.toml`, `keymap.toml`, `thresholds.toml`, `prompts/`, `themes/`.
    pub config: PathBuf,
    /// Data: the store, drafts, sessions.
    pub data: PathBuf,
}

/// Files and folders of the user's, each with the folder that it is in.
macro_rules! places {
    ($($(#[$of:meta])+ $name:ident: $folder:ident / $file:expr;)+) => {
        impl Folders {$(
            $(#[$of])+
            #[must_use]
            pub fn $name(&self) -> PathBuf {
                self.$folder.join($file)
            }
        )+}
    };
}

places! {
    /// The configuration file.
    config_file: config / "config.toml";
    /// The user's thresholds.
    thresholds: config / "thresholds.toml";
    /// The user's keys.
    keymap: config / "keymap.toml";
    /// The user's prompt templates.
    prompts: config / "prompts";
    /// The user's themes.
    themes: config / "themes";
    /// Drafts of templates that were not saved.
    drafts: data / "drafts";
    /// The user's tags of scenarios.
    tags: data / "tags.toml";
    /// The user's saved views of the list of scenarios.
    views: data / "views.toml";
    /// What the workbench looked like when it was left.
    sessions: data / "sessions";
    /// Egos that planners drove, for other commands.
    drives: data / "drives";
    /// Reports of crashes.
    crashes: data / "crashes";
    /// What running programs are trying, and what ended one.
    marks: data / "marks";
    /// The database of runs.
    store: data / STORE;
}

impl Folders {
    /// The same with another folder for data.
    #[must_use]
    pub fn with_data(self, data: &Path) -> Self {
        Self {
            data: data.to_path_buf(),
            ..self
        }
    }

    /// `NEARMISS_CONFIG` and `NEARMISS_DATA` where they are set, else the system's usual places.
    ///
    /// # Errors
    /// The home folder cannot be found.
    pub fn find() -> Result<Self, String> {
        let given = |name: &str| {
            std::env::var_os(name)
                .filter(|v| !v.is_empty())
                .map(PathBuf::from)
        };
        let (config, data) = (given("NEARMISS_CONFIG"), given("NEARMISS_DATA"));
        if let (Some(config), Some(data)) = (&config, &data) {
            return Ok(Self {
                config: config.clone(),
                data: data.clone(),
            });
        }
        let system = etcetera::choose_base_strategy().map_err(|error| {
            format!("{error}; set NEARMISS_CONFIG and NEARMISS_DATA to folders of your choice")
        })?;
        Ok(Self {
            config: config.unwrap_or_else(|| system.config_dir().join("nearmiss")),
            data: data.unwrap_or_else(|| system.data_dir().join("nearmiss")),
        })
    }

    /// The shipped thresholds, changed by that file if there is one.
    ///
    /// # Errors
    /// The file cannot be read or is wrong, with its line.
    pub fn user_thresholds(&self) -> Result<Thresholds, String> {
        read_thresholds(&self.thresholds())
    }

    /// Recordings that esmini made, which it can make again: in the system's cache, or with the data where the user said
    /// where these are.
    #[must_use]
    pub fn played(&self) -> PathBuf {
        let system = etcetera::choose_base_strategy().ok();
        let usual = system.filter(|system| self.data.starts_with(system.data_dir()));
        let cache = usual.map(|system| system.cache_dir().join("nearmiss"));
        cache.as_ref().unwrap_or(&self.data).join("played")
    }

    /// Writes a file of the user's, whole or not at all, for them alone.
    ///
    /// # Errors
    /// The folder cannot be made or the file not written; the old file is untouched then.
    pub fn write(path: &Path, text: &str) -> std::io::Result<()> {
        if let Some(folder) = path.parent() {
            system::make_folder(folder)?;
        }
        system::save_private(path, text.as_bytes()).map_err(|error| match error {
            SaveError::Io { source, .. } => source,
            other => Error::other(other.to_string()),
        })
    }

    /// Takes from others what an older program let them read: the data folder where nothing but the program's own lies
    /// in it, drafts, sessions and tags, and the file with keys beside the configuration. The store sees to its own
    /// files.
    pub fn close(&self) {
        system::close_file(&self.config.join(".env"));
        system::close_file(&self.tags());
        system::close_file(&self.views());
        for folder in [self.drafts(), self.sessions()] {
            for entry in std::fs::read_dir(&folder).into_iter().flatten().flatten() {
                system::close_file(&entry.path());
            }
            system::close_folder(&folder, |_| true);
        }
        system::close_folder(&self.data, is_ours);
    }
}

/// Whether the program itself puts something of this name into the data folder.
fn is_ours(name: &str) -> bool {
    let own = [
        "crashes",
        "drafts",
        "drives",
        "marks",
        "played",
        "sessions",
        "tags.toml",
        "views.toml",
        STORE,
    ];
    let beside = name.strip_prefix(STORE);
    let unstored = name.starts_with("unstored-") && name.ends_with(".jsonl");
    own.contains(&name)
        || unstored
        || beside.is_some_and(|end| ["-wal", "-shm", "-journal"].contains(&end))
}

/// The shipped thresholds, changed by this file if it is there.
///
/// # Errors
/// The file cannot be read or is wrong, with its line.
pub fn read_thresholds(path: &Path) -> Result<Thresholds, String> {
    match TextFile::read_if_there(path)? {
        Some(said) => Thresholds::read(&said.text, &said.file).map_err(|error| error.to_string()),
        None => Ok(Thresholds::shipped().clone()),
    }
}

/// A text with the name of its file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TextFile {
    /// Where it is from, for people.
    pub file: String,
    /// What is in it.
    pub text: String,
}

/// No file that a person wrote by hand is larger, bytes.
const MAX_BYTES: u64 = 1 << 20;

impl TextFile {
    /// Reads a regular file of up to 1 MiB.
    ///
    /// # Errors
    /// It cannot be read, is larger, or is no UTF-8: with its name.
    pub fn read(path: &Path) -> Result<Self, String> {
        let file = path.display().to_string();
        match text(path) {
            Ok(text) => Ok(Self { file, text }),
            Err(error) => Err(format!("{file}: {error}")),
        }
    }

    /// Reads a file if it is there.
    ///
    /// # Errors
    /// Like [`Self::read`], but for a file that does not exist.
    pub fn read_if_there(path: &Path) -> Result<Option<Self>, String> {
        let file = path.display().to_string();
        match text_if_there(path) {
            Ok(text) => Ok(text.map(|text| Self { file, text })),
            Err(error) => Err(format!("{file}: {error}")),
        }
    }
}

/// What is in a file if it is there; errors do not name it.
pub(super) fn text_if_there(path: &Path) -> Result<Option<String>, String> {
    match std::fs::symlink_metadata(path) {
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
        _ => text(path).map(Some),
    }
}

fn text(path: &Path) -> Result<String, String> {
    let bytes = system::read_file(path, MAX_BYTES).map_err(|error| system::error_text(&error))?;
    system::text_of(bytes)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[cfg(unix)]
    #[test]
    fn what_others_could_read_is_closed() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let folders = Folders {
            config: folder.path().join("config"),
            data: folder.path().join("data"),
        };
        let files = [
            folders.config.join(".env"),
            folders.drafts().join("collision-ego.md"),
            folders.sessions().join("bundled.json"),
            folders.tags(),
        ];
        for file in &files {
            std::fs::create_dir_all(file.parent().unwrap()).unwrap();
            std::fs::write(file, "x").unwrap();
        }
        let own = [folders.drafts(), folders.sessions(), folders.data.clone()];
        let set = |path: &PathBuf, mode| {
            std::fs::set_permissions(path, std::fs::Permissions::from_mode(mode)).unwrap();
        };
        files.iter().for_each(|file| set(file, 0o644));
        own.iter().for_each(|folder| set(folder, 0o755));
        folders.close();
        let mode = |path: &PathBuf| path.metadata().unwrap().permissions().mode() & 0o777;
        assert_eq!(files.each_ref().map(mode), [0o600; 4]);
        assert_eq!(own.each_ref().map(mode), [0o700; 3]);
        // A folder of the user's that the data lie in among others.
        std::fs::write(folders.data.join("thesis.tex"), "x").unwrap();
        set(&folders.data, 0o755);
        folders.close();
        assert_eq!(mode(&folders.data), 0o755);
    }

    #[test]
    fn writes_replace_whole_files() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a/b.md");
        Folders::write(&path, "one").unwrap();
        Folders::write(&path, "two").unwrap();
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "two");
        assert_eq!(
            std::fs::read_dir(path.parent().unwrap()).unwrap().count(),
            1
        );
    }

    #[test]
    fn what_is_there_is_read_and_what_cannot_be_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t.toml");
        assert_eq!(TextFile::read_if_there(&path), Ok(None));
        assert!(TextFile::read(&path).unwrap_err().contains("t.toml: "));
        std::fs::write(&path, "a = 1").unwrap();
        assert_eq!(TextFile::read(&path).unwrap().text, "a = 1");
        std::fs::write(&path, [0xff]).unwrap();
        assert!(
            TextFile::read_if_there(&path)
                .unwrap_err()
                .contains("UTF-8")
        );
        std::fs::write(&path, vec![b' '; 1 + (1 << 20)]).unwrap();
        assert!(TextFile::read(&path).unwrap_err().contains("1 MiB"));
        assert!(
            TextFile::read(folder.path())
                .unwrap_err()
                .contains("folder")
        );
    }
}
