//! Escapes untrusted text for display and output: control and invisible characters become visible.

use std::borrow::Cow;

/// `text` with every control character but line feeds and tabs replaced by its picture.
///
/// Also replaced are the marks that turn the direction of writing, the invisible twins of ASCII and all other
/// characters that cannot be seen, which can disguise what is said, and the line breaks that only some programs know.
/// What joins the parts of an emoji, or letters of a script that needs it, stays where it does that.
#[must_use]
pub fn visible(text: &str) -> Cow<'_, str> {
    if !text.chars().any(disguises) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(text.len());
    let (mut before, mut rest) = (None, text.chars().peekable());
    while let Some(c) = rest.next() {
        let stays = before.is_some_and(|before| belongs(before, c, rest.peek().copied()));
        shown.push(picture(c).filter(|_| !stays).unwrap_or(c));
        before = Some(c);
    }
    Cow::Owned(shown)
}

/// Whether a character must not reach a terminal as it is, whatever stands beside it.
#[must_use]
pub fn disguises(c: char) -> bool {
    picture(c).is_some()
}

/// JSON must escape only the control characters below U+0020; terminals obey those from U+007F on as well, and what
/// turns the direction of writing.
#[must_use]
pub fn escaped_json(json: &str) -> String {
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

/// What stands for a character that must not reach a terminal.
fn picture(c: char) -> Option<char> {
    match c {
        '\n' | '\t' | ' '..='~' => None,
        '\u{0}'..='\u{1f}' => char::from_u32(0x2400 + c as u32),
        '\u{7f}' => Some('\u{2421}'),
        '\u{80}'..='\u{9f}' => Some(char::REPLACEMENT_CHARACTER),
        c if is_invisible(c) => Some(char::REPLACEMENT_CHARACTER),
        _ => None,
    }
}

/// What Unicode calls a format character or ignores by default and no font draws, and the separators of lines.
fn is_invisible(c: char) -> bool {
    matches!(c,
        '\u{ad}' // hyphens that are not seen
        | '\u{34f}' | '\u{61c}' | '\u{115f}' | '\u{1160}' | '\u{17b4}' | '\u{17b5}'
        | '\u{180b}'..='\u{180f}'
        | '\u{200b}'..='\u{200f}' // spaces without width, joiners, directions
        | '\u{2028}'..='\u{202e}' // lines, paragraphs, directions
        | '\u{2060}'..='\u{206f}' // word joiner, invisible operators, directions
        | '\u{3164}' | '\u{ffa0}' // fillers
        | '\u{fe00}'..='\u{fe0f}' // variants
        | '\u{feff}' // byte order mark
        | '\u{fff0}'..='\u{fffb}'
        | '\u{13430}'..='\u{1345f}'
        | '\u{1bca0}'..='\u{1bca3}'
        | '\u{1d173}'..='\u{1d17a}'
        | '\u{e0000}'..='\u{e0fff}' // twins of ASCII, more variants
    )
}

/// Whether an invisible character does its work between these two.
fn belongs(before: char, c: char, after: Option<char>) -> bool {
    let joins = |joined: fn(char) -> bool| joined(before) && after.is_some_and(joined);
    match c {
        // Coloured or not: `⚠️`, `3️⃣`.
        '\u{fe0e}' | '\u{fe0f}' => is_symbol(before) || after == Some('\u{20e3}'),
        '\u{200d}' => {
            let symbol = is_symbol(before) || before == '\u{fe0f}';
            symbol && after.is_some_and(is_symbol) || joins(is_joining)
        }
        '\u{200c}' => joins(is_joining),
        _ => false,
    }
}

fn is_symbol(c: char) -> bool {
    matches!(c, '\u{a9}' | '\u{ae}' | '\u{203c}'..='\u{2049}' | '\u{2122}'..='\u{2bff}' | '\u{3030}'..='\u{303d}'
        | '\u{3297}'..='\u{3299}' | '\u{1f000}'..='\u{1faff}')
}

/// Letters of Arabic, of Indic scripts and of those after them, whose shapes joiners change.
fn is_joining(c: char) -> bool {
    let script =
        matches!(c, '\u{600}'..='\u{dff}' | '\u{1000}'..='\u{109f}' | '\u{1780}'..='\u{18aa}');
    script && !is_invisible(c)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn escapes_are_shown() {
        assert_eq!(visible("a\u{1b}[31mb\r\n"), "a\u{241b}[31mb\u{240d}\n");
        for hidden in [
            '\u{ad}',
            '\u{61c}',
            '\u{180e}',
            '\u{200b}',
            '\u{200c}',
            '\u{200d}',
            '\u{2028}',
            '\u{202e}',
            '\u{2060}',
            '\u{2064}',
            '\u{2066}',
            '\u{3164}',
            '\u{fe0f}',
            '\u{feff}',
            '\u{fff9}',
            '\u{1d173}',
            '\u{e0041}',
            '\u{e0100}',
            '\u{9b}',
        ] {
            assert_eq!(visible(&hidden.to_string()), "\u{fffd}", "{hidden:?}");
            assert_eq!(visible(&format!("a{hidden}b")), "a\u{fffd}b", "{hidden:?}");
        }
        assert!(matches!(visible("plain ü 猫 e\u{301}"), Cow::Borrowed(_)));
    }

    #[test]
    fn what_joins_stays_where_it_joins() {
        for whole in [
            "⚠\u{fe0f} brakes",
            "3\u{fe0f}\u{20e3}",
            "\u{1f468}\u{200d}\u{1f469}",
            "\u{2764}\u{fe0f}\u{200d}\u{1f525}",
            "می\u{200c}خواهم",
            "क्\u{200d}ष",
        ] {
            assert_eq!(visible(whole), whole);
        }
        // One is enough; a row of them can hold a message.
        assert_eq!(visible("⚠\u{fe0f}\u{fe0e}"), "⚠\u{fe0f}\u{fffd}");
        assert_eq!(visible("\u{1f468}\u{200d}a"), "\u{1f468}\u{fffd}a");
        assert_eq!(visible("⚠\u{200d}\u{200d}⚠"), "⚠\u{fffd}\u{fffd}⚠");
    }

    #[test]
    fn escaped_text_means_the_same() {
        let said = "a\u{1b}\u{9b}\u{202e}\u{200b}\u{feff}\u{e0041}ü猫";
        let json = serde_json::json!({ "said": said }).to_string();
        let escaped = escaped_json(&json);
        assert!(!escaped.chars().any(|c| c.is_control() || disguises(c)));
        let read: serde_json::Value = serde_json::from_str(&escaped).expect("this is JSON");
        assert_eq!(read["said"], said);
        assert_eq!(escaped_xml("<a b=\"\u{202e}ü\"/>"), "<a b=\"&#x202e;ü\"/>");
    }
}
