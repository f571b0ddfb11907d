//! Decodes bytes to text: reports where a file is not UTF-8 and what it is instead.

use super::error::ReadError;
use super::xml::{Xml, short};
use crate::scenario::{Diagnostic, Severity};

/// A byte order mark, which some editors write in front of a text.
pub(super) const BYTE_ORDER_MARK: char = '\u{feff}';

/// The same in UTF-8.
const MARK_IN_UTF_8: &[u8] = b"\xef\xbb\xbf";

/// Bytes without the byte order marks that they begin with.
pub(in crate::formats) fn without_marks(mut bytes: &[u8]) -> &[u8] {
    while let Some(rest) = bytes.strip_prefix(MARK_IN_UTF_8) {
        bytes = rest;
    }
    bytes
}

/// What some bytes are, from how they begin, if they have to be unpacked or saved anew before anything here can read
/// them.
pub(in crate::formats) fn foreign(bytes: &[u8]) -> Option<&'static str> {
    Some(match bytes {
        [0x1f, 0x8b, ..] => "compressed with gzip; unpack it first",
        [b'P', b'K', 3, 4, ..] => "a ZIP archive; unpack it first",
        [b'B', b'Z', b'h', b'1'..=b'9', ..] => "compressed with bzip2; unpack it first",
        [0xfd, b'7', b'z', b'X', b'Z', 0, ..] => "compressed with xz; unpack it first",
        [0x28, 0xb5, 0x2f, 0xfd, ..] => "compressed with zstd; unpack it first",
        [0xff, 0xfe, 0, 0, ..]
        | [0, 0, 0xfe, 0xff, ..]
        | [b'<', 0, 0, 0, ..]
        | [0, 0, 0, b'<', ..] => "UTF-32; save it as UTF-8",
        _ if utf16_unit(bytes).is_some() => "UTF-16; save it as UTF-8",
        _ => return None,
    })
}

/// How two bytes make a unit of UTF-16, if the text is that: it has a mark, or markup begins with it.
fn utf16_unit(bytes: &[u8]) -> Option<fn([u8; 2]) -> u16> {
    match bytes {
        [0xff, 0xfe, ..] | [b'<', 0, ..] => Some(u16::from_le_bytes),
        [0xfe, 0xff, ..] | [0, b'<', ..] => Some(u16::from_be_bytes),
        _ => None,
    }
}

/// The beginning of a text in any encoding, only for detecting its kind.
pub(super) fn beginning(bytes: &[u8]) -> String {
    let Some(unit) = utf16_unit(bytes) else {
        return String::from_utf8_lossy(bytes).into_owned();
    };
    let pairs = bytes.chunks_exact(2).map(|pair| unit([pair[0], pair[1]]));
    let characters = char::decode_utf16(pairs);
    characters
        .map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER))
        .collect()
}

/// The text of an XML file.
///
/// # Errors
/// It is not UTF-8: with what it is, and the line, column and element of the first wrong byte.
pub(super) fn text<'a>(bytes: &'a [u8], file: &str) -> Result<&'a str, ReadError> {
    let wrong = |before: &str, element, message| ReadError {
        file: file.to_string(),
        line: 1 + before.matches('\n').count(),
        column: 1 + before.chars().rev().take_while(|c| *c != '\n').count(),
        element,
        message,
    };
    if let Some(what) = foreign(without_marks(bytes)) {
        return Err(wrong("", String::new(), format!("this is {what}")));
    }
    let text = std::str::from_utf8(bytes).map_err(|error| {
        let at = error.valid_up_to();
        let before = std::str::from_utf8(&bytes[..at]).unwrap_or_default();
        if bytes.contains(&0) {
            let message = "binary data; not an XML file";
            return wrong(before, String::new(), message.into());
        }
        let message = match error.error_len() {
            Some(_) => format!(
                "the byte 0x{:02x} is not UTF-8; save the file as UTF-8",
                bytes[at]
            ),
            None => "the file ends within a character; the file is cut off".into(),
        };
        wrong(before, innermost(before, file), message)
    })?;
    match text.find('\0') {
        None => Ok(text),
        Some(at) => Err(wrong(
            &text[..at],
            String::new(),
            "a zero byte, which XML does not allow; the file is damaged, or in an unmarked encoding other than UTF-8".into(),
        )),
    }
}

/// Doubts about the encoding of a file read as UTF-8; `text` is without its byte order marks.
pub(super) fn doubts(bytes: &[u8], text: &str) -> Vec<Diagnostic> {
    let mut found = Vec::new();
    let mut say = |message: String| {
        found.push(Diagnostic {
            severity: Severity::Warning,
            line: 1,
            element: String::new(),
            message,
        });
    };
    let marks = (bytes.len() - text.len()) / MARK_IN_UTF_8.len();
    if marks > 1 {
        say(format!("{marks} byte order marks; skipped"));
    }
    if let Some(name) = declared(text) {
        let plain = name.to_ascii_lowercase().replace('_', "-");
        let wide = plain.starts_with("utf-16") || plain.starts_with("utf-32");
        let same = matches!(plain.as_str(), "utf-8" | "utf8" | "us-ascii" | "ascii");
        // ASCII reads the same in nearly all encodings.
        if wide || (!same && !text.is_ascii()) {
            say(format!(
                "declared as `{}`, but read as UTF-8, which it is",
                short(name)
            ));
        }
    }
    found
}

/// The encoding that an XML declaration names.
fn declared(text: &str) -> Option<&str> {
    let (declaration, _) = text.strip_prefix("<?xml")?.split_once("?>")?;
    let (_, rest) = declaration.split_once("encoding")?;
    let rest = rest.trim_start().strip_prefix('=')?.trim_start();
    let quote = rest.chars().next().filter(|c| matches!(c, '"' | '\''))?;
    rest[1..].split(quote).next()
}

/// The path of the element within which a text ends, also where that is within its tag.
fn innermost(text: &str, file: &str) -> String {
    let mut path = Xml::new(text.as_bytes(), file).map_or_else(|e| e.element, Xml::path_at_end);
    let within = |open: &str, close: &str| text.rfind(open) > text.rfind(close);
    let in_tag = within("<", ">") && !within("<!--", "-->") && !within("<![CDATA[", "]]>");
    let tag = text.rsplit_once('<').map_or("", |(_, tag)| tag);
    let name = tag.split_whitespace().next().unwrap_or_default();
    if in_tag && name.starts_with(char::is_alphabetic) {
        let separator = if path.is_empty() { "" } else { "/" };
        path.push_str(&format!("{separator}{}", short(name)));
    }
    path
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn said(bytes: &[u8]) -> String {
        text(bytes, "f.xml").unwrap_err().to_string()
    }

    #[test]
    fn the_first_wrong_byte_is_named_with_its_element() {
        for (bytes, words) in [
            (
                &b"<a>\n<b id='7'><c>caf\xe9</c></b></a>"[..],
                "f.xml:2:17: in <a/b#7/c>: the byte 0xe9 is not UTF-8",
            ),
            (b"<a who='M\xfcller'>", "f.xml:1:10: in <a>: the byte 0xfc"),
            (
                b"<a><b who='M\xfcller'>",
                "f.xml:1:13: in <a/b>: the byte 0xfc",
            ),
            (b"<a/>\n<!-- <b \xfc -->", "f.xml:2:9: the byte 0xfc"),
            (b"\xfc", "f.xml:1:1: the byte 0xfc"),
            (
                "<a>é".as_bytes().split_last().unwrap().1,
                "f.xml:1:4: in <a>: the file ends within",
            ),
            (b"\xff\0<\x80", "f.xml:1:1: binary data"),
            (b"\xff\xfe<\0", "f.xml:1:1: this is UTF-16"),
            (b"<\0a\0>\0", "f.xml:1:1: this is UTF-16"),
            (b"\x1f\x8b\x08", "f.xml:1:1: this is compressed with gzip"),
            (b"\xef\xbb\xbf\xff\xfe<\0", "f.xml:1:1: this is UTF-16"),
            (b"\xff\xfe\0\0<\0\0\0", "f.xml:1:1: this is UTF-32"),
            (b"\n \0<\0a\0>\0", "f.xml:2:2: a zero byte"),
            (b"<a>\n1\0</a>", "f.xml:2:2: a zero byte"),
        ] {
            assert!(said(bytes).starts_with(words), "{}", said(bytes));
        }
    }

    #[test]
    fn what_is_said_of_the_encoding_is_held_against_the_text() {
        for (bytes, said) in [
            ("<?xml version='1.0' encoding='utf-8'?><a>é</a>", None),
            ("<?xml version='1.0' encoding=\"ISO-8859-1\"?><a/>", None),
            (
                "<?xml version='1.0' encoding=\"ISO-8859-1\"?><a>é</a>",
                Some("declared as `ISO-8859-1`"),
            ),
            (
                "<?xml version='1.0' encoding='UTF-16'?><a/>",
                Some("declared as `UTF-16`"),
            ),
            ("\u{feff}<a/>", None),
            ("\u{feff}\u{feff}\u{feff}<a/>", Some("3 byte order marks")),
            ("<?xml encoding=", None),
            ("<?xml encoding='?>", None),
        ] {
            let text = bytes.trim_start_matches(BYTE_ORDER_MARK);
            let found = doubts(bytes.as_bytes(), text);
            let words: Vec<_> = found.iter().map(|d| d.message.as_str()).collect();
            assert_eq!(
                words.len(),
                usize::from(said.is_some()),
                "{bytes}: {words:?}"
            );
            assert!(
                said.is_none_or(|said| words[0].starts_with(said)),
                "{bytes}: {words:?}"
            );
        }
    }

    #[test]
    fn a_beginning_is_seen_in_either_byte_order() {
        for bytes in [
            &b"\xff\xfe<\0a\0"[..],
            b"\xfe\xff\0<\0a",
            b"<\0a\0",
            b"\0<\0a\0",
        ] {
            assert_eq!(beginning(bytes).trim_start_matches('\u{feff}'), "<a");
        }
        assert_eq!(beginning(b"<a\xff"), "<a\u{fffd}");
    }
}
