//! Standard output of the headless commands: data only, and quiet when the reader is gone.

use std::io::{self, Write};

use super::Failure;
use crate::text::disguises;

/// Writes text; a reader that closed the pipe ends the program's output, not the program.
pub fn text(text: &str) -> Result<(), Failure> {
    heard(text).map(drop)
}

/// Writes text, and says whether somebody still reads: false where the pipe is closed.
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

/// JSON must escape only the control characters below U+0020; terminals obey those from U+007F on as well, and what
/// turns the direction of writing.
#[must_use]
pub fn escaped(json: &str) -> String {
    let mut text = String::with_capacity(json.len());
    for c in json.chars() {
        if c.is_control() || disguises(c) {
            for unit in c.encode_utf16(&mut [0; 2]) {
                text.push_str(&format!("\\u{unit:04x}"));
            }
        } else {
            text.push(c);
        }
    }
    text
}

/// XML whose attributes and texts hold what terminals would obey as references, which mean the same.
#[must_use]
pub fn escaped_xml(xml: &str) -> String {
    let mut text = String::with_capacity(xml.len());
    for c in xml.chars() {
        if disguises(c) {
            text.push_str(&format!("&#x{:x};", u32::from(c)));
        } else {
            text.push(c);
        }
    }
    text
}

/// Text from outside with its control characters shown instead of obeyed.
#[must_use]
pub fn visible(text: &str) -> String {
    crate::text::visible(text).into_owned()
}
