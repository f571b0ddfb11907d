//! The template library: shipped templates, and the user's, which override them by file name; which one a task uses.

use std::collections::{BTreeMap, BTreeSet};
use std::io::{ErrorKind, Result as IoResult};
use std::path::{Path, PathBuf};

use nearmiss_base::system::{self, SaveError};
use strum::{IntoStaticStr, VariantArray};

use super::render::syntax;
use super::{Template, TemplateError, template};

/// Source of a template.
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

/// The templates and the fragments that they include.
#[derive(Debug, Clone, Default)]
pub struct Library {
    templates: BTreeMap<String, (Template, Origin)>,
    fragments: BTreeMap<String, String>,
    fragment_origins: BTreeMap<String, Origin>,
    /// Names under which texts that were not saved are in use.
    drafts: BTreeSet<String>,
    /// Which of several templates for the same is used.
    chosen: TemplateChoices,
    /// The templates that are asked with.
    pack: Pack,
    /// Files of the user that could not be used.
    pub problems: Vec<Problem>,
}

/// How the name of a frame of words ends that has a picture beside them.
const BESIDE_WORDS: &str = "+picture";

impl Library {
    /// The shipped templates, overridden by those in `folder` (files ending in `.md`).
    ///
    /// ```
    /// use nearmiss_ask::prompts::Library;
    ///
    /// let library = Library::load(None);
    /// let (file, template) = library.find("collision", "ego").unwrap();
    /// assert!(file.ends_with(".md"));
    /// println!("{file}: version {}", template.front.version);
    /// ```
    #[must_use]
    pub fn load(folder: Option<&Path>) -> Self {
        let mut library = Self::default();
        for shipped in SHIPPED {
            // The shipped files are read by a test, so none is dropped here.
            let _ = library.put(shipped.file, shipped.source, Origin::Shipped);
        }
        if let Some(folder) = folder {
            library.overlay(folder);
            library.choose(folder);
        }
        library
    }

    /// What is wrong with the user's versions of a template and of what it includes, or with their folder.
    pub fn problems_of<'l>(
        &'l self,
        file: &'l str,
        template: &'l Template,
    ) -> impl Iterator<Item = &'l Problem> {
        let included = template::included(&template.source, &self.fragments);
        let fragments = included
            .into_iter()
            .map(|name| self.fragments[name].as_str());
        let texts: Vec<&str> = fragments.chain([template.source.as_str()]).collect();
        self.problems.iter().filter(move |problem| {
            let name = problem
                .path
                .file_name()
                .unwrap_or_default()
                .to_string_lossy();
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

    /// A broken file of the user in whose place a template stands, or what that includes: answers to another question
    /// than the one that was written are not to be paid for.
    #[must_use]
    pub fn stands_for<'l>(&'l self, file: &'l str, template: &'l Template) -> Option<&'l Problem> {
        // Asked for each question.
        if self.problems.is_empty() {
            return None;
        }
        let chosen = |problem: &&Problem| {
            let is_template = problem.path.extension().is_some_and(|x| x == "md");
            problem.instead == Fallback::Usual && is_template
        };
        let chosen = self.problems.iter().filter(chosen);
        self.problems_of(file, template)
            .chain(chosen)
            .find(|problem| problem.stops())
    }

    /// Takes over from an earlier reading what the user's broken files were when they were good.
    #[must_use]
    pub fn or_last_good(mut self, before: &Self) -> Self {
        for problem in &mut self.problems {
            let file = problem
                .path
                .file_name()
                .map(|n| n.to_string_lossy())
                .unwrap_or_default()
                .into_owned();
            let theirs = |origin: &&Origin| origin.path() == Some(&problem.path);
            if let Some((template, origin)) = before.templates.get(&file)
                && theirs(&origin)
            {
                let kept = (template.clone(), origin.clone());
                self.templates.insert(file, kept);
                problem.instead = Fallback::LastGood;
            } else if let Some(origin) = before.fragment_origins.get(&file).filter(theirs) {
                let text = before.fragments[&file].clone();
                self.fragment_origins.insert(file.clone(), origin.clone());
                self.fragments.insert(file, text);
                problem.instead = Fallback::LastGood;
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
                        message: system::error_text(&error),
                        instead: Fallback::Shipped,
                    });
                }
                return;
            }
        };
        let mut paths: Vec<PathBuf> = entries.flatten().map(|e| e.path()).collect();
        paths.retain(|p| p.extension().is_some_and(|x| x == "md"));
        paths.sort();
        for path in paths {
            let name = path
                .file_name()
                .map(|n| n.to_string_lossy().into_owned())
                .unwrap_or_default();
            let put = read(&path).and_then(|source| {
                self.put(&name, &source, Origin::User(path.clone()))
                    .map_err(|e| e.to_string())
            });
            if let Err(message) = put {
                self.problems.push(Problem {
                    path,
                    message,
                    instead: match Self::shipped(&name) {
                        Some(_) => Fallback::Shipped,
                        None => Fallback::Nothing,
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

    /// Uses a text that is not saved in the place of a file, and of every other one for its task and frame.
    ///
    /// # Errors
    /// It is no template.
    pub fn use_draft(&mut self, file: &str, source: &str) -> Result<(), TemplateError> {
        self.put(file, source, Origin::User(PathBuf::from(file)))?;
        self.drafts.insert(file.to_string());
        self.use_file(file);
        Ok(())
    }

    /// Uses this file for its task and frame, if it is there and another one is used.
    pub fn use_file(&mut self, file: &str) {
        if let Some((template, _)) = self.templates.get(file).filter(|_| !self.in_use(file)) {
            let front = &template.front;
            self.chosen.set(&front.task, &front.frame, Some(file));
        }
    }

    /// Whether the text in use under this name was not saved.
    #[must_use]
    pub fn is_draft(&self, file: &str) -> bool {
        self.drafts.contains(file)
    }

    /// The same library, asked with the templates of a pack.
    #[must_use]
    pub fn with_pack(mut self, pack: Pack) -> Self {
        self.pack = pack;
        self
    }

    /// The pack that is asked with.
    #[must_use]
    pub fn pack(&self) -> Pack {
        self.pack
    }

    /// Takes over what the user chose; a choice that cannot be kept is a problem.
    fn choose(&mut self, folder: &Path) {
        let path = folder.join(FILE);
        let mut problem = |message: String| {
            self.problems.push(Problem {
                path: path.clone(),
                message,
                instead: Fallback::Usual,
            });
        };
        let mut chosen = TemplateChoices::read(folder).unwrap_or_else(|message| {
            problem(message);
            TemplateChoices::default()
        });
        for (task, frame, file) in chosen.all() {
            let front = self.templates.get(&file).map(|(t, _)| &t.front);
            let why = match front {
                None => format!("{task}.{frame}: no template {file}"),
                Some(front) if front.task != task || front.frame != frame => {
                    let (of, at) = (&front.task, &front.frame);
                    format!("{task}.{frame}: {file} is for {of} in frame {at}")
                }
                Some(_) => continue,
            };
            chosen.set(&task, &frame, None);
            problem(why);
        }
        self.chosen = chosen;
    }

    /// The template for a task and a frame: the chosen one, else a user's before a shipped one, of a user's the one
    /// that overrides the shipped one; of another pack only where it is chosen and no pack is asked for. A frame of
    /// words with a picture beside them has the template of the words, unless it has its own.
    #[must_use]
    pub fn find(&self, task: &str, frame: &str) -> Option<(&str, &Template)> {
        let words = || frame.strip_suffix(BESIDE_WORDS);
        self.find_exactly(task, frame)
            .or_else(|| self.find_exactly(task, words()?))
    }

    fn find_exactly(&self, task: &str, frame: &str) -> Option<(&str, &Template)> {
        let chosen = self.chosen.get(task, frame);
        let rank = |file: &str, origin: &Origin| {
            let user = matches!(origin, Origin::User(_));
            (chosen == Some(file), user, Self::shipped(file).is_some())
        };
        let fits = |file: &str, t: &Template| {
            t.front.task == task && t.front.frame == frame && self.in_pack(file, t)
        };
        let all = self.templates.iter().filter(|(file, (t, _))| fits(file, t));
        all.max_by_key(|(file, (_, origin))| rank(file, origin))
            .map(|(file, (template, _))| (file.as_str(), template))
    }

    /// Whether a template is of the pack that is asked with, or chosen where no pack is asked for.
    fn in_pack(&self, file: &str, template: &Template) -> bool {
        let front = &template.front;
        let chosen = || self.chosen.get(&front.task, &front.frame) == Some(file);
        front.pack == self.pack || self.pack == Pack::Standard && chosen()
    }

    /// The templates for a task and a frame, of which [`Self::find`] takes one.
    pub fn candidates<'l>(
        &'l self,
        task: &'l str,
        frame: &'l str,
    ) -> impl Iterator<Item = (&'l str, &'l Template, &'l Origin)> {
        self.templates()
            .filter(move |(_, t, _)| t.front.task == task && t.front.frame == frame)
            .filter(|(file, t, _)| self.in_pack(file, t))
    }

    /// Whether a template is the one that is used for its task and frame.
    #[must_use]
    pub fn in_use(&self, file: &str) -> bool {
        self.file(file).is_some_and(|(template, _)| {
            let front = &template.front;
            self.find(&front.task, &front.frame).map(|f| f.0) == Some(file)
        })
    }

    /// Files of the user that stand in the place of shipped ones, or change what they include.
    pub fn overridden(&self) -> impl Iterator<Item = &str> {
        let templates = self.templates.iter().map(|(file, (_, o))| (file, o));
        let all = templates.chain(&self.fragment_origins);
        all.filter(|(file, origin)| origin.path().is_some() && Self::shipped(file).is_some())
            .map(|(file, _)| file.as_str())
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
        let template = self
            .templates
            .get(file)
            .map(|(template, origin)| (template.source.as_str(), origin));
        let fragment = || {
            let text = self.fragments.get(file)?;
            Some((text.as_str(), self.fragment_origins.get(file)?))
        };
        template.or_else(fragment)
    }

    /// SHA-256, hexadecimal, of a template's text and of the fragments that it includes.
    #[must_use]
    pub fn hash(&self, source: &str) -> String {
        template::hash(source, &self.fragments)
    }

    /// The shipped text of a file.
    #[must_use]
    pub fn shipped(file: &str) -> Option<&'static str> {
        SHIPPED.iter().find(|s| s.file == file).map(|s| s.source)
    }

    /// The shipped template that a file overrides, or that is for the same task and frame: its name and text.
    #[must_use]
    pub fn shipped_like(
        file: &str,
        task: &str,
        frame: &str,
    ) -> Option<(&'static str, &'static str)> {
        let names = [
            file.to_string(),
            format!("{task}-{frame}.md"),
            format!("{task}.md"),
        ];
        let find = |name: &String| SHIPPED.iter().find(|s| s.file == name);
        names.iter().find_map(find).map(|s| (s.file, s.source))
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
    system::read_text(path, system::LARGEST_TEXT).map_err(|e| system::error_text(&e))
}

/// A file of the user that is not in use, and why.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Problem {
    /// Which file.
    pub path: PathBuf,
    /// What is wrong, with the line.
    pub message: String,
    /// What is in use in its place.
    pub instead: Fallback,
}

/// Replacement in use for a broken file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fallback {
    /// The shipped file of the same name.
    Shipped,
    /// The user's own file, as it was when it could last be read.
    LastGood,
    /// Nothing: there is no other file of that name.
    Nothing,
    /// The template that is used where none is chosen.
    Usual,
}

impl Problem {
    /// Whether another template would be sent in place of the file.
    #[must_use]
    pub fn stops(&self) -> bool {
        matches!(self.instead, Fallback::Shipped | Fallback::Usual)
    }
}

impl std::fmt::Display for Problem {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let instead = match self.instead {
            Fallback::Shipped | Fallback::Usual => {
                "mend or remove it; nothing is sent in its place"
            }
            Fallback::LastGood => "its last good version stays in use",
            Fallback::Nothing => "the file is not used",
        };
        write!(f, "{}: {} ({instead})", self.path.display(), self.message)
    }
}

impl Library {
    /// Whether a file is the user's, template or fragment.
    #[must_use]
    pub fn is_users(&self, file: &str) -> bool {
        let origin = self.source(file).map(|(_, origin)| origin);
        matches!(origin, Some(Origin::User(_)))
    }

    /// The user's files that a template is made of: itself, and what it includes.
    #[must_use]
    pub fn users_in(&self, file: &str) -> Vec<String> {
        let Some((template, _)) = self.file(file) else {
            return Vec::new();
        };
        let included = template::included(&template.source, &self.fragments);
        let all = std::iter::once(file).chain(included);
        all.filter(|one| self.is_users(one))
            .map(str::to_string)
            .collect()
    }

    /// Takes a file of the user out of use, with a problem that says why; the shipped one of its name is in its place,
    /// if there is one. Says whether there was such a file.
    pub fn set_aside(&mut self, file: &str, message: String) -> bool {
        let Some((_, Origin::User(path))) = self.source(file) else {
            return false;
        };
        let path = path.clone();
        let used = self.in_use(file);
        let front = self.file(file).map(|(template, _)| template.front.clone());
        self.templates.remove(file);
        self.fragments.remove(file);
        self.fragment_origins.remove(file);
        let others = |library: &Self| {
            let found = front.and_then(|f| library.find(&f.task, &f.frame).map(|_| ()));
            found.is_some()
        };
        let instead = match Self::shipped(file) {
            Some(source) => {
                // The shipped files are read by a test.
                let _ = self.put(file, source, Origin::Shipped);
                Fallback::Shipped
            }
            None if used && others(self) => Fallback::Usual,
            None => Fallback::Nothing,
        };
        self.problems.push(Problem {
            path,
            message,
            instead,
        });
        true
    }
}

/// Its name.
pub const FILE: &str = "chosen.toml";

/// Larger files are not read, bytes.
const MAX_FILE_BYTES: u64 = 1 << 16;

/// Files of templates, by task and frame.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct TemplateChoices(BTreeMap<String, BTreeMap<String, String>>);

impl TemplateChoices {
    /// What was chosen; nothing where there is no file.
    ///
    /// # Errors
    /// The file cannot be read, or is not tables of tasks with files by frame: with the line.
    pub fn read(folder: &Path) -> Result<Self, String> {
        let bytes = match system::read_file(&folder.join(FILE), MAX_FILE_BYTES) {
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
            source: include_str!(concat!("../../../../prompts/", $file)),
        }),+]
    };
}

/// Every file, by name.
const SHIPPED: &[Shipped] = shipped![
    "_answer.md",
    "_cartesian.md",
    "_critical.md",
    "_ego.md",
    "_horizon.md",
    "_metrics.md",
    "_paper-answer.md",
    "_paper-risk.md",
    "_picture.md",
    "_recording.md",
    "_risk.md",
    "_scene.md",
    "attacker-ego.md",
    "attacker-metrics.md",
    "attacker-picture.md",
    "collision-cartesian.md",
    "collision-ego.md",
    "collision-metrics.md",
    "collision-picture.md",
    "paper-collision-cartesian.md",
    "paper-collision-ego.md",
    "paper-safety-cartesian.md",
    "paper-safety-ego.md",
    "recording-ego.md",
    "recording-metrics.md",
    "safety-cartesian.md",
    "safety-ego.md",
    "safety-metrics.md",
    "safety-picture.md",
    "trajectory.md",
];

/// A set of templates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "lowercase")]
pub enum Pack {
    /// The program's own way of asking.
    #[default]
    Standard,
    /// The way of "From Words to Collisions": its parts, thresholds and JSON keys.
    Paper,
}

nearmiss_record::named!(Pack, "pack");

#[cfg(test)]
mod tests;
