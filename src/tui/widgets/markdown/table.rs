//! Tables: columns as wide as their widest cell, narrowed where the screen is too small.

use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span};
use unicode_segmentation::UnicodeSegmentation;
use unicode_width::UnicodeWidthStr;

use crate::theme::Theme;
use crate::widgets::markdown::Piece;

/// Stands between the cells of a row until their columns are known; no text that is shown has it.
const BETWEEN: &str = "\u{1f}";
/// What is drawn there, with its columns.
const LINE: &str = " │ ";
/// Columns of a cell at least, where it is cut.
const NARROWEST: usize = 5;

/// On which side the text of a column stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Side {
    Left,
    Middle,
    Right,
}

/// Whether a line is a row of a table.
#[must_use]
pub fn is_row(line: &str) -> bool {
    line.trim_start().starts_with('|')
}

/// The cells of a row, without the spaces around them.
#[must_use]
pub fn cells(line: &str) -> Vec<std::ops::Range<usize>> {
    let inner = line.trim();
    let start = line.len() - line.trim_start().len();
    let inner_end = start + inner.len();
    let mut from = start + usize::from(inner.starts_with('|'));
    let mut all = Vec::new();
    let bars = line.match_indices('|').map(|(at, _)| at);
    let first = from;
    for at in bars.filter(|at| *at >= first && !line[..*at].ends_with('\\')) {
        all.push(from..at);
        from = at + 1;
    }
    if from < inner_end {
        all.push(from..inner_end);
    }
    let trimmed = |cell: std::ops::Range<usize>| {
        let text = &line[cell.clone()];
        let from = cell.start + text.len() - text.trim_start().len();
        from..(from + text.trim().len())
    };
    all.into_iter().map(trimmed).collect()
}

/// The row below the names of columns, which says on which side their text stands.
fn sides(line: &str) -> Option<Vec<Side>> {
    let all = cells(line).into_iter().map(|cell| {
        let text = &line[cell];
        let dashes = text.trim_matches(':');
        let is_rule = !dashes.is_empty() && dashes.bytes().all(|b| b == b'-');
        is_rule.then(|| match (text.starts_with(':'), text.ends_with(':')) {
            (true, true) => Side::Middle,
            (false, true) => Side::Right,
            _ => Side::Left,
        })
    });
    all.collect()
}

/// The pieces of a row, for [`Layout::row`].
#[must_use]
pub fn pieces(line: &str, theme: &Theme) -> Vec<Piece> {
    let mut pieces = Vec::new();
    for (i, cell) in cells(line).into_iter().enumerate() {
        if i > 0 {
            pieces.push(Piece::sign(BETWEEN, Style::new()));
        }
        pieces.extend(super::inline_pieces(line, cell, theme.base(), theme));
    }
    pieces
}

/// The pieces of a row that is drawn by itself, where its table has no room for columns.
#[must_use]
pub fn alone(line: &str, theme: &Theme) -> Vec<Piece> {
    let dim = Style::new().fg(theme.dim);
    if let Some(sides) = sides(line) {
        let rule = vec!["─"; sides.len()].join("─┼─");
        return vec![Piece::sign(rule, dim)];
    }
    let drawn = |piece: Piece| {
        if piece.at.is_none() && piece.span.content == BETWEEN {
            Piece::sign(LINE, dim)
        } else {
            piece
        }
    };
    pieces(line, theme).into_iter().map(drawn).collect()
}

/// The columns of a table.
#[derive(Debug, Clone)]
pub struct Layout {
    widths: Vec<usize>,
    sides: Vec<Side>,
}

impl Layout {
    /// Whether a table of so many columns has room side by side.
    #[must_use]
    pub fn fits(columns: usize, room: usize) -> bool {
        columns * (NARROWEST + LINE.width()) <= room + LINE.width()
    }

    /// Columns for rows: each as it is written and as it is drawn.
    pub fn new<'a>(rows: impl Iterator<Item = (&'a str, Line<'static>)>, room: usize) -> Self {
        let mut layout = Self {
            widths: Vec::new(),
            sides: Vec::new(),
        };
        for (i, (written, drawn)) in rows.enumerate() {
            if let Some(sides) = sides(written) {
                if i == 1 {
                    layout.sides = sides;
                }
                continue;
            }
            for (column, cell) in split(drawn).iter().enumerate() {
                let width = width(cell);
                match layout.widths.get_mut(column) {
                    Some(widest) => *widest = width.max(*widest),
                    None => layout.widths.push(width),
                }
            }
        }
        layout.narrow(room);
        layout
    }

    /// Takes what is missing from the widest columns.
    fn narrow(&mut self, room: usize) {
        let lines = LINE.width() * self.widths.len().saturating_sub(1);
        let mut over = (self.widths.iter().sum::<usize>() + lines).saturating_sub(room);
        while over > 0 {
            let widest = self.widths.iter_mut().max();
            let Some(widest) = widest.filter(|w| **w > NARROWEST) else {
                break;
            };
            *widest -= 1;
            over -= 1;
        }
    }

    /// A row in these columns; `heads` says whether it names them.
    #[must_use]
    pub fn row(
        &self,
        written: &str,
        drawn: Line<'static>,
        heads: bool,
        theme: &Theme,
    ) -> Line<'static> {
        let dim = Style::new().fg(theme.dim);
        if sides(written).is_some() {
            let rules: Vec<String> = self.widths.iter().map(|w| "─".repeat(*w)).collect();
            return Line::styled(rules.join("─┼─"), dim);
        }
        let mut spans = Vec::new();
        for (column, cell) in split(drawn).into_iter().enumerate() {
            if column > 0 {
                spans.push(Span::styled(LINE, dim));
            }
            let room = self.widths.get(column).copied().unwrap_or_default();
            let side = self.sides.get(column).copied().unwrap_or(Side::Left);
            spans.extend(placed(cell, room, side));
        }
        if heads {
            let bold = Style::new().add_modifier(Modifier::BOLD);
            spans = spans.into_iter().map(|s| s.patch_style(bold)).collect();
        }
        Line::from(spans)
    }
}

/// The cells of a row that is drawn.
fn split(line: Line<'static>) -> Vec<Vec<Span<'static>>> {
    let mut cells = vec![Vec::new()];
    for span in line.spans {
        match (span.content == BETWEEN, cells.last_mut()) {
            (false, Some(cell)) => cell.push(span),
            _ => cells.push(Vec::new()),
        }
    }
    cells
}

fn width(cell: &[Span<'_>]) -> usize {
    cell.iter().map(Span::width).sum()
}

/// A cell with spaces around it, or cut where it is too wide.
fn placed(cell: Vec<Span<'static>>, room: usize, side: Side) -> Vec<Span<'static>> {
    let free = room.saturating_sub(width(&cell));
    let before = match side {
        Side::Left => 0,
        Side::Middle => free / 2,
        Side::Right => free,
    };
    let mut spans = Vec::new();
    if before > 0 {
        spans.push(Span::raw(" ".repeat(before)));
    }
    spans.extend(cut(cell, room));
    if free > before {
        spans.push(Span::raw(" ".repeat(free - before)));
    }
    spans
}

/// As much of a cell as there is room for.
fn cut(cell: Vec<Span<'static>>, room: usize) -> Vec<Span<'static>> {
    if width(&cell) <= room {
        return cell;
    }
    let mut left = room.saturating_sub(1);
    let mut spans = Vec::new();
    for span in cell {
        let mut text = String::new();
        for grapheme in span.content.graphemes(true) {
            let Some(rest) = left.checked_sub(grapheme.width()) else {
                text.push('…');
                text.extend(std::iter::repeat_n(' ', left));
                spans.push(Span::styled(text, span.style));
                return spans;
            };
            left = rest;
            text.push_str(grapheme);
        }
        spans.push(Span::styled(text, span.style));
    }
    spans
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawn(table: &[&str], room: usize) -> Vec<String> {
        let theme = Theme::default_theme();
        let line = |row: &str| -> Line<'static> {
            let spans = pieces(row, &theme).into_iter().map(|p| p.span);
            Line::from_iter(spans)
        };
        let layout = Layout::new(table.iter().map(|row| (*row, line(row))), room);
        let rows = table.iter().enumerate();
        rows.map(|(i, row)| layout.row(row, line(row), i == 0, &theme).to_string())
            .collect()
    }

    const TABLE: [&str; 4] = [
        "| id | what | metres |",
        "|---|:-:|--:|",
        "| 301 | **cuts in** | 7.25 |",
        "|7|in front of `a\\|b`| 12 |",
    ];

    #[test]
    fn columns_are_as_wide_as_their_widest_cell() {
        let wanted = [
            "id  │      what       │ metres",
            "────┼─────────────────┼───────",
            "301 │     cuts in     │   7.25",
            "7   │ in front of a\\|b │     12",
        ];
        let rows = drawn(&TABLE, 80);
        assert_eq!(rows[0].replace(' ', ""), wanted[0].replace(' ', ""));
        let widths: Vec<usize> = rows.iter().map(|row| row.width()).collect();
        assert!(widths.iter().all(|w| *w == widths[0]), "{rows:#?}");
        assert!(rows[2].ends_with("│   7.25"), "{rows:#?}");
        assert!(rows[2].starts_with("301 │  "), "{rows:#?}");
    }

    #[test]
    fn the_widest_column_is_cut_where_there_is_no_room() {
        let rows = drawn(&TABLE, 24);
        assert!(rows.iter().all(|row| row.width() == 24), "{rows:#?}");
        assert!(rows[3].contains('…'), "{rows:#?}");
        assert!(rows[3].ends_with("│     12"), "{rows:#?}");
        assert!(Layout::fits(3, 24) && !Layout::fits(4, 24));
    }

    #[test]
    fn bars_that_are_meant_as_themselves_part_no_cells() {
        let texts = |line: &'static str| -> Vec<&str> {
            cells(line).into_iter().map(|cell| &line[cell]).collect()
        };
        assert_eq!(texts("| a \\| b | c |"), ["a \\| b", "c"]);
        assert_eq!(texts("| a | | c"), ["a", "", "c"]);
        assert!(texts("|").is_empty());
        assert_eq!(sides("|--|:-|"), Some(vec![Side::Left, Side::Left]));
        assert_eq!(sides("| - 3 |"), None);
    }
}
