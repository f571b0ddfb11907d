//! Selects one of several templates for a task and frame: `chosen.toml` in the user's folder.

use std::collections::BTreeMap;
use std::io::{ErrorKind, Result as IoResult};
use std::path::Path;

use nearmiss_base::system::{self, SaveError};

/// Its name.
pub const FILE: &str = "chosen.toml";

/// Larger files are not read, bytes.
const LARGEST: u64 = 1 << 16;

/// Files of templates, by task and frame.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct TemplateChoices(BTreeMap<String, BTreeMap<String, String>>);

impl TemplateChoices {
    /// What was chosen; nothing where there is no file.
    ///
    /// # Errors
    /// The file cannot be read, or is not tables of tasks with files by frame: with the line.
    pub fn read(folder: &Path) -> Result<Self, String> {
        let bytes = match system::read_file(&folder.join(FILE), LARGEST) {
            Ok(bytes) => bytes,
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(Self::default()),
            Err(error) => return Err(system::error_text(&error)),
        };
        let text = system::text_of(bytes)?;
        toml::from_str(&text).map(Self).map_err(|error| {
            let line = system::line_at(&text, error.span().map_or(0, |span| span.start));
            format!("line {line}: {}", error.message().trim())
        })
    }

    /// The file for a task and a frame.
    #[must_use]
    pub fn get(&self, task: &str, frame: &str) -> Option<&str> {
        Some(self.0.get(task)?.get(frame)?.as_str())
    }

    /// Every choice: task, frame, file.
    #[must_use]
    pub fn all(&self) -> Vec<(String, String, String)> {
        let all = self.0.iter().flat_map(|(task, files)| {
            let of =
                |(frame, file): (&String, &String)| (task.clone(), frame.clone(), file.clone());
            files.iter().map(of)
        });
        all.collect()
    }

    /// Chooses a file, or the usual one.
    pub fn set(&mut self, task: &str, frame: &str, file: Option<&str>) {
        let files = self.0.entry(task.to_string()).or_default();
        match file {
            Some(file) => drop(files.insert(frame.to_string(), file.to_string())),
            None => drop(files.remove(frame)),
        }
        self.0.retain(|_, files| !files.is_empty());
    }

    fn write(&self, folder: &Path) -> IoResult<()> {
        let text = toml::to_string(&self.0).map_err(std::io::Error::other)?;
        system::make_folder(folder)?;
        let saved = system::save(&folder.join(FILE), text.as_bytes(), true);
        saved.map_err(|error| match error {
            SaveError::Io { source, .. } => source,
            other => std::io::Error::other(other.to_string()),
        })
    }
}

/// Chooses a template in the user's folder, for good.
///
/// # Errors
/// What was chosen before cannot be read, or the file not written; nothing changes then.
pub fn choose_template(folder: &Path, task: &str, frame: &str, file: &str) -> Result<(), String> {
    let path = folder.join(FILE);
    let named = |words: String| format!("{}: {words}", path.display());
    let mut chosen = TemplateChoices::read(folder).map_err(named)?;
    chosen.set(task, frame, Some(file));
    chosen
        .write(folder)
        .map_err(|error| named(system::error_text(&error)))
}
