//! Texts for people: untrusted text and errors of the system in plain words, paths, and cells as wide as their column.

use std::borrow::Cow;
use std::io::{Error, ErrorKind};
use std::path::{Path, PathBuf};

use serde::Serialize;
use unicode_width::UnicodeWidthStr;

/// A count with its noun: `1 run`, `2 runs`.
#[must_use]
pub fn counted(count: usize, noun: &str) -> String {
    match count {
        1 => format!("1 {noun}"),
        _ => format!("{count} {noun}s"),
    }
}

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

/// Why the system refused something, for people: without error numbers, and without paths that the program made up
/// (those of temporary files). The caller names the path that is meant.
#[must_use]
pub fn error_text(error: &Error) -> String {
    let said = match error.kind() {
        ErrorKind::NotFound => "no such file or folder",
        ErrorKind::PermissionDenied => "permission denied",
        ErrorKind::IsADirectory => "is a folder, not a file",
        ErrorKind::NotADirectory => "part of this path is a file, not a folder",
        ErrorKind::ReadOnlyFilesystem => "the file system is read-only",
        ErrorKind::StorageFull => "no space left on the device",
        _ => return without_number(&error.to_string()),
    };
    said.to_string()
}

/// The standard library writes `Words (os error 5)`, and `tempfile` the path of its file behind that.
fn without_number(text: &str) -> String {
    let Some((said, _)) = text.split_once(" (os error ") else {
        return text.to_string();
    };
    let mut rest = said.chars();
    let first = rest.next().map(|c| c.to_lowercase().to_string());
    first.unwrap_or_default() + rest.as_str()
}

/// The whole path, with the home folder as `~`.
#[must_use]
pub fn shown_path(path: &Path) -> String {
    let whole = std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
    // `./x` is whole with a dot in it.
    let whole: PathBuf = whole.components().collect();
    below_home(&whole, std::env::home_dir().as_deref())
}

fn below_home(whole: &Path, home: Option<&Path>) -> String {
    let home = home.filter(|home| home.parent().is_some());
    match home.and_then(|home| whole.strip_prefix(home).ok()) {
        Some(rest) => Path::new("~").join(rest).display().to_string(),
        None => whole.display().to_string(),
    }
}

/// The text with each absolute path in it shortened to its last part: what is told of a file to people who have another
/// disk.
#[must_use]
pub fn without_folders(text: &str) -> String {
    let mut shown = String::with_capacity(text.len());
    let mut rest = text;
    let mut before = None;
    while let Some(first) = rest.chars().next() {
        if before.is_none_or(begins_word) && is_absolute(rest) {
            let end = end_of(rest);
            let (path, after) = rest.split_at(end);
            let last = path.rsplit(['/', '\\']).find(|part| !part.is_empty());
            shown.push_str(last.unwrap_or(path));
            before = path.chars().last();
            rest = after;
            continue;
        }
        shown.push(first);
        before = Some(first);
        rest = &rest[first.len_utf8()..];
    }
    shown
}

fn begins_word(before: char) -> bool {
    before.is_whitespace() || "\"'`(<[=,;".contains(before)
}

/// Whether a path of the whole disk, or of the home folder, begins here.
fn is_absolute(text: &str) -> bool {
    let drive = || {
        let mut all = text.chars();
        all.next().is_some_and(|c| c.is_ascii_alphabetic())
            && all.next() == Some(':')
            && matches!(all.next(), Some('\\' | '/'))
            && all.next() != Some('/')
    };
    text.starts_with('/') || text.starts_with("~/") || text.starts_with("\\\\") || drive()
}

/// Where a path ends: before a space, a quote or a bracket, and before `:` with what is said of the file behind it.
fn end_of(text: &str) -> usize {
    let mut all = text.char_indices().peekable();
    while let Some((at, c)) = all.next() {
        let next = all.peek().map(|(_, next)| *next);
        let ends = c.is_whitespace()
            || "\"'`)>],;".contains(c)
            || c == ':' && at > 1 && next.is_none_or(|c| c.is_whitespace() || c.is_ascii_digit());
        if ends {
            return at;
        }
    }
    text.len()
}

/// Detected capabilities of the terminal.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Terminal {
    /// Columns and rows; `None` if there is no terminal.
    pub size: Option<(u16, u16)>,
    /// Columns and rows that the workbench needs.
    pub least: (u16, u16),
    /// How many colours it has: `true`, `256`, `16` or `none`.
    pub colours: &'static str,
    /// Whether it shows more than ASCII.
    pub unicode: bool,
    /// Whether its background is dark; `None` if it did not tell.
    pub dark: Option<bool>,
}

/// Columns that cells are filled to at most. A longer text stands whole, and pushes what follows it.
const MAX_COLUMNS: usize = 256;

/// The columns of a terminal that a column of a table has for this text, at most 256.
#[must_use]
pub fn columns(text: &str) -> usize {
    text.width().min(MAX_COLUMNS)
}

/// `text` with spaces behind it, up to so many columns of a terminal, at most 256.
#[must_use]
pub fn pad_end(text: &str, columns: usize) -> String {
    let missing = columns.min(MAX_COLUMNS).saturating_sub(text.width());
    format!("{text}{}", " ".repeat(missing))
}

/// The same with the spaces before it.
#[must_use]
pub fn pad_start(text: &str, columns: usize) -> String {
    let missing = columns.min(MAX_COLUMNS).saturating_sub(text.width());
    format!("{}{text}", " ".repeat(missing))
}

/// An action with its keys.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, schemars::JsonSchema)]
pub struct KeyBinding {
    /// Where the keys work.
    pub scope: &'static str,
    /// The action, as in keymap.toml.
    pub action: &'static str,
    /// Its keys, the first one first.
    pub keys: Vec<String>,
    /// What it does.
    pub summary: &'static str,
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

    #[test]
    fn no_numbers_and_no_paths_of_its_own() {
        for kind in [ErrorKind::PermissionDenied, ErrorKind::Interrupted] {
            let wrapped = Error::new(kind, "Said so (os error 13) at path \"/a/.b.part\"");
            let said = error_text(&wrapped);
            assert!(
                !said.contains("os error") && !said.contains(".part"),
                "{said}"
            );
        }
        let permission = Error::new(
            ErrorKind::PermissionDenied,
            "Permission denied (os error 13)",
        );
        assert_eq!(error_text(&permission), "permission denied");
        assert_eq!(
            error_text(&Error::other("Too Many (os error 40)")),
            "too Many"
        );
        assert_eq!(
            error_text(&Error::other("The words as they are")),
            "The words as they are"
        );
    }

    #[cfg(unix)]
    #[test]
    fn no_error_of_the_system_shows_its_number() {
        for number in 1..=133 {
            let said = error_text(&Error::from_raw_os_error(number));
            assert!(
                !said.is_empty() && !said.contains("os error"),
                "{number}: {said}"
            );
        }
    }

    #[test]
    fn home_is_a_tilde_and_nothing_else_is() {
        let told = |path: &str, home: &str| below_home(Path::new(path), Some(Path::new(home)));
        assert_eq!(told("/home/ada/a/b.svg", "/home/ada"), "~/a/b.svg");
        assert_eq!(told("/home/adam/b.svg", "/home/ada"), "/home/adam/b.svg");
        assert_eq!(told("/srv/b.svg", "/"), "/srv/b.svg");
        assert!(shown_path(Path::new("./b.svg")).ends_with("/b.svg"));
        assert!(!shown_path(Path::new("./b.svg")).contains("/./"));
    }

    #[test]
    fn paths_become_names_and_nothing_else_changes() {
        for (text, told) in [
            ("/home/ada/a/b.xml: no such file", "b.xml: no such file"),
            ("(/srv/a.xml:12: x)", "(a.xml:12: x)"),
            ("cannot open `~/x/y.csv`", "cannot open `y.csv`"),
            ("at C:\\Users\\ada\\a.xml, twice", "at a.xml, twice"),
            ("http://localhost:8080/v1/a", "http://localhost:8080/v1/a"),
            ("3 m/s and/or 1 / 2", "3 m/s and/or 1 / 2"),
            ("/data/folder/ is empty", "folder is empty"),
            ("", ""),
        ] {
            assert_eq!(without_folders(text), told);
        }
    }

    #[test]
    fn cells_are_filled_to_columns_and_no_length_is_too_long() {
        assert_eq!(pad_end("a", 3) + "|", "a  |");
        assert_eq!(pad_start("a", 3), "  a");
        // Two columns each.
        assert_eq!(pad_end("車", 3), "車 ");
        assert_eq!(pad_end("wider", 3), "wider");
        let long = "x".repeat(70_000);
        assert_eq!(columns(&long), MAX_COLUMNS);
        assert_eq!(pad_end(&long, long.len()), long);
        assert_eq!(pad_start("a", usize::MAX).len(), MAX_COLUMNS);
    }
}
