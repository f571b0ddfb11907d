//! The outline of an answer: which of its lines are text, code or JSON.

use crate::widgets::highlight::JsonParts;
use crate::widgets::markdown::table;

/// What a line of an answer is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Markdown.
    Text,
    /// Code in a fence.
    Code,
    /// The beginning or the end of a fence.
    Fence,
    /// JSON.
    Json(Json),
    /// A row of a table.
    Row(Row),
}

/// A row of a table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Row {
    /// Rows of the same table before it.
    pub before: usize,
    /// Cells of its first row.
    pub columns: usize,
}

/// A line of JSON.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Json {
    /// Lines of the same JSON before it.
    pub before: usize,
    /// Whether it is folded to one line where that is wanted: it is long, and not all that was said.
    pub folds: bool,
}

/// JSON in one line that is no longer than this is read as it is, bytes.
const SHORT: usize = 120;

/// Reads an answer line by line.
#[derive(Debug, Clone, Default)]
pub struct Outline {
    parts: JsonParts,
    /// Inside JSON: the line before.
    json: Option<Json>,
    /// Inside a table: the row before.
    row: Option<Row>,
    /// Inside a fence: its signs, and whether JSON may stand in it.
    fence: Option<(usize, bool)>,
    /// Inside a fence around the whole answer, which is Markdown as without it.
    wrapped: bool,
    /// Whether something was said before.
    said: bool,
}

impl Outline {
    /// What the next line is.
    pub fn next(&mut self, line: &str) -> Kind {
        let kind = self.kind(line);
        if kind != Kind::Text || !table::is_row(line) {
            self.row = None;
            return kind;
        }
        let first = || Row {
            before: 0,
            columns: table::cells(line).len(),
        };
        let next = self.row.map(|row| Row {
            before: row.before + 1,
            ..row
        });
        let row = next.unwrap_or_else(first);
        self.row = Some(row);
        Kind::Row(row)
    }

    fn kind(&mut self, line: &str) -> Kind {
        let signs = fence(line);
        match self.fence {
            // JSON that is still open was cut off.
            Some((open, _)) if signs.is_some_and(|(n, word)| n >= open && word.is_empty()) => {
                self.fence = None;
                self.parts = JsonParts::default();
                self.json = None;
                return Kind::Fence;
            }
            None if self.json.is_none() => {
                if let Some((signs, word)) = signs {
                    let wraps = word.is_empty() && !self.said || ["markdown", "md"].contains(&word);
                    if wraps || self.wrapped && word.is_empty() {
                        self.wrapped = wraps;
                        return Kind::Fence;
                    }
                    self.fence = Some((signs, word.is_empty() || word.starts_with("json")));
                    return Kind::Fence;
                }
            }
            _ => {}
        }
        if self.fence.is_some_and(|(_, json)| !json) {
            self.said = true;
            return Kind::Code;
        }
        let is_json = self.parts.is_json(line);
        if let (true, Some(before)) = (is_json, self.json.filter(|_| !self.parts.begins())) {
            let json = Json {
                before: before.before + 1,
                ..before
            };
            self.json = Some(json);
            return Kind::Json(json);
        }
        if is_json {
            let short = self.parts.is_closed() && line.len() <= SHORT;
            let json = Json {
                before: 0,
                folds: self.said && !short && line.trim_start().starts_with('{'),
            };
            self.json = Some(json);
            return Kind::Json(json);
        }
        self.json = None;
        self.said |= !line.trim().is_empty();
        match self.fence {
            Some(_) => Kind::Code,
            None => Kind::Text,
        }
    }
}

/// The number of signs and the word of a line that begins or ends a fence.
fn fence(line: &str) -> Option<(usize, &str)> {
    let line = line.trim();
    let sign = line.chars().next().filter(|c| ['`', '~'].contains(c))?;
    let rest = line.trim_start_matches(sign);
    let signs = line.len() - rest.len();
    (signs >= 3 && !rest.contains('`')).then(|| (signs, rest.trim()))
}

/// Whether a byte of an answer is in JSON that folds.
#[must_use]
pub fn folds_at(text: &str, byte: usize) -> bool {
    let mut outline = Outline::default();
    let mut from = 0;
    for line in text.split_inclusive('\n') {
        let kind = outline.next(super::ended(line));
        from += line.len();
        if byte < from {
            return matches!(kind, Kind::Json(json) if json.folds);
        }
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kinds(text: &str) -> String {
        let mut outline = Outline::default();
        let kind = |line: &str| match outline.next(line) {
            Kind::Text => 't',
            Kind::Row(row) if row.before == 0 => 'R',
            Kind::Row(_) => 'r',
            Kind::Code => 'c',
            Kind::Fence => 'f',
            Kind::Json(json) if json.folds => 'J',
            Kind::Json(_) => 'j',
        };
        text.lines().map(kind).collect()
    }

    #[test]
    fn json_folds_after_something_was_said() {
        assert_eq!(kinds("why\n```json\n{\n \"a\": 1\n}\n```\nso"), "tfJJJft");
        assert_eq!(kinds("{\n \"a\": 1\n}\nso"), "jjjt");
        assert_eq!(kinds("why\n{\"a\": 1}\nso"), "tjt");
        assert_eq!(kinds("why\n{\n1\n}\n{\n2\n}"), "tJJJJJJ");
        // Code of other languages is no JSON; JSON that is cut off ends with its fence.
        assert_eq!(kinds("```python\n{\n```\nso"), "fcft");
        assert_eq!(kinds("why\n```\n{\n \"a\":\n```\nso"), "tfJJft");
        assert_eq!(
            kinds("why\n| a |\n|---|\n| 1 |\n\n|b|\n```x\n|c|"),
            "tRrrtRfc"
        );
        // An answer in a fence is read as without it.
        assert_eq!(
            kinds("```\n# why\n```json\n{\n1\n}\n```\n```\nso"),
            "ftfJJJfft"
        );
        assert_eq!(kinds("so:\n```md\n# why\n```\n```\n# why\n```"), "tftffcf");
        let text = "why\n```json\n{\n \"a\": 1\n}\n```\nso";
        let at = |words: &str| text.find(words).map(|at| folds_at(text, at));
        let expected = [Some(false), Some(true), Some(false)];
        assert_eq!([at("why"), at("\"a\""), at("so")], expected);
    }
}
