//! Characters and words of malformed JSON.

/// Bytes of white space at the beginning of a text, with those that only typesetters know.
pub(super) fn skip_blank(text: &str) -> usize {
    text.len() - text.trim_start_matches(is_blank).len()
}

/// White space, and what has no width.
pub(super) fn is_blank(c: char) -> bool {
    c.is_whitespace() || matches!(c, '\u{feff}' | '\u{200b}')
}

/// Whether a character can open a string.
pub(super) fn is_quote(c: char) -> bool {
    matches!(c, '"' | '\'' | '“' | '”' | '‘' | '’')
}

/// The character that closes what another one opened.
pub(super) fn closing(open: char) -> char {
    match open {
        '“' | '”' => '”',
        '‘' | '’' => '’',
        other => other,
    }
}

/// Longest key without quotation marks.
const LONGEST_KEY: usize = 64;

/// Whether a text begins with a word or a few that could be a key, perhaps the end of a quotation, and a colon.
pub(super) fn is_bare_key(text: &str) -> bool {
    bare_key(text).is_some()
}

/// The key at the beginning of a text that has no quotation mark before it, and its bytes up to the colon.
pub(super) fn bare_key(text: &str) -> Option<(&str, usize)> {
    let mut end = 0;
    for c in text.chars() {
        let inside = c.is_alphanumeric() || matches!(c, '_' | '-' | '$');
        if !(inside || c == ' ' && end > 0) || end > LONGEST_KEY {
            break;
        }
        end += c.len_utf8();
    }
    let key = text[..end].trim_end();
    let mut rest = &text[end..];
    let mut length = end;
    if let Some(quote) = rest.chars().next().filter(|c| is_quote(*c)) {
        rest = &rest[quote.len_utf8()..];
        length += quote.len_utf8();
    }
    let near = window(rest, LONGEST_KEY);
    let blank = near.len() - near.trim_start_matches([' ', '\t']).len();
    let letter = key.chars().any(char::is_alphanumeric);
    (letter && rest[blank..].starts_with(':') && !rest[blank..].starts_with("://"))
        .then_some((key, length + blank))
}

/// The first bytes of a text, about `most` of them.
pub(super) fn window(text: &str, most: usize) -> &str {
    let mut end = text.len().min(most);
    while !text.is_char_boundary(end) {
        end -= 1;
    }
    &text[..end]
}
