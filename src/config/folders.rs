//! Where the user's configuration and data lie.

use std::path::{Path, PathBuf};

use etcetera::BaseStrategy;

/// The two folders of the program; neither is made before something is written there.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Folders {
    /// Configuration: `config.toml`, `keymap.toml`, `thresholds.toml`, `prompts/`, `themes/`.
    pub config: PathBuf,
    /// Data: the store, drafts, sessions.
    pub data: PathBuf,
}

impl Folders {
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

    /// The configuration file.
    #[must_use]
    pub fn config_file(&self) -> PathBuf {
        self.config.join("config.toml")
    }

    /// The user's thresholds.
    #[must_use]
    pub fn thresholds(&self) -> PathBuf {
        self.config.join("thresholds.toml")
    }

    /// The user's keys.
    #[must_use]
    pub fn keymap(&self) -> PathBuf {
        self.config.join("keymap.toml")
    }

    /// The user's prompt templates.
    #[must_use]
    pub fn prompts(&self) -> PathBuf {
        self.config.join("prompts")
    }

    /// The user's themes.
    #[must_use]
    pub fn themes(&self) -> PathBuf {
        self.config.join("themes")
    }

    /// Drafts of templates that were not saved.
    #[must_use]
    pub fn drafts(&self) -> PathBuf {
        self.data.join("drafts")
    }

    /// The user's tags of scenarios.
    #[must_use]
    pub fn tags(&self) -> PathBuf {
        self.data.join("tags.toml")
    }

    /// What the workbench looked like when it was left.
    #[must_use]
    pub fn sessions(&self) -> PathBuf {
        self.data.join("sessions")
    }

    /// The database of runs.
    #[must_use]
    pub fn store(&self) -> PathBuf {
        self.data.join("runs.sqlite")
    }

    /// Writes a file of the user's, whole or not at all.
    ///
    /// # Errors
    /// The folder cannot be made or the file not written; the old file is untouched then.
    pub fn write(path: &Path, text: &str) -> std::io::Result<()> {
        let folder = path.parent().unwrap_or(Path::new("."));
        std::fs::create_dir_all(folder)?;
        let mut name = path.file_name().unwrap_or_default().to_os_string();
        name.push(format!(".{}.new", std::process::id()));
        let new = folder.join(name);
        std::fs::write(&new, text)
            .and_then(|()| std::fs::rename(&new, path))
            .inspect_err(|_| drop(std::fs::remove_file(&new)))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

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
}
