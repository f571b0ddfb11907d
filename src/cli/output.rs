//! Standard output of headless commands: data only, silent once the reader has closed it.

use std::io::{self, Write};

use super::Failure;
pub use crate::description::{escaped_json as escaped, escaped_xml};

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

/// Standard output in whole lines: a program that has to end between two writes leaves no part of a row behind.
#[derive(Debug, Default)]
pub struct Lines {
    waiting: Vec<u8>,
}

/// So many bytes of lines are written at once.
const AT_ONCE: usize = 1 << 16;

impl Lines {
    fn write_out(&mut self, until: usize) -> io::Result<()> {
        // What could not be written is not tried again: the reader is gone.
        let lines: Vec<u8> = self.waiting.drain(..until).collect();
        io::stdout().lock().write_all(&lines)
    }
}

impl Write for Lines {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.waiting.extend_from_slice(bytes);
        if self.waiting.len() >= AT_ONCE
            && let Some(end) = self.waiting.iter().rposition(|byte| *byte == b'\n')
        {
            self.write_out(end + 1)?;
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.write_out(self.waiting.len())?;
        io::stdout().flush()
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

/// Writes one JSON document on one line.
pub fn json(value: &impl serde::Serialize) -> Result<(), Failure> {
    text(&json_line(value)?)
}

/// One JSON document as a line that no terminal obeys.
pub fn json_line(value: &impl serde::Serialize) -> Result<String, Failure> {
    let mut line = escaped(&serde_json::to_string(value).map_err(Failure::input)?);
    line.push('\n');
    Ok(line)
}

/// Text from outside with its control characters shown instead of obeyed.
#[must_use]
pub fn visible(text: &str) -> String {
    crate::description::visible(text).into_owned()
}

/// The system's own error in one of the table's: a closed pipe is still known as one.
pub fn of_csv(error: csv::Error) -> io::Error {
    match error.into_kind() {
        csv::ErrorKind::Io(error) => error,
        other => io::Error::other(format!("{other:?}")),
    }
}
