//! What commands write: data on standard output or into a file, as text or as a table; words on standard error.

mod format;
mod spreadsheet;
mod target;

use std::io::{self, Write};

use super::{Failure, Outcome, json};
pub use format::FormatOption;
pub use nearmiss_record::{
    Align, Cell, Column, Encoded, Format, Kind, Row, Table, line, lines as table_lines,
};
pub use spreadsheet::ForSpreadsheet;
pub use target::{OutputFile, Target, file_of, format_of, format_of_name, refused, written};

pub use nearmiss_scene::description::escaped_xml;

/// Writes text; a reader that closed the pipe ends the program's output, not the program.
pub fn text(text: &str) -> Result<(), Failure> {
    heard(text).map(drop)
}

/// Writes text, and returns whether it is still read: false where the pipe is closed.
pub fn heard(text: &str) -> Result<bool, Failure> {
    let mut out = io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(e) if e.kind() == io::ErrorKind::BrokenPipe => Ok(false),
        Err(e) => Err(Failure::system("standard output", &e)),
        Ok(()) => Ok(true),
    }
}

/// Says one line on standard error, with the control characters of file names and messages shown instead of obeyed.
pub fn say(words: &str) {
    // Nothing can be done about a standard error that is gone.
    let _ = writeln!(io::stderr().lock(), "{}", visible(words));
}

/// Says several lines on standard error, as [`say`] does one.
pub fn lines(words: &str) {
    words.trim_end().lines().for_each(say);
}

/// Writes one JSON object on one line, with the version of its form.
pub fn json(value: &impl serde::Serialize) -> Result<(), Failure> {
    text(&json_line(value)?)
}

/// Writes an output as one JSON object on one line, with the version of its form.
pub fn document(output: &impl json::Output) -> Result<(), Failure> {
    text(&document_line(output)?)
}

/// An output as one JSON object on one line, with the version of its form.
pub fn document_line(output: &impl json::Output) -> Result<String, Failure> {
    json_line(&output.document().map_err(Failure::input)?)
}

/// One JSON object as a line that no terminal obeys, with the version of its form.
pub fn json_line(value: &impl serde::Serialize) -> Result<String, Failure> {
    nearmiss_record::json_line(value).map_err(Failure::input)
}

/// Writes records of CSV.
pub fn csv<R>(records: impl IntoIterator<Item = R>) -> Outcome
where
    R: IntoIterator<Item: AsRef<str>>,
{
    text(&String::from_utf8_lossy(&nearmiss_record::csv(records)))
}

/// A table that goes to a file or to standard output.
pub type TableWriter = nearmiss_record::TableWriter<Target>;

/// Refuses a format that a terminal or a pipe cannot take.
pub fn check_format(format: Format, file: Option<&std::path::Path>) -> Outcome {
    match (format, file) {
        (Format::Parquet, None) => Err(Failure::input("Parquet needs a file: -o FILE")),
        _ => Ok(()),
    }
}

/// A count with its noun: `1 run`, `2 runs`.
#[must_use]
pub fn counted(count: usize, noun: &str) -> String {
    match count {
        1 => format!("1 {noun}"),
        _ => format!("{count} {noun}s"),
    }
}

/// So many of all scenarios: `2 of 7 scenarios`, and of a single one `the scenario`.
#[must_use]
pub fn of_scenarios(count: usize, all: usize) -> String {
    match all {
        1 => "the scenario".into(),
        _ => format!("{count} of {all} scenarios"),
    }
}

/// Text from outside with its control characters shown instead of obeyed.
#[must_use]
pub fn visible(text: &str) -> String {
    nearmiss_scene::description::visible(text).into_owned()
}
