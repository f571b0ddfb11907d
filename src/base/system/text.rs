//! Bytes as text: byte order marks are passed over, and what is not UTF-8 is named with what to do.

/// A byte order mark in UTF-8, which some editors write in front of a text.
const MARK: &[u8] = b"\xef\xbb\xbf";

/// The text in `bytes`, without the byte order marks that it may begin with.
///
/// # Errors
/// What it is instead, with the line of the first byte that is no text.
pub fn text_of(bytes: Vec<u8>) -> Result<String, String> {
    let mut marks = 0;
    while bytes[marks..].starts_with(MARK) {
        marks += MARK.len();
    }
    let rest = &bytes[marks..];
    let wide = match rest {
        [0xff, 0xfe, 0, 0, ..] | [0, 0, 0xfe, 0xff, ..] => Some("UTF-32"),
        [0xff, 0xfe, ..] | [0xfe, 0xff, ..] => Some("UTF-16"),
        _ => None,
    };
    if let Some(wide) = wide {
        return Err(format!("the file is {wide}; save it as UTF-8"));
    }
    let line = |at: usize| 1 + rest[..at].iter().filter(|b| **b == b'\n').count();
    if let Some(at) = rest.iter().position(|b| *b == 0) {
        return Err(format!(
            "line {}: a zero byte; not a text file, or not UTF-8: save it as UTF-8",
            line(at)
        ));
    }
    if let Err(error) = std::str::from_utf8(rest) {
        let at = error.valid_up_to();
        return Err(format!(
            "line {}: not UTF-8 text (byte 0x{:02x}); save the file as UTF-8",
            line(at),
            rest[at]
        ));
    }
    let mut text = String::from_utf8(bytes).map_err(|error| error.to_string())?;
    text.drain(..marks);
    Ok(text)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn marks_are_passed_over_and_other_encodings_named() {
        for marks in 0..4 {
            let text = format!("{}a = \"µ\"\n", "\u{feff}".repeat(marks));
            assert_eq!(text_of(text.into_bytes()).unwrap(), "a = \"µ\"\n");
        }
        assert_eq!(text_of(Vec::new()).unwrap(), "");
        // Elsewhere a mark is a character like others.
        assert_eq!(text_of("a\u{feff}".into()).unwrap(), "a\u{feff}");
        let wide = |text: &str, unit: fn(u16) -> [u8; 2]| -> Vec<u8> {
            text.encode_utf16().flat_map(unit).collect()
        };
        for (bytes, words) in [
            (wide("\u{feff}a", u16::to_le_bytes), "UTF-16; save"),
            (wide("\u{feff}a", u16::to_be_bytes), "UTF-16; save"),
            (wide("a\nb", u16::to_le_bytes), "line 1: a zero byte"),
            (wide("a\nb", u16::to_be_bytes), "line 1: a zero byte"),
            (b"\xff\xfe\0\0a\0\0\0".to_vec(), "UTF-32"),
            (b"a\nb\n\0".to_vec(), "line 3: a zero byte"),
            (b"a\ncaf\xe9".to_vec(), "line 2: not UTF-8 text (byte 0xe9"),
        ] {
            let said = text_of(bytes).unwrap_err();
            assert!(said.contains(words), "{said}");
        }
    }
}
