//! All templates: shipped with the program, and the user's, which override them by file name.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::render::syntax;
use super::{Template, TemplateError, includes};
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
    "_answer.md",
    "_cartesian.md",
    "_critical.md",
    "_ego.md",
    "_metrics.md",
    "_risk.md",
    "attacker-ego.md",
    "attacker-metrics.md",
    "collision-cartesian.md",
    "collision-ego.md",
    "collision-metrics.md",
    "safety-cartesian.md",
    "safety-ego.md",
    "safety-metrics.md",
    "trajectory.md",
];

/// Where a template comes from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Origin {
    /// With the program.
    Shipped,
    /// From the user's folder.
    User(PathBuf),
}

impl Origin {
    fn path(&self) -> Option<&Path> {
        match self {
            Self::Shipped => None,
            Self::User(path) => Some(path),
        }
    }
}

/// A file of the user that is not in use, and why.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Problem {
    /// Which file.
    pub path: PathBuf,
    /// What is wrong, with the line.
    pub message: String,
    /// What is in use in its place.
    pub instead: Instead,
}

/// What is in use instead of a broken file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Instead {
    /// The shipped file of the same name.
    Shipped,
    /// The user's own file, as it was when it could last be read.
    LastGood,
    /// Nothing: there is no other file of that name.
    Nothing,
}

impl std::fmt::Display for Problem {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let instead = match self.instead {
            Instead::Shipped => "the shipped template is used instead",
            Instead::LastGood => "its last good version stays in use",
            Instead::Nothing => "it is not used",
        };
        write!(f, "{}: {}; {instead}", self.path.display(), self.message)
    }
}

/// The templates and the fragments that they include.
#[derive(Debug, Clone, Default)]
pub struct Library {
    templates: BTreeMap<String, (Template, Origin)>,
    fragments: BTreeMap<String, String>,
    fragment_origins: BTreeMap<String, Origin>,
    /// Files of the user that could not be used.
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

    /// What is wrong with the user's versions of a template and of what it includes, or with their folder.
    pub fn problems_of<'l>(
        &'l self,
        file: &'l str,
        template: &'l Template,
    ) -> impl Iterator<Item = &'l Problem> {
        let included = includes::included(&template.source, &self.fragments);
        let fragments = included
            .into_iter()
            .map(|name| self.fragments[name].as_str());
        let texts: Vec<&str> = fragments.chain([template.source.as_str()]).collect();
        self.problems.iter().filter(move |problem| {
            let name = problem.path.file_name().unwrap_or_default();
            let name = name.to_string_lossy();
            // A fragment that is broken may be in use in no version.
            let quoted = [format!("\"{name}\""), format!("'{name}'")];
            let is_included = || {
                quoted
                    .iter()
                    .any(|q| texts.iter().any(|t| t.contains(q.as_str())))
            };
            name == file || !name.ends_with(".md") || is_included()
        })
    }

    /// Takes over from an earlier reading what the user's broken files were when they were good.
    #[must_use]
    pub fn or_last_good(mut self, before: &Self) -> Self {
        for problem in &mut self.problems {
            let file = problem.path.file_name().map(|n| n.to_string_lossy());
            let file = file.unwrap_or_default().into_owned();
            let theirs = |origin: &&Origin| origin.path() == Some(&problem.path);
            if let Some((template, origin)) = before.templates.get(&file)
                && theirs(&origin)
            {
                let kept = (template.clone(), origin.clone());
                self.templates.insert(file, kept);
                problem.instead = Instead::LastGood;
            } else if let Some(origin) = before.fragment_origins.get(&file).filter(theirs) {
                let text = before.fragments[&file].clone();
                self.fragment_origins.insert(file.clone(), origin.clone());
                self.fragments.insert(file, text);
                problem.instead = Instead::LastGood;
            }
        }
        self
    }

    fn overlay(&mut self, folder: &Path) {
        let entries = match std::fs::read_dir(folder) {
            Ok(entries) => entries,
            Err(error) => {
                if error.kind() != std::io::ErrorKind::NotFound {
                    self.problems.push(Problem {
                        path: folder.to_path_buf(),
                        message: system::words(&error),
                        instead: Instead::Shipped,
                    });
                }
                return;
            }
        };
        let mut paths: Vec<PathBuf> = entries.flatten().map(|e| e.path()).collect();
        paths.retain(|p| p.extension().is_some_and(|x| x == "md"));
        paths.sort();
        for path in paths {
            let name = path.file_name().map(|n| n.to_string_lossy().into_owned());
            let name = name.unwrap_or_default();
            let put = read(&path).and_then(|source| {
                self.put(&name, &source, Origin::User(path.clone()))
                    .map_err(|e| e.to_string())
            });
            if let Err(message) = put {
                self.problems.push(Problem {
                    path,
                    message,
                    instead: match Self::shipped(&name) {
                        Some(_) => Instead::Shipped,
                        None => Instead::Nothing,
                    },
                });
            }
        }
    }

    fn put(&mut self, file: &str, source: &str, origin: Origin) -> Result<(), TemplateError> {
        if file.starts_with('_') {
            syntax(source)?;
            self.fragments.insert(file.to_string(), source.to_string());
            self.fragment_origins.insert(file.to_string(), origin);
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

    /// The text of a file that is in use, template or fragment, and where it comes from.
    #[must_use]
    pub fn source(&self, file: &str) -> Option<(&str, &Origin)> {
        let template = self.templates.get(file);
        let template = template.map(|(template, origin)| (template.source.as_str(), origin));
        let fragment = || {
            let text = self.fragments.get(file)?;
            Some((text.as_str(), self.fragment_origins.get(file)?))
        };
        template.or_else(fragment)
    }

    /// SHA-256, hexadecimal, of a template's text and of the fragments that it includes.
    #[must_use]
    pub fn hash(&self, source: &str) -> String {
        includes::hash(source, &self.fragments)
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

fn read(path: &Path) -> Result<String, String> {
    system::read_text(path, system::LARGEST_TEXT).map_err(|e| system::words(&e))
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
        let file = |name: &str| folder.path().join(name);
        let mine = Library::shipped("collision-ego.md").unwrap().replacen(
            "version = ",
            "version = \"mine\" #",
            1,
        );
        std::fs::write(file("collision-ego.md"), &mine).unwrap();
        std::fs::write(file("safety-ego.md"), "no front matter").unwrap();
        std::fs::write(file("_risk.md"), "a\n{% if %}").unwrap();
        std::fs::write(file("_new.md"), "{{").unwrap();
        let library = Library::load(Some(folder.path()));
        let (_, template) = library.find("collision", "ego").unwrap();
        assert_eq!(template.front.version, "mine");
        let kept = &library.find("safety", "ego").unwrap().1.source;
        assert_eq!(Some(kept.as_str()), Library::shipped("safety-ego.md"));
        let problems: Vec<_> = library
            .problems
            .iter()
            .map(|p| (p.path.clone(), p.instead))
            .collect();
        assert_eq!(
            problems,
            [
                (file("_new.md"), Instead::Nothing),
                (file("_risk.md"), Instead::Shipped),
                (file("safety-ego.md"), Instead::Shipped)
            ]
        );
        assert!(library.problems[1].message.starts_with("line 2:"));
    }

    #[test]
    fn a_file_that_breaks_stays_in_use_as_it_was() {
        let folder = tempfile::tempdir().unwrap();
        let file = |name: &str| folder.path().join(name);
        let mine = Library::shipped("collision-ego.md").unwrap().to_string() + "\n{# mine #}";
        std::fs::write(file("collision-ego.md"), &mine).unwrap();
        std::fs::write(file("_risk.md"), "my risk").unwrap();
        let good = Library::load(Some(folder.path()));
        assert!(good.problems.is_empty());
        std::fs::write(file("collision-ego.md"), "broken").unwrap();
        std::fs::write(file("_risk.md"), "{{").unwrap();
        std::fs::write(file("safety-ego.md"), "never was good").unwrap();
        let mut library = Library::load(Some(folder.path())).or_last_good(&good);
        // A second reading keeps what the first kept.
        for _ in 0..2 {
            let (source, origin) = library.source("collision-ego.md").unwrap();
            assert_eq!(source, mine);
            assert_eq!(origin, &Origin::User(file("collision-ego.md")));
            assert_eq!(library.source("_risk.md").unwrap().0, "my risk");
            let instead: Vec<_> = library.problems.iter().map(|p| p.instead).collect();
            assert_eq!(
                instead,
                [Instead::LastGood, Instead::LastGood, Instead::Shipped]
            );
            library = Library::load(Some(folder.path())).or_last_good(&library);
        }
        std::fs::remove_file(file("collision-ego.md")).unwrap();
        let library = Library::load(Some(folder.path())).or_last_good(&library);
        assert_eq!(
            library.source("collision-ego.md").unwrap().1,
            &Origin::Shipped
        );
    }
}
