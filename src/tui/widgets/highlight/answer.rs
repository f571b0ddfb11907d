//! Answers of models: Markdown, with the JSON in it as JSON.

use ratatui::text::Text;

use super::{Language, lines};
use crate::tui::theme::Theme;

/// A text, safe to show: what is JSON in it is highlighted as that, the rest as Markdown.
#[must_use]
pub fn answer(text: &str, theme: &Theme) -> Text<'static> {
    let mut shown = Text::default();
    for (language, part) in parts(text) {
        shown.extend(lines(language, part.lines(), theme));
    }
    shown
}

/// The parts of an answer in their order. JSON begins with a brace or bracket that a line begins with, and ends
/// with the line in which they close; in fences or not. One that does not close yet is JSON to the end.
fn parts(text: &str) -> Vec<(Language, &str)> {
    let mut parts = Vec::new();
    let (mut start, mut at) = (0, 0);
    let mut open: Option<Depth> = None;
    for line in text.split_inclusive('\n') {
        let begins = || line.trim_start().starts_with(['{', '[']) && !is_link(line);
        if open.is_none() && begins() {
            if at > start {
                parts.push((Language::Markdown, &text[start..at]));
            }
            start = at;
            open = Some(Depth::default());
        }
        at += line.len();
        if let Some(depth) = &mut open
            && depth.closes(line)
        {
            parts.push((Language::Json, &text[start..at]));
            start = at;
            open = None;
        }
    }
    if at > start {
        let language = match open {
            Some(_) => Language::Json,
            None => Language::Markdown,
        };
        parts.push((language, &text[start..at]));
    }
    parts
}

/// Whether a line that begins with a bracket is a link or a box to tick of Markdown.
fn is_link(line: &str) -> bool {
    let line = line.trim();
    line.contains("](") || line.starts_with("[ ]") || line.starts_with("[x]")
}

/// How many braces and brackets are open.
#[derive(Default)]
struct Depth {
    open: usize,
    string: bool,
}

impl Depth {
    fn closes(&mut self, line: &str) -> bool {
        let mut escaped = false;
        for c in line.chars() {
            match c {
                _ if escaped => escaped = false,
                '\\' if self.string => escaped = true,
                '"' => self.string = !self.string,
                '{' | '[' if !self.string => self.open += 1,
                '}' | ']' if !self.string => self.open = self.open.saturating_sub(1),
                _ => {}
            }
        }
        // No string of JSON goes over a line.
        self.string = false;
        self.open == 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn json_is_found_in_fences_and_outside() {
        use Language::{Json, Markdown};
        let text = "# Why\n[a](b) is near\n```json\n{\n \"a\": \"}\",\n \"b\": [1]\n}\n```\nso\n{\"c\": 2}\n{\"d\":\n";
        let found = parts(text);
        assert_eq!(
            found,
            [
                (Markdown, "# Why\n[a](b) is near\n```json\n"),
                (Json, "{\n \"a\": \"}\",\n \"b\": [1]\n}\n"),
                (Markdown, "```\nso\n"),
                (Json, "{\"c\": 2}\n"),
                (Json, "{\"d\":\n"),
            ]
        );
        assert_eq!(found.iter().map(|(_, p)| *p).collect::<String>(), text);
        assert_eq!(parts(""), []);
    }
}
