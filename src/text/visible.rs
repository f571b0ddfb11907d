//! Making foreign text safe to show: control characters are shown, not obeyed.

use std::borrow::Cow;

/// `text` with every control character but line feeds and tabs replaced by its picture.
///
/// Also replaced are the marks that turn the direction of writing and the invisible twins of ASCII, which can disguise
/// what is said, and the line breaks that only some programs know.
#[must_use]
pub fn visible(text: &str) -> Cow<'_, str> {
    if text.chars().any(|c| picture(c).is_some()) {
        Cow::Owned(text.chars().map(|c| picture(c).unwrap_or(c)).collect())
    } else {
        Cow::Borrowed(text)
    }
}

/// Whether a character must not reach a terminal as it is.
#[must_use]
pub fn disguises(c: char) -> bool {
    picture(c).is_some()
}

/// What stands for a character that must not reach a terminal.
fn picture(c: char) -> Option<char> {
    match c {
        '\n' | '\t' => None,
        '\u{0}'..='\u{1f}' => char::from_u32(0x2400 + c as u32),
        '\u{7f}' => Some('\u{2421}'),
        '\u{80}'..='\u{9f}'
        | '\u{61c}'
        | '\u{200e}'
        | '\u{200f}'
        | '\u{2028}'..='\u{202e}'
        | '\u{2066}'..='\u{2069}'
        | '\u{e0000}'..='\u{e007f}' => Some(char::REPLACEMENT_CHARACTER),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn escapes_are_shown() {
        assert_eq!(visible("a\u{1b}[31mb\r\n"), "a\u{241b}[31mb\u{240d}\n");
        for hidden in [
            '\u{61c}',
            '\u{2028}',
            '\u{202e}',
            '\u{2066}',
            '\u{e0041}',
            '\u{9b}',
        ] {
            assert_eq!(visible(&hidden.to_string()), "\u{fffd}", "{hidden:?}");
        }
        assert!(matches!(visible("plain ü"), Cow::Borrowed(_)));
    }
}
