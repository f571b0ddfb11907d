//! Decodes the bytes of XML files to text, in the encoding that their first bytes or their declaration tell.

use std::borrow::Cow;

use encoding_rs::{Encoding, UTF_8, UTF_16BE, UTF_16LE};

use super::ReadError;
use super::xml::{Xml, short};
use nearmiss_scene::scenario::{Diagnostic, Severity};

/// A byte order mark, which some editors write in front of a text.
pub(super) const BYTE_ORDER_MARK: char = '\u{feff}';

/// The same in UTF-8.
const MARK_IN_UTF_8: &[u8] = b"\xef\xbb\xbf";

/// Bytes without the byte order marks that they begin with.
pub(crate) fn without_marks(mut bytes: &[u8]) -> &[u8] {
    while let Some(rest) = bytes.strip_prefix(MARK_IN_UTF_8) {
        bytes = rest;
    }
    bytes
}

/// What some bytes are, from how they begin, if they have to be unpacked or saved anew before anything here can read
/// them.
pub(crate) fn foreign(bytes: &[u8]) -> Option<&'static str> {
    Some(match bytes {
        [0x1f, 0x8b, ..] => "compressed with gzip; unpack it first",
        [b'P', b'K', 3, 4, ..] if is_workbook(bytes) => "an Excel workbook; save it as CSV UTF-8",
        [b'P', b'K', 3, 4, ..] => "a ZIP archive; unpack it first",
        [b'B', b'Z', b'h', b'1'..=b'9', ..] => "compressed with bzip2; unpack it first",
        [0xfd, b'7', b'z', b'X', b'Z', 0, ..] => "compressed with xz; unpack it first",
        [0x28, 0xb5, 0x2f, 0xfd, ..] => "compressed with zstd; unpack it first",
        _ if is_utf32(bytes) => "UTF-32; save it as UTF-8",
        _ if utf16(bytes).is_some() => "UTF-16; save it as UTF-8",
        _ => return None,
    })
}

/// Whether an archive is one of Excel, by the files in it.
fn is_workbook(bytes: &[u8]) -> bool {
    let begin = &bytes[..bytes.len().min(4096)];
    let has = |name: &[u8]| begin.windows(name.len()).any(|part| part == name);
    has(b"[Content_Types].xml") || has(b"xl/")
}

/// The same of an XML file, which may be UTF-16.
pub(super) fn foreign_to_xml(bytes: &[u8]) -> Option<&'static str> {
    foreign(bytes).filter(|_| utf16(bytes).is_none() || is_utf32(bytes))
}

fn is_utf32(bytes: &[u8]) -> bool {
    matches!(
        bytes,
        [0xff, 0xfe, 0, 0, ..] | [0, 0, 0xfe, 0xff, ..] | [b'<', 0, 0, 0, ..] | [0, 0, 0, b'<', ..]
    )
}

/// Which UTF-16 a text is, if it is that: it has a mark, or markup begins with it.
pub(super) fn utf16(bytes: &[u8]) -> Option<&'static Encoding> {
    match bytes {
        [0xff, 0xfe, ..] | [b'<', 0, ..] => Some(UTF_16LE),
        [0xfe, 0xff, ..] | [0, b'<', ..] => Some(UTF_16BE),
        _ => None,
    }
}

/// The beginning of a text in any encoding, only for detecting its kind.
pub(crate) fn beginning(bytes: &[u8]) -> Cow<'_, str> {
    match utf16(bytes) {
        Some(wide) => wide.decode_without_bom_handling(bytes).0,
        None => String::from_utf8_lossy(bytes),
    }
}

/// The text of an XML file, and what is doubtful about its encoding.
pub(crate) struct Decoded<'a> {
    /// Without the byte order marks that it begins with.
    pub(super) text: Cow<'a, str>,
    pub(super) doubts: Vec<Diagnostic>,
}

/// Decodes an XML file: UTF-8, or what its byte order mark or its declaration names; `file` names it in errors.
///
/// # Errors
/// It is in none that is known, or damaged: with the line, column and element of the first wrong byte.
pub(crate) fn decoded<'a>(bytes: &'a [u8], file: &str) -> Result<Decoded<'a>, ReadError> {
    let wrong = |before: &str, element, message| ReadError {
        file: file.to_string(),
        line: 1 + before.matches('\n').count(),
        column: 1 + before.chars().rev().take_while(|c| *c != '\n').count(),
        element,
        message,
    };
    if let Some(what) = foreign_to_xml(without_marks(bytes)) {
        return Err(wrong("", String::new(), format!("this is {what}")));
    }
    let is_utf8 = std::str::from_utf8(bytes);
    let encoding =
        encoding_of(bytes, is_utf8.is_ok()).map_err(|message| wrong("", String::new(), message))?;
    let whole = match is_utf8 {
        Ok(text) if encoding == UTF_8 => Cow::Borrowed(text),
        Err(error) if encoding == UTF_8 => {
            let at = error.valid_up_to();
            let before = std::str::from_utf8(&bytes[..at]).unwrap_or_default();
            if bytes.contains(&0) {
                let message = "binary data; not an XML file";
                return Err(wrong(before, String::new(), message.into()));
            }
            let message = match error.error_len() {
                Some(_) => format!(
                    "the byte 0x{:02x} is not UTF-8; save the file as UTF-8, or declare its encoding in the first line",
                    bytes[at]
                ),
                None => "the file ends within a character; the file is cut off".into(),
            };
            return Err(wrong(before, innermost(before), message));
        }
        _ => {
            let (text, damaged) = encoding.decode_without_bom_handling(bytes);
            if damaged {
                let before = text
                    .split(char::REPLACEMENT_CHARACTER)
                    .next()
                    .unwrap_or_default();
                let message = format!(
                    "what is here is no character of {}, the file's encoding; the file is damaged or cut off",
                    encoding.name()
                );
                return Err(wrong(before, innermost(before), message));
            }
            text
        }
    };
    if let Some(at) = whole.find('\0') {
        let message = "a zero byte, which XML does not allow; the file is damaged, or in an unmarked encoding other than UTF-8";
        return Err(wrong(&whole[..at], String::new(), message.into()));
    }
    let marks = whole.len() - whole.trim_start_matches(BYTE_ORDER_MARK).len();
    // All of them: the parser takes one away by itself and does not count its bytes.
    let text = match whole {
        Cow::Borrowed(text) => Cow::Borrowed(&text[marks..]),
        Cow::Owned(mut text) => {
            text.drain(..marks);
            Cow::Owned(text)
        }
    };
    let doubts = doubts(marks / MARK_IN_UTF_8.len(), encoding, &text);
    Ok(Decoded { text, doubts })
}

/// The encoding of an XML file. What is UTF-8 is read as that, also where one of single bytes is declared: hardly any
/// text in these is UTF-8 by chance.
fn encoding_of(bytes: &[u8], is_utf8: bool) -> Result<&'static Encoding, String> {
    if let Some(wide) = utf16(bytes) {
        return Ok(wide);
    }
    let head = String::from_utf8_lossy(&bytes[..bytes.len().min(LONGEST_DECLARATION)]);
    let Some(name) = declared(head.trim_start_matches(BYTE_ORDER_MARK)) else {
        return Ok(UTF_8);
    };
    if is_wide(name) {
        // Its declaration can be read byte by byte, so it is none of these.
        return Ok(UTF_8);
    }
    let known = Encoding::for_label_no_replacement(name.as_bytes()).ok_or_else(|| {
        format!(
            "the declared encoding `{}` is not known; save the file as UTF-8",
            short(name)
        )
    })?;
    let marked = bytes.starts_with(MARK_IN_UTF_8);
    let by_chance = !known.is_single_byte();
    Ok(if marked || is_utf8 && !by_chance {
        UTF_8
    } else {
        known
    })
}

/// No declaration is longer, bytes.
const LONGEST_DECLARATION: usize = 1024;

/// Whether an encoding of this name has no character of a single byte.
fn is_wide(name: &str) -> bool {
    let plain = name.to_ascii_lowercase().replace('_', "-");
    ["utf-16", "utf-32", "ucs-2", "ucs-4", "iso-10646-ucs"]
        .iter()
        .any(|wide| plain.starts_with(wide))
}

/// Doubts about the encoding of a text that had so many byte order marks.
fn doubts(marks: usize, encoding: &'static Encoding, text: &str) -> Vec<Diagnostic> {
    let mut found = Vec::new();
    let mut say = |message: String| {
        found.push(Diagnostic {
            severity: Severity::Warning,
            line: 1,
            element: String::new(),
            message,
        });
    };
    if marks > 1 {
        say(format!("{marks} byte order marks; skipped"));
    }
    if let Some(name) = declared(text) {
        let wide = encoding == UTF_16LE || encoding == UTF_16BE;
        let same = Encoding::for_label(name.as_bytes()) == Some(encoding);
        // ASCII reads the same in nearly all encodings.
        let differs = match is_wide(name) {
            declared_wide if declared_wide || wide => declared_wide != wide,
            _ => !same && !text.is_ascii(),
        };
        if differs {
            say(format!(
                "declared as `{}`, but read as {}, which it is",
                short(name),
                encoding.name()
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
    let (name, _) = rest[1..].split_once(quote)?;
    Some(name)
}

/// The path of the element within which a text ends, also where that is within its tag.
fn innermost(text: &str) -> String {
    let mut path = Xml::of_text(text.trim_start_matches(BYTE_ORDER_MARK), "").path_at_end();
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
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    fn said(bytes: &[u8]) -> String {
        let Err(error) = decoded(bytes, "f.xml") else {
            panic!("{bytes:?} was read");
        };
        error.to_string()
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
            (
                b"\xff\xfe<\0a\0>\0\0\xd8",
                "f.xml:1:5: in <a>: what is here is no character of UTF-16LE",
            ),
            (
                b"\0<\0a\0>\0",
                "f.xml:1:4: in <a>: what is here is no character of UTF-16BE",
            ),
            (
                b"<?xml version='1.0' encoding='EBCDIC-XX'?><a/>",
                "f.xml:1:1: the declared encoding `EBCDIC-XX` is not known",
            ),
            (
                b"<?xml version='1.0' encoding='utf-7'?><a/>",
                "f.xml:1:1: the declared encoding `utf-7` is not known",
            ),
            (b"\x1f\x8b\x08", "f.xml:1:1: this is compressed with gzip"),
            (b"\xef\xbb\xbf\xff\xfe<\0", "f.xml:1:2: binary data"),
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
            let found = decoded(bytes.as_bytes(), "f.xml").unwrap().doubts;
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
            b"\0<\0a",
        ] {
            assert_eq!(beginning(bytes).trim_start_matches('\u{feff}'), "<a");
        }
        assert_eq!(beginning(b"<a\xff"), "<a\u{fffd}");
    }

    #[test]
    fn a_text_is_the_same_in_every_encoding_that_is_told() {
        let text = |name: &str| {
            format!("<?xml version='1.0' encoding='{name}'?>\n<a b='M\u{fc}ller \u{20ac}'/>")
        };
        let wide = |name: &str, mark: &str, unit: fn(u16) -> [u8; 2]| -> Vec<u8> {
            let text = format!("{mark}{}", text(name));
            text.encode_utf16().flat_map(unit).collect()
        };
        let single = |name: &str, euro: u8| -> Vec<u8> {
            let bytes = text(name)
                .replace('\u{fc}', "\x01")
                .replace('\u{20ac}', "\x02");
            let byte = |b: u8| match b {
                1 => 0xfc,
                2 => euro,
                b => b,
            };
            bytes.bytes().map(byte).collect()
        };
        for (name, bytes) in [
            ("UTF-8", text("UTF-8").into_bytes()),
            ("utf-16", wide("utf-16", "\u{feff}", u16::to_le_bytes)),
            ("UTF-16", wide("UTF-16", "\u{feff}", u16::to_be_bytes)),
            ("UTF-16LE", wide("UTF-16LE", "", u16::to_le_bytes)),
            ("utf-16be", wide("utf-16be", "", u16::to_be_bytes)),
            ("windows-1252", single("windows-1252", 0x80)),
            ("ISO-8859-15", single("ISO-8859-15", 0xa4)),
        ] {
            let found = decoded(&bytes, "f.xml").unwrap();
            assert_eq!(found.text, text(name));
            assert_eq!(found.doubts, [], "{name}");
        }
        let latin = b"<?xml version='1.0' encoding=\"ISO-8859-1\"?><a b='\xe9'/>";
        assert!(decoded(latin, "f.xml").unwrap().text.contains('\u{e9}'));
        // A mark that the declaration contradicts is true, and said.
        let marked =
            decoded(&wide("UTF-8", "\u{feff}", u16::to_le_bytes), "f.xml").map(|d| d.doubts);
        assert!(
            marked.unwrap()[0]
                .message
                .ends_with("read as UTF-16LE, which it is")
        );
    }
}
