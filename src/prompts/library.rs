//! All templates: shipped with the program, and the user's, which override them by file name.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::{Template, TemplateError};
use crate::system;

/// A file that comes with the program.
#[derive(Debug, Clone, Copy)]
pub struct Shipped {
    /// File name.
    pub file: &'static str,
    /// Its text.
    pub source: &'static str,
}

/// Files of `prompts/`, by name.
macro_rules! shipped {
    ($($file:literal),+ $(,)?) => {
        &[$(Shipped {
            file: $file,
            source: include_str!(concat!("../../prompts/", $file)),
        }),+]
    };
}

const SHIPPED: &[Shipped] = shipped![
    "_answer-collision.md",
    "_answer-safety.md",
    "_risk.md",
    "collision-cartesian.md",
    "collision-ego.md",
    "safety-cartesian.md",
    "safety-ego.md",
];

/// Where a template comes from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Origin {
    /// With the program.
    Shipped,
    /// From the user's folder.
    User(PathBuf),
}

/// A file of the user that is not in use, and why.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Problem {
    /// Which file.
    pub path: PathBuf,
    /// What is wrong, with the line.
    pub message: String,
}

/// The templates and the fragments that they include.
#[derive(Debug, Clone, Default)]
pub struct Library {
    templates: BTreeMap<String, (Template, Origin)>,
    fragments: BTreeMap<String, String>,
    /// Files of the user that could not be used; the shipped ones stay in their place.
    pub problems: Vec<Problem>,
}

impl Library {
    /// The shipped templates, overridden by those in `folder` (files ending in `.md`).
    #[must_use]
    pub fn load(folder: Option<&Path>) -> Self {
        let mut library = Self::default();
        for shipped in SHIPPED {
            // The shipped files are read by a test, so none is dropped here.
            let _ = library.put(shipped.file, shipped.source, Origin::Shipped);
        }
        if let Some(folder) = folder {
            library.overlay(folder);
        }
        library
    }

    fn overlay(&mut self, folder: &Path) {
        let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
        let mut paths: Vec<PathBuf> = entries.map(|e| e.path()).collect();
        paths.retain(|p| p.extension().is_some_and(|x| x == "md"));
        paths.sort();
        for path in paths {
            let name = path.file_name().map(|n| n.to_string_lossy().into_owned());
            let read = std::fs::read_to_string(&path).map_err(|e| system::words(&e));
            let put = read.and_then(|source| {
                let name = name.unwrap_or_default();
                self.put(&name, &source, Origin::User(path.clone()))
                    .map_err(|e| e.to_string())
            });
            if let Err(message) = put {
                self.problems.push(Problem { path, message });
            }
        }
    }

    fn put(&mut self, file: &str, source: &str, origin: Origin) -> Result<(), TemplateError> {
        if file.starts_with('_') {
            self.fragments.insert(file.to_string(), source.to_string());
        } else {
            self.templates
                .insert(file.to_string(), (Template::read(source)?, origin));
        }
        Ok(())
    }

    /// The template for a task and a frame; a user's before a shipped one.
    #[must_use]
    pub fn find(&self, task: &str, frame: &str) -> Option<(&str, &Template)> {
        let fits = |t: &Template| t.front.task == task && t.front.frame == frame;
        let found = self.templates.iter().filter(|(_, (t, _))| fits(t));
        found
            .max_by_key(|(_, (_, origin))| matches!(origin, Origin::User(_)))
            .map(|(file, (template, _))| (file.as_str(), template))
    }

    /// The template in a file.
    #[must_use]
    pub fn file(&self, file: &str) -> Option<(&Template, &Origin)> {
        self.templates
            .get(file)
            .map(|(template, origin)| (template, origin))
    }

    /// The shipped text of a file.
    #[must_use]
    pub fn shipped(file: &str) -> Option<&'static str> {
        SHIPPED.iter().find(|s| s.file == file).map(|s| s.source)
    }

    /// Files and templates, by file name.
    pub fn templates(&self) -> impl Iterator<Item = (&str, &Template, &Origin)> {
        self.templates
            .iter()
            .map(|(file, (template, origin))| (file.as_str(), template, origin))
    }

    /// The fragments that templates include, by file name.
    #[must_use]
    pub fn fragments(&self) -> &BTreeMap<String, String> {
        &self.fragments
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn every_shipped_file_is_read_and_every_file_is_shipped() {
        let library = Library::load(None);
        assert_eq!(
            library.templates().count() + library.fragments().len(),
            SHIPPED.len()
        );
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("prompts");
        let mut files: Vec<String> = std::fs::read_dir(folder)
            .unwrap()
            .map(|e| e.unwrap().file_name().into_string().unwrap())
            .collect();
        files.sort();
        assert_eq!(files, SHIPPED.iter().map(|s| s.file).collect::<Vec<_>>());
    }

    #[test]
    fn the_users_file_overrides_and_a_broken_one_does_not() {
        let folder = tempfile::tempdir().unwrap();
        let mine = Library::shipped("collision-ego.md")
            .unwrap()
            .replace("version = \"1\"", "version = \"mine\"");
        std::fs::write(folder.path().join("collision-ego.md"), mine).unwrap();
        std::fs::write(folder.path().join("safety-ego.md"), "no front matter").unwrap();
        let library = Library::load(Some(folder.path()));
        assert_eq!(
            library.find("collision", "ego").unwrap().1.front.version,
            "mine"
        );
        let kept = &library.find("safety", "ego").unwrap().1.source;
        assert_eq!(Some(kept.as_str()), Library::shipped("safety-ego.md"));
        assert_eq!(library.problems.len(), 1);
    }
}
