//! Key lookup: environment variables of the process, then `.env` files.

use std::collections::BTreeMap;
use std::fmt;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use secrecy::SecretString;

use super::redaction::Secrets;
use nearmiss_base::system;

/// More than any file of variables is long, in bytes.
const LONGEST: u64 = 256 << 10;

/// The variables of the process, and files of variables below them.
#[derive(Clone)]
pub struct Environment {
    lookup: Arc<Lookup>,
    files: Vec<File>,
    /// Files that cannot be read as a whole, and why; what they hold is never in these words.
    pub problems: Vec<String>,
}

type Lookup = dyn Fn(&str) -> Option<String> + Send + Sync;

#[derive(Clone)]
struct File {
    path: PathBuf,
    variables: BTreeMap<String, SecretString>,
}

/// A key that was found.
#[derive(Debug, Clone)]
pub struct ResolvedKey {
    /// The key.
    pub key: SecretString,
    /// The variable, and the file it is in if it is in one.
    pub source: String,
    /// Whether that file lies in the current folder, and may have come with what else is there.
    pub from_current_folder: bool,
}

impl Environment {
    /// The variables that `lookup` knows, and no files.
    pub fn from_lookup(lookup: impl Fn(&str) -> Option<String> + Send + Sync + 'static) -> Self {
        Self {
            lookup: Arc::new(lookup),
            files: Vec::new(),
            problems: Vec::new(),
        }
    }

    /// The variables of the process; keys also from the file `.env` of each folder, the first that has one.
    #[must_use]
    pub fn with_files(folders: &[&Path]) -> Self {
        let mut environment = Self::from_lookup(|name| std::env::var(name).ok());
        for folder in folders {
            environment.add(&folder.join(".env"));
        }
        environment
    }

    /// Adds the variables of a file with lower precedence; a missing file adds none.
    pub fn add(&mut self, path: &Path) {
        let mut problem = |why: String| self.problems.push(format!("{}: {why}", path.display()));
        let text = match system::read_text(path, LONGEST) {
            Ok(text) => text,
            Err(error) if error.kind() == ErrorKind::NotFound && !path.is_symlink() => return,
            Err(error) => return problem(system::error_text(&error)),
        };
        let mut variables = BTreeMap::new();
        for entry in dotenvy::from_read_iter(text.as_bytes()) {
            match entry {
                Ok((name, value)) => drop(variables.insert(name, SecretString::from(value))),
                // The error itself would show the line, and with it the key.
                Err(dotenvy::Error::LineParse(line, _)) => {
                    let at = text.lines().position(|l| l.trim() == line.trim());
                    let line = at.map(|n| format!("line {}", n + 1));
                    problem(format!(
                        "{} is not NAME=value",
                        line.as_deref().unwrap_or("a line")
                    ));
                }
                Err(_) => problem("it cannot be read".into()),
            }
        }
        let path = path.to_path_buf();
        self.files.push(File { path, variables });
    }

    /// A variable of the process. Addresses come from nowhere else: a `.env` file that came with downloaded scenarios
    /// must not redirect keys.
    pub(super) fn variable(&self, name: &str) -> Option<String> {
        (self.lookup)(name).filter(|value| !value.trim().is_empty())
    }

    /// The key in the first of these variables that has one; the process comes before the files.
    pub(super) fn key(&self, names: &[String]) -> Option<ResolvedKey> {
        let of_process = names.iter().find_map(|name| {
            Some(ResolvedKey {
                key: SecretString::from(self.variable(name)?),
                source: name.clone(),
                from_current_folder: false,
            })
        });
        let of_files = || {
            self.files.iter().find_map(|file| {
                names.iter().find_map(|name| {
                    let key = file.variables.get(name)?;
                    let blank = secrecy::ExposeSecret::expose_secret(key).trim().is_empty();
                    (!blank).then(|| ResolvedKey {
                        key: key.clone(),
                        source: format!("{name} in {}", file.path.display()),
                        from_current_folder: file.path.parent() == Some(Path::new(".")),
                    })
                })
            })
        };
        of_process.or_else(of_files)
    }
}

/// A text without anything that may be a key, in any of its forms: what was sent to an endpoint as a secret, and the
/// values of variables whose names say so, of the process and of `.env` files in these folders.
#[must_use]
pub fn without_secrets(text: &str, folders: &[&Path]) -> String {
    use secrecy::ExposeSecret;
    let environment = Environment::with_files(folders);
    let of_process = std::env::vars_os().filter_map(|(name, value)| {
        let (name, value) = (name.into_string().ok()?, value.into_string().ok()?);
        says_secret(&name).then_some(value)
    });
    // All values in key files count as secrets, whatever their names.
    let of_files = environment.files.iter().flat_map(|file| {
        let values = file.variables.values();
        values.map(|value| value.expose_secret().to_string())
    });
    let secrets = of_process
        .chain(of_files)
        .map(|secret| secret.trim().to_string())
        .filter(|secret| secret.len() >= SHORTEST)
        .collect();
    Secrets::all_and(secrets).redact_cut(text)
}

/// Shorter values are words that stand in every text, bytes.
const SHORTEST: usize = 6;

fn says_secret(name: &str) -> bool {
    let name = name.to_ascii_uppercase();
    let words = ["KEY", "TOKEN", "SECRET", "PASS", "CREDENTIAL", "AUTH"];
    words.iter().any(|word| name.contains(word))
}

impl fmt::Debug for Environment {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let files: Vec<_> = self.files.iter().map(|file| &file.path).collect();
        f.debug_struct("Environment")
            .field("files", &files)
            .field("problems", &self.problems)
            .finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use secrecy::ExposeSecret;

    use super::*;

    #[test]
    fn no_key_of_a_file_stays_in_a_text() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(
            folder.path().join(".env"),
            "LAB=abc-123-def\nLONG=abc-123-def-456\nX=1\n",
        )
        .unwrap();
        let text = without_secrets("1: abc-123-def-456, abc-123-def.", &[folder.path()]);
        assert_eq!(text, "1: [key], [key].");
        assert!(says_secret("openai_api_key") && !says_secret("HOME"));
    }

    fn found(environment: &Environment, name: &str) -> Option<(String, String)> {
        let found = environment.key(&[name.to_string()])?;
        Some((found.key.expose_secret().to_string(), found.source))
    }

    #[test]
    fn the_process_comes_first_then_the_files_in_order() {
        let (one, two) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        std::fs::write(one.path().join(".env"), "A=file1\nB='file 1' # why\nE=\n").unwrap();
        std::fs::write(two.path().join(".env"), "export B=x\nC=\"file2\"\nE=e\n").unwrap();
        let mut environment = Environment::from_lookup(|name| {
            (name == "A" || name == "D").then(|| format!("{name}!"))
        });
        environment.add(&one.path().join(".env"));
        environment.add(&two.path().join(".env"));
        environment.add(Path::new("/no/such/.env"));
        assert_eq!(environment.problems, [""; 0]);
        assert_eq!(found(&environment, "A").unwrap(), ("A!".into(), "A".into()));
        let (key, source) = found(&environment, "B").unwrap();
        assert_eq!(key, "file 1");
        assert!(
            source.starts_with("B in ") && source.ends_with(".env"),
            "{source}"
        );
        assert_eq!(found(&environment, "C").unwrap().0, "file2");
        assert_eq!(found(&environment, "E").unwrap().0, "e", "blank is none");
        assert_eq!(
            environment.variable("B"),
            None,
            "addresses come from the process"
        );
        assert!(!format!("{environment:?}").contains("file 1"));
    }

    #[test]
    fn a_line_that_is_none_is_named_not_shown() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(".env");
        std::fs::write(&path, "A=1\nsk-geheim ohne\nB=2\n").unwrap();
        let mut environment = Environment::from_lookup(|_| None);
        environment.add(&path);
        environment.add(folder.path());
        let text = environment.problems.join("\n");
        assert!(
            text.contains("line 2 is not NAME=value") && text.contains("is a folder"),
            "{text}"
        );
        assert!(!format!("{environment:?}").contains("geheim"));
        assert_eq!(found(&environment, "A").unwrap().0, "1");
    }
}
