//! Key lookup: environment variables of the process, then `.env` files, or a command such as a password manager's.

use std::collections::BTreeMap;
use std::fmt;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::sync::Arc;
use std::time::Duration;

use nearmiss_base::system;
use secrecy::SecretString;
use tokio::io::AsyncReadExt;
use tokio::process::Command;

use super::redaction::Secrets;

/// More than any file of variables is long, in bytes.
const MAX_ENV_FILE_BYTES: u64 = 256 << 10;

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
        let text = match system::read_text(path, MAX_ENV_FILE_BYTES) {
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
        .filter(|secret| secret.len() >= MIN_SECRET_LENGTH)
        .collect();
    Secrets::all_and(secrets).redact_cut(text)
}

/// Shorter values are words that stand in every text, bytes.
const MIN_SECRET_LENGTH: usize = 6;

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

/// More than any key is long, in bytes.
const MAX_KEY_BYTES: u64 = 64 << 10;

/// How long a command may take: the user may have to type a password.
const COMMAND_TIMEOUT: Duration = Duration::from_secs(30);

/// A command whose first line of output is the key.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum KeyCommand {
    /// A line for `sh -c`.
    Shell(String),
    /// A program and its arguments, as they are.
    Program(Vec<String>),
}

/// The program's name alone: what follows it may hold a secret, and is shown and stored nowhere.
impl fmt::Display for KeyCommand {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let program = match self {
            Self::Shell(line) => first_word(line),
            Self::Program(words) => words.first().map_or("", String::as_str),
        };
        write!(f, "`{program}`")
    }
}

/// The program that a line of the shell begins with; the shell itself where the line begins with anything else.
fn first_word(line: &str) -> &str {
    let line = line.trim_start();
    let plain = |c: char| c.is_alphanumeric() || "._/-+".contains(c);
    let end = line.find(|c| !plain(c)).unwrap_or(line.len());
    match (&line[..end], line[end..].chars().next()) {
        ("", _) => "sh",
        (word, None) => word,
        (word, Some(next)) if next.is_whitespace() || "|;&<>".contains(next) => word,
        _ => "sh",
    }
}

impl KeyCommand {
    /// Runs the command and reads the key.
    ///
    /// # Errors
    /// Why the command gave no key; names the command, never its output.
    pub(super) async fn run(&self) -> Result<SecretString, String> {
        self.run_within(COMMAND_TIMEOUT).await
    }

    async fn run_within(&self, patience: Duration) -> Result<SecretString, String> {
        let mut command = match self {
            Self::Shell(line) => {
                let mut command = Command::new("sh");
                command.arg("-c").arg(line);
                command
            }
            Self::Program(words) => {
                let mut words = words.iter();
                let program = words.next().ok_or("key_command is empty")?;
                let mut command = Command::new(program);
                command.args(words);
                command
            }
        };
        // Keeps its output off the terminal and out of logs.
        command.stdin(Stdio::null()).stderr(Stdio::null());
        command.stdout(Stdio::piped()).kill_on_drop(true);
        let mut child = system::processes::with_default(|| command.spawn())
            .map_err(|e| format!("the key command {self} cannot be run: {e}"))?;
        let mut printed = Vec::new();
        let whole = async {
            if let Some(output) = child.stdout.take() {
                output.take(MAX_KEY_BYTES).read_to_end(&mut printed).await?;
            }
            child.wait().await
        };
        let status = tokio::time::timeout(patience, whole)
            .await
            .map_err(|_| format!("the key command {self} did not finish within {patience:?}"))?
            .map_err(|e| format!("the key command {self} failed: {e}"))?;
        if !status.success() {
            return Err(format!("the key command {self} failed ({status})"));
        }
        let line = std::str::from_utf8(&printed)
            .map_err(|_| format!("the key command {self} printed no text"))?
            .lines()
            .next()
            .unwrap_or_default()
            .trim();
        if line.is_empty() {
            return Err(format!("the key command {self} printed no key"));
        }
        Ok(SecretString::from(line))
    }
}

#[cfg(test)]
#[cfg(unix)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use secrecy::ExposeSecret;

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

    fn shell(line: &str) -> KeyCommand {
        KeyCommand::Shell(line.into())
    }

    #[tokio::test]
    async fn the_first_line_is_the_key() {
        let key = shell("printf ' one two \\nuser: me\\n'")
            .run()
            .await
            .unwrap();
        assert_eq!(key.expose_secret(), "one two");
        let words = ["printf", "%s", "$HOME `id` \"x\" y"].map(String::from);
        let key = KeyCommand::Program(words.to_vec()).run().await.unwrap();
        assert_eq!(key.expose_secret(), "$HOME `id` \"x\" y");
    }

    #[tokio::test]
    async fn failures_name_the_command_and_not_its_output() {
        for (command, why) in [
            (
                shell("echo geheim; echo geheim >&2; exit 3 #"),
                "exit status: 3",
            ),
            (shell("printf ' \\n'"), "no key"),
            (shell("printf '\\377'"), "no text"),
            (
                KeyCommand::Program(vec!["/no/such/program".into()]),
                "/no/such/program",
            ),
        ] {
            let error = command.run().await.unwrap_err();
            assert!(
                error.contains(why) && error.contains(&command.to_string()),
                "{error}"
            );
            assert!(!error.contains("geheim"), "{error}");
        }
        let error = shell("sleep 5").run_within(Duration::from_millis(50)).await;
        assert!(error.unwrap_err().contains("did not finish within 50ms"));
    }

    #[test]
    fn only_the_program_is_named() {
        for (line, name) in [
            ("pass lab/key", "`pass`"),
            (" /usr/bin/pass|head -1", "`/usr/bin/pass`"),
            ("TOKEN='geheim x' pass lab", "`sh`"),
            ("\"$HOME/geheim\" lab", "`sh`"),
            ("(echo geheim)", "`sh`"),
        ] {
            assert_eq!(shell(line).to_string(), name);
        }
        let words = ["pass", "geheim"].map(String::from).to_vec();
        assert_eq!(KeyCommand::Program(words).to_string(), "`pass`");
    }

    #[tokio::test]
    async fn a_command_that_never_stops_talking_is_cut_off() {
        let error = shell("yes geheim").run_within(Duration::from_secs(5)).await;
        assert!(error.unwrap_err().contains("failed"));
    }
}
