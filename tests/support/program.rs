//! The program itself, run in folders of its own and without the keys and proxies of the machine.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};

/// A home for one test: configuration, data and files, gone at its end.
pub struct Home {
    folder: tempfile::TempDir,
}

/// How a run of the program ended.
#[derive(Debug)]
pub struct Ended {
    pub status: Option<i32>,
    pub stdout: String,
    pub stderr: String,
}

impl Home {
    pub fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        for name in ["config", "data", "files"] {
            std::fs::create_dir(folder.path().join(name)).unwrap();
        }
        Self { folder }
    }

    pub fn config(&self) -> PathBuf {
        self.folder.path().join("config")
    }

    pub fn data(&self) -> PathBuf {
        self.folder.path().join("data")
    }

    /// The folder the program is run in.
    pub fn files(&self) -> PathBuf {
        self.folder.path().join("files")
    }

    /// Writes a file below [`Home::files`], or below another folder where `name` is absolute.
    pub fn write(&self, name: impl AsRef<Path>, bytes: impl AsRef<[u8]>) -> PathBuf {
        let path = self.files().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(&path, bytes).unwrap();
        path
    }

    /// The program, ready to be given arguments.
    pub fn command(&self) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_nearmiss"));
        command.current_dir(self.files()).stdin(Stdio::null());
        for (name, _) in std::env::vars_os() {
            let text = name.to_string_lossy().to_uppercase();
            if ["_API_KEY", "_PROXY", "_BASE_URL"]
                .iter()
                .any(|end| text.ends_with(end))
                || ["NEARMISS", "OLLAMA", "OPENAI"]
                    .iter()
                    .any(|start| text.starts_with(start))
            {
                command.env_remove(&name);
            }
        }
        command
            .env("NEARMISS_CONFIG", self.config())
            .env("NEARMISS_DATA", self.data());
        command
    }

    /// Runs the program to its end. Whatever it is asked, it must not panic.
    pub fn run(&self, arguments: &[&str]) -> Ended {
        self.run_with(arguments, &[])
    }

    /// What a run that succeeds prints, which need not be text.
    pub fn bytes(&self, arguments: &[&str]) -> Vec<u8> {
        let ended = self.command().args(arguments).output().unwrap();
        assert!(ended.status.success(), "{ended:?}");
        ended.stdout
    }

    /// Like [`Home::run`], with variables in the environment.
    pub fn run_with(&self, arguments: &[&str], variables: &[(&str, &str)]) -> Ended {
        let mut command = self.command();
        command.args(arguments).envs(variables.iter().copied());
        Ended::of(&command.output().unwrap())
    }

    /// Like [`Home::run`], with these bytes on standard input.
    pub fn run_with_input(&self, arguments: &[&str], input: &[u8]) -> Ended {
        use std::io::Write;
        let mut command = self.command();
        command.args(arguments).stdin(Stdio::piped());
        let mut child = command
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        child.stdin.take().unwrap().write_all(input).unwrap();
        Ended::of(&child.wait_with_output().unwrap())
    }

    /// Starts the program with its output in pipes.
    pub fn start(&self, arguments: &[&str]) -> Child {
        let mut command = self.command();
        command
            .args(arguments)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped());
        command.spawn().unwrap()
    }

    /// The files below the data folder whose bytes hold `text`.
    pub fn files_with(&self, text: &str) -> Vec<PathBuf> {
        let mut found = Vec::new();
        let mut folders = vec![self.data(), self.config(), self.files()];
        while let Some(folder) = folders.pop() {
            for entry in std::fs::read_dir(folder).unwrap() {
                let path = entry.unwrap().path();
                if path.is_dir() {
                    folders.push(path);
                } else if contains(&std::fs::read(&path).unwrap(), text.as_bytes()) {
                    found.push(path);
                }
            }
        }
        found
    }

    /// The runs in the store, through SQLite alone: name of column and value as text.
    pub fn runs(&self) -> Vec<std::collections::BTreeMap<String, Option<String>>> {
        self.rows("SELECT * FROM runs ORDER BY id")
    }

    /// Rows of a query on the store.
    pub fn rows(&self, query: &str) -> Vec<std::collections::BTreeMap<String, Option<String>>> {
        use rusqlite::types::Value;
        let Ok(connection) = rusqlite::Connection::open_with_flags(
            self.data().join("runs.sqlite"),
            rusqlite::OpenFlags::SQLITE_OPEN_READ_WRITE,
        ) else {
            return Vec::new();
        };
        connection
            .busy_timeout(std::time::Duration::from_secs(5))
            .unwrap();
        let Ok(mut statement) = connection.prepare(query) else {
            return Vec::new();
        };
        let names: Vec<String> = statement.column_names().map(str::to_string).collect();
        let rows = statement.query_map([], |row| {
            let mut values = std::collections::BTreeMap::new();
            for (at, name) in names.iter().enumerate() {
                let text = match row.get::<_, Value>(at)? {
                    Value::Null => None,
                    Value::Integer(v) => Some(v.to_string()),
                    Value::Real(v) => Some(v.to_string()),
                    Value::Text(v) => Some(v),
                    Value::Blob(_) => Some("blob".into()),
                };
                values.insert(name.clone(), text);
            }
            Ok(values)
        });
        rows.unwrap().map(Result::unwrap).collect()
    }
}

impl Ended {
    pub fn of(output: &Output) -> Self {
        let text = |bytes: &[u8]| String::from_utf8(bytes.to_vec()).expect("output is UTF-8");
        let ended = Self {
            status: output.status.code(),
            stdout: text(&output.stdout),
            stderr: text(&output.stderr),
        };
        assert!(!ended.stderr.contains("panicked"), "{}", ended.stderr);
        ended
    }

    /// Fails unless the program ended with this status.
    #[track_caller]
    pub fn status(self, status: i32) -> Self {
        if self.status != Some(status) {
            let Self {
                status: got,
                stdout,
                stderr,
            } = &self;
            panic!("status {got:?} instead of {status}\nstdout: {stdout}\nstderr: {stderr}");
        }
        self
    }

    /// Fails unless all of these are in the words on standard error.
    #[track_caller]
    pub fn says(self, words: &[&str]) -> Self {
        for word in words {
            assert!(
                self.stderr.contains(word),
                "`{word}` is not in: {}",
                self.stderr
            );
        }
        self
    }

    /// Standard output as one JSON document.
    #[track_caller]
    pub fn json(&self) -> serde_json::Value {
        assert_eq!(
            self.stdout.matches('\n').count(),
            1,
            "one line: {}",
            self.stdout
        );
        serde_json::from_str(&self.stdout).expect("standard output is JSON")
    }

    /// The rows of a CSV table on standard output without the columns that tell which file and ego they are of.
    #[track_caller]
    pub fn measures(&self) -> Vec<Vec<String>> {
        let mut reader = csv::Reader::from_reader(self.stdout.as_bytes());
        let header = reader.headers().expect("a header").clone();
        let told = |at: usize| ["scenario", "file", "hash", "ego"].contains(&&header[at]);
        let rows = reader.records().map(|row| {
            let row = row.expect("a row");
            let cells = row.iter().enumerate().filter(|(at, _)| !told(*at));
            cells.map(|(_, cell)| cell.to_string()).collect()
        });
        rows.collect()
    }

    /// Standard output as JSON documents, one a line.
    #[track_caller]
    pub fn json_lines(&self) -> Vec<serde_json::Value> {
        let lines = self.stdout.lines();
        lines
            .map(|line| serde_json::from_str(line).expect("each line is JSON"))
            .collect()
    }
}

/// The same without what a clock measured, which differs from run to run.
pub fn untimed(mut value: serde_json::Value) -> serde_json::Value {
    match &mut value {
        serde_json::Value::Object(fields) => {
            fields.retain(|key, _| !key.starts_with("seconds_"));
            for field in fields.values_mut() {
                *field = untimed(field.take());
            }
        }
        serde_json::Value::Array(items) => {
            for item in items {
                *item = untimed(item.take());
            }
        }
        _ => {}
    }
    value
}

/// Whether `bytes` hold `part`.
pub fn contains(bytes: &[u8], part: &[u8]) -> bool {
    bytes.windows(part.len()).any(|window| window == part)
}

/// Says on the terminal that a test did not run, and why; the test harness shows what is written this way.
pub fn skipped(why: &str) {
    let _ = writeln!(std::io::stderr(), "skipped: {why}");
}
