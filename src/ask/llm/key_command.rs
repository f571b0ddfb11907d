//! A key printed by a command, such as a password manager's.

use std::fmt;
use std::process::Stdio;
use std::time::Duration;

use secrecy::SecretString;
use tokio::io::AsyncReadExt;
use tokio::process::Command;

use nearmiss_base::system;

/// More than any key is long, in bytes.
const LONGEST: u64 = 64 << 10;

/// How long a command may take: the user may have to type a password.
const PATIENCE: Duration = Duration::from_secs(30);

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
        self.run_within(PATIENCE).await
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
        let mut child = system::job_control::with_default(|| command.spawn())
            .map_err(|e| format!("the key command {self} cannot be run: {e}"))?;
        let mut printed = Vec::new();
        let whole = async {
            if let Some(output) = child.stdout.take() {
                output.take(LONGEST).read_to_end(&mut printed).await?;
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
#[allow(clippy::unwrap_used)]
mod tests {
    use secrecy::ExposeSecret;

    use super::*;

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
