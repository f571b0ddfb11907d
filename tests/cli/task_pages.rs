//! Pages of the manual with commands, those of tasks above all: the commands are run in order, and what they print is what the page shows.
//!
//! A `console` block has commands behind `$ ` and below each what it prints; a line
//! `…` stands for any lines, and `[..]` in a line for any words. A block whose first
//! line names a file, such as `toml experiment.toml`, is written before what follows runs. `NEARMISS_WRITE_MANUAL=1` puts what is
//! printed into the pages, but for what `…` leaves out.

use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::Command;

use super::batches::telling;
use super::support::program::{Home, skipped};
use super::support::python::package;
use super::support::server::{Recorded, Script, Server};

/// A line of a page, or a command with what the page says that it prints.
enum Part {
    Text(String),
    File { name: String, body: String },
    Command { said: String, printed: Vec<String> },
}

/// Lines of an output that a page shows at most, and columns of a line; what is cut ends with `…`.
const LONGEST: usize = 12;
const WIDEST: usize = 112;

fn pages() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/docs");
    let with_commands = nearmiss::docs::TOPICS
        .iter()
        .filter(|topic| topic.text.contains("```console"));
    with_commands.map(|topic| folder.join(topic.file)).collect()
}

fn parts(page: &str) -> Vec<Part> {
    let mut found = Vec::new();
    let mut lines = page.lines();
    while let Some(line) = lines.next() {
        found.push(Part::Text(line.to_owned()));
        let Some(kind) = line.strip_prefix("```").filter(|kind| !kind.is_empty()) else {
            continue;
        };
        let block: Vec<&str> = lines.by_ref().take_while(|line| *line != "```").collect();
        if kind == "console" {
            found.extend(commands(&block));
        } else if let Some((_, name)) = kind.split_once(' ') {
            found.push(Part::File {
                name: name.to_owned(),
                body: block.iter().map(|line| format!("{line}\n")).collect(),
            });
        } else {
            found.extend(block.into_iter().map(|line| Part::Text(line.to_owned())));
        }
        found.push(Part::Text("```".to_owned()));
    }
    found
}

fn commands(block: &[&str]) -> Vec<Part> {
    let mut found: Vec<Part> = Vec::new();
    let mut goes_on = false;
    for line in block {
        match (line.strip_prefix("$ "), found.last_mut()) {
            (Some(said), _) => found.push(Part::Command {
                said: said.to_owned(),
                printed: Vec::new(),
            }),
            (None, Some(Part::Command { said, .. })) if goes_on => {
                *said += &format!("\n{line}");
            }
            (None, Some(Part::Command { printed, .. })) => printed.push((*line).to_owned()),
            _ => panic!("a console block begins with `$ `: {line}"),
        }
        goes_on = line.ends_with('\\');
    }
    found
}

/// Whether lines are those that a page shows, where `…` stands for any.
fn fits(shown: &[String], printed: &[&str]) -> bool {
    match shown.split_first() {
        None => printed.is_empty(),
        Some((line, rest)) if line == "…" => {
            (0..=printed.len()).any(|at| fits(rest, &printed[at..]))
        }
        Some((line, rest)) => {
            printed.first().is_some_and(|first| is_like(line, first)) && fits(rest, &printed[1..])
        }
    }
}

/// Whether a line is the one that a page shows, where `[..]` stands for anything.
fn is_like(shown: &str, printed: &str) -> bool {
    let mut parts = shown.split("[..]");
    let Some(mut rest) = parts.next().and_then(|begin| printed.strip_prefix(begin)) else {
        return false;
    };
    let all: Vec<&str> = parts.collect();
    let Some((end, inner)) = all.split_last() else {
        return rest.is_empty();
    };
    for part in inner {
        match rest.split_once(part) {
            Some((_, behind)) => rest = behind,
            None => return false,
        }
    }
    rest.ends_with(end)
}

/// A line as there is room for it.
fn cut(line: &str) -> String {
    let line = line.trim_end();
    match line.char_indices().nth(WIDEST) {
        Some((end, _)) => format!("{}…", line[..end].trim_end()),
        None => line.to_owned(),
    }
}

/// What a page shows of lines: those that it showed before if they fit, else all that there is room for.
fn shown(before: &[String], printed: &[&str]) -> Vec<String> {
    if fits(before, printed) {
        return before.to_vec();
    }
    let mut all: Vec<String> = printed.iter().map(|line| (*line).to_owned()).collect();
    if all.len() > LONGEST {
        all.truncate(LONGEST - 1);
        all.push("…".into());
    }
    all
}

/// A model that says yes to each question, with an obstacle and a reason.
fn answer(request: &Recorded) -> Script {
    let text = String::from_utf8_lossy(&request.body).into_owned();
    let key = if text.contains("safety_critical") {
        "safety_critical"
    } else {
        "collision"
    };
    telling(&format!(
        "{{\"{key}\": true, \"obstacles\": [{{\"id\": 301, \"risk_score\": 1, \"reason\": \"It is 4.6 m ahead.\"}}], \
         \"critical_obstacles\": [{{\"id\": 301, \"probability\": 0.9}}], \"probability\": 0.9, \
         \"justification\": \"Obstacle 301 is 4.6 m ahead of the ego and approaching.\"}}"
    ))
}

/// What the commands of a page run in: the program and a Python with the module on the path.
struct Shell {
    home: Home,
    /// Where `python3` is the Python of the tests.
    programs: tempfile::TempDir,
    package: tempfile::TempDir,
}

impl Shell {
    fn new(python: &Path) -> Self {
        let programs = tempfile::tempdir().unwrap();
        // A link would not know the packages of a virtual environment.
        let shim = programs.path().join("python3");
        std::fs::write(
            &shim,
            format!("#!/bin/sh\nexec '{}' \"$@\"\n", python.display()),
        )
        .unwrap();
        std::fs::set_permissions(&shim, std::fs::Permissions::from_mode(0o755)).unwrap();
        Self {
            home: Home::new(),
            programs,
            package: package(),
        }
    }

    /// What a command prints: first what it says to people, then data, then a status that is not 0.
    fn lines(&self, said: &str) -> Vec<String> {
        let program = Path::new(env!("CARGO_BIN_EXE_nearmiss")).parent().unwrap();
        let path = std::env::var("PATH").unwrap_or_default();
        let path = format!(
            "{}:{}:{path}",
            self.programs.path().display(),
            program.display()
        );
        let mut shell = Command::new("sh");
        shell.args(["-c", said]).current_dir(self.home.files());
        for (name, value) in self.home.command().get_envs() {
            match value {
                Some(value) => shell.env(name, value),
                None => shell.env_remove(name),
            };
        }
        shell
            .env("PATH", path)
            .env("PYTHONPATH", self.package.path());
        let ended = shell.output().unwrap();
        let text = |bytes: &[u8]| {
            let text = String::from_utf8_lossy(bytes)
                .replace(&*self.home.config().to_string_lossy(), "~/.config/nearmiss");
            text.lines().map(cut).collect::<Vec<_>>()
        };
        let mut lines = [text(&ended.stderr), text(&ended.stdout)].concat();
        if !ended.status.success() {
            lines.push(format!(
                "[exit status {}]",
                ended.status.code().unwrap_or(-1)
            ));
        }
        lines
    }

    /// Runs a page: its text as it should be, and how many words of it are written by hand.
    fn run(&self, page: &str) -> (String, usize) {
        let (mut told, mut words) = (String::new(), 0);
        for part in parts(page) {
            let own = match part {
                Part::Text(line) => format!("{line}\n"),
                Part::File { name, body } => {
                    self.home.write(&name, &body);
                    body
                }
                Part::Command { said, printed } => {
                    let lines = self.lines(&said);
                    let lines: Vec<&str> = lines.iter().map(String::as_str).collect();
                    let own = format!("$ {said}\n");
                    words += own.split_whitespace().count();
                    told += &own;
                    for line in shown(&printed, &lines) {
                        told += &format!("{line}\n");
                    }
                    continue;
                }
            };
            words += own.split_whitespace().count();
            told += &own;
        }
        (told, words)
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_commands_of_the_task_pages_print_what_the_pages_show() {
    let server = Server::answering(|_, request| Some(answer(request))).await;
    let write = std::env::var_os("NEARMISS_WRITE_MANUAL").is_some();
    let mut stale = Vec::new();
    let python = std::env::var("NEARMISS_PYTHON").unwrap_or("python3".into());
    let python = tokio::task::block_in_place(|| found(&python));
    for page in pages() {
        let before = std::fs::read_to_string(&page).unwrap();
        let needs_pandas = before.contains("to_pandas");
        let Some((python, has_pandas)) = &python else {
            skipped("no python3");
            return;
        };
        if needs_pandas && !has_pandas {
            skipped(&format!(
                "{}: python3 lacks pandas (NEARMISS_PYTHON)",
                page.display()
            ));
            continue;
        }
        let shell = Shell::new(python);
        let config = format!("[provider.local]\nbase_url = \"{}\"\n", server.base_url());
        shell
            .home
            .write(shell.home.config().join("config.toml"), config);
        let (after, words) = tokio::task::block_in_place(|| shell.run(&before));
        assert!(
            words <= 400 || !page.display().to_string().contains("tasks"),
            "{}: {words} words",
            page.display()
        );
        if before == after {
            continue;
        }
        if write {
            std::fs::write(&page, after).unwrap();
        } else {
            let diff = similar::TextDiff::from_lines(&before, &after);
            stale.push(format!("{}:\n{}", page.display(), diff.unified_diff()));
        }
    }
    assert!(
        stale.is_empty(),
        "{}\nNEARMISS_WRITE_MANUAL=1 writes them",
        stale.join("\n")
    );
}

/// Where a Python is, and whether it has pandas.
fn found(python: &str) -> Option<(PathBuf, bool)> {
    let asked = "import sys; print(sys.executable)\ntry:\n import pandas, pyarrow; print('pandas')\nexcept ImportError: pass";
    let ended = Command::new(python).args(["-c", asked]).output().ok()?;
    let said = String::from_utf8_lossy(&ended.stdout).into_owned();
    let mut lines = said.lines();
    Some((PathBuf::from(lines.next()?), lines.next().is_some()))
}
