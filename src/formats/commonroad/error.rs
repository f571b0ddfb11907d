//! Errors of files that are not valid scenarios, with their place.

use nearmiss_base::system;

/// Why a file is not a scenario.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{file}{}{}: {message}", place(*line, *column), inside(*line, *column, element))]
pub struct ReadError {
    /// Which file.
    pub file: String,
    /// Line from 1; 0 where the file has no lines or could not be read at all.
    pub line: usize,
    /// Column in characters from 1; 0 where only the line is known.
    pub column: usize,
    /// The element, or in protobuf the field, as a path from the root; may be empty.
    pub element: String,
    /// The content found, and what was expected.
    pub message: String,
}

fn place(line: usize, column: usize) -> String {
    match (line, column) {
        (0, _) => String::new(),
        (line, 0) => format!(":{line}"),
        (line, column) => format!(":{line}:{column}"),
    }
}

fn inside(line: usize, column: usize, element: &str) -> String {
    match (line, column, element) {
        (_, _, "") => String::new(),
        (0, _, field) | (_, 0, field) => format!(": in {field}"),
        (_, _, element) => format!(": in <{element}>"),
    }
}

impl ReadError {
    pub(crate) fn io(file: &str, error: &std::io::Error) -> Self {
        Self {
            file: file.to_string(),
            line: 0,
            column: 0,
            element: String::new(),
            message: system::words(error),
        }
    }
}
