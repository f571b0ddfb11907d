//! Highlighting of model answers: Markdown with embedded JSON.

use ratatui::text::Line;

use super::{Language, Painter};
use crate::theme::Theme;

/// Highlights an answer line by line: what is JSON in it as that, the rest as Markdown.
#[derive(Debug, Clone)]
pub struct AnswerPainter {
    parts: JsonParts,
    painter: Painter,
}

impl AnswerPainter {
    /// For a text that begins.
    #[must_use]
    pub fn new() -> Self {
        Self {
            parts: JsonParts::default(),
            painter: Painter::new(Language::Markdown),
        }
    }

    /// The next line, safe to show.
    pub fn line(&mut self, line: &str, theme: &Theme) -> Line<'static> {
        if let Some(language) = self.parts.begun_by(line) {
            self.painter = Painter::new(language);
        }
        self.painter.line(line, theme)
    }
}

/// The parts of an answer in their order. JSON begins with a brace or bracket that a line begins with, and ends
/// with the line in which they close; in fences or not. One that does not close yet is JSON to the end.
#[derive(Debug, Clone, Default)]
pub struct JsonParts {
    open: Option<BracketDepth>,
    /// Whether the line before closed a part.
    closed: bool,
    /// Whether the line before began one.
    began: bool,
}

impl JsonParts {
    /// Whether the next line is JSON.
    pub fn is_json(&mut self, line: &str) -> bool {
        let open = self.open.is_some();
        self.begun_by(line);
        open || self.began
    }

    /// Whether the last line began a part of JSON.
    #[must_use]
    pub fn begins(&self) -> bool {
        self.began
    }

    /// Whether no JSON is open.
    #[must_use]
    pub fn is_closed(&self) -> bool {
        self.open.is_none()
    }

    /// The language of the part that begins with the next line, if one does.
    fn begun_by(&mut self, line: &str) -> Option<Language> {
        let closed = std::mem::take(&mut self.closed);
        let begins =
            self.open.is_none() && line.trim_start().starts_with(['{', '[']) && !is_link(line);
        self.began = begins;
        if begins {
            self.open = Some(BracketDepth::default());
        }
        if let Some(depth) = &mut self.open
            && depth.closes(line)
        {
            self.open = None;
            self.closed = true;
        }
        match (begins, closed) {
            (true, _) => Some(Language::Json),
            (false, true) => Some(Language::Markdown),
            (false, false) => None,
        }
    }
}

/// Whether a line that begins with a bracket is a link or a box to tick of Markdown.
fn is_link(line: &str) -> bool {
    let line = line.trim();
    line.contains("](") || line.starts_with("[ ]") || line.starts_with("[x]")
}

/// How many braces and brackets are open.
#[derive(Debug, Clone, Default)]
struct BracketDepth {
    open: usize,
    string: bool,
}

impl BracketDepth {
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
        let mut parts = JsonParts::default();
        let mut found: Vec<(Language, String)> = Vec::new();
        for line in text.split_inclusive('\n') {
            match (parts.begun_by(line), found.last_mut()) {
                (None, Some((_, part))) => part.push_str(line),
                (begun, _) => found.push((begun.unwrap_or(Markdown), line.into())),
            }
        }
        let found: Vec<(Language, &str)> = found.iter().map(|(l, p)| (*l, p.as_str())).collect();
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
    }
}
