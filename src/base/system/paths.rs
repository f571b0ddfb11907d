//! Paths in texts: with the home folder as `~`, and without folders for other machines.

use std::path::{Path, PathBuf};

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

#[cfg(test)]
mod tests {
    use super::without_folders;
    use super::*;

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
}
