//! Standard output of the headless commands: data only, and quiet when the reader is gone.

use std::io::{self, Write};

use super::Failure;

/// Writes text; a reader that closed the pipe ends the program's output, not the program.
pub fn text(text: &str) -> Result<(), Failure> {
    let mut out = io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(e) if e.kind() != io::ErrorKind::BrokenPipe => Err(Failure::input(e)),
        _ => Ok(()),
    }
}

/// Writes one JSON document on one line.
pub fn json(value: &impl serde::Serialize) -> Result<(), Failure> {
    let mut line = serde_json::to_string(value).map_err(Failure::input)?;
    line.push('\n');
    text(&line)
}

/// Text from outside with its control characters shown instead of obeyed.
#[must_use]
pub fn visible(text: &str) -> String {
    crate::text::visible(text).into_owned()
}
