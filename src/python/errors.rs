//! Errors as one Python exception, with the file and line that they are about.

use nearmiss_formats::commonroad::ReadError;
use nearmiss_workflow::OpenError;
use pyo3::exceptions::PyException;
use pyo3::prelude::*;

pyo3::create_exception!(
    nearmiss,
    Error,
    PyException,
    "What is wrong, where, and what to do.\n\n`file` and `line` (from 1) say where, as far as known; else they are None."
);

/// What is wrong, before Python has a say.
#[derive(Debug)]
pub struct Problem {
    said: String,
    place: Option<(String, usize)>,
}

impl Problem {
    /// A problem in words.
    pub fn new(said: impl std::fmt::Display) -> Self {
        Self {
            said: in_python(&said.to_string()),
            place: None,
        }
    }

    /// The same of one of several.
    pub fn and_more(mut self, others: usize) -> Self {
        if others > 0 {
            self.said = format!("{} (and {others} more)", self.said);
        }
        self
    }

    /// The same without the folder of a table that was in memory.
    pub fn without_folder(mut self, folder: &std::path::Path) -> Self {
        let folder = format!("{}/", folder.display());
        self.said = self.said.replace(&folder, "");
        self.place = self
            .place
            .map(|(file, line)| (file.replace(&folder, ""), line));
        self
    }
}

/// What a keyword says, or its name and what is wrong with it.
pub fn of_keyword<T>(keyword: &str, read: Result<T, impl std::fmt::Display>) -> Result<T, Problem> {
    read.map_err(|why| Problem::new(format!("{keyword}: {why}")))
}

/// Words about options of the command line as words about keywords.
pub fn in_python(said: &str) -> String {
    const OPTIONS: [(&str, &str); 12] = [
        ("--map FILE", "map=FILE"),
        ("--rate HZ", "rate=HZ"),
        ("--columns ROLE=COLUMN", "columns=\"ROLE=COLUMN\""),
        ("--columns", "columns="),
        ("--ego ID", "ego=ID"),
        ("--obstacle ID", "obstacle=ID"),
        ("--task ", "task="),
        ("--set ", ""),
        ("--rate", "rate="),
        ("--at and --history", "at= and history="),
        ("--history ", "history="),
        ("--at ", "at="),
    ];
    let mut said = said.to_string();
    for (option, keyword) in OPTIONS {
        said = said.replace(option, keyword);
    }
    said
}

impl From<String> for Problem {
    fn from(said: String) -> Self {
        Self::new(said)
    }
}

impl From<ReadError> for Problem {
    fn from(error: ReadError) -> Self {
        Self {
            said: in_python(&error.to_string()),
            place: Some((error.file, error.line)),
        }
    }
}

impl From<OpenError> for Problem {
    fn from(error: OpenError) -> Self {
        match error {
            OpenError::Scenario(error) => error.into(),
            error => Self::new(error),
        }
    }
}

impl std::fmt::Display for Problem {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.said)
    }
}

impl From<Problem> for PyErr {
    fn from(problem: Problem) -> Self {
        let error = Error::new_err(problem.said);
        Python::attach(|py| {
            let (file, line) = problem.place.unzip();
            let value = error.value(py);
            // A new exception takes attributes.
            let _ = value.setattr("file", file);
            let _ = value.setattr("line", line.filter(|line| *line > 0));
        });
        error
    }
}
