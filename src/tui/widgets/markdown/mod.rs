//! Markdown of answers as it is read: markup becomes style, and every piece knows where it stands in the text.

mod inline;
pub mod table;

use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span};

use crate::theme::Theme;

/// A piece of a line as it is shown.
#[derive(Debug, Clone, PartialEq)]
pub struct Piece {
    /// The byte of the line where it stands; `None` for what stands in the place of markup.
    pub at: Option<usize>,
    /// What is shown.
    pub span: Span<'static>,
}

impl Piece {
    /// A part of the line.
    #[must_use]
    pub fn part(line: &str, range: std::ops::Range<usize>, style: Style) -> Self {
        Self {
            at: Some(range.start),
            span: Span::styled(line[range].to_string(), style),
        }
    }

    /// A sign in the place of markup.
    #[must_use]
    pub fn sign(text: impl Into<String>, style: Style) -> Self {
        Self {
            at: None,
            span: Span::styled(text.into(), style),
        }
    }
}

/// The pieces of a line that is shown as it is.
#[must_use]
pub fn pieces_of(line: Line<'static>) -> Vec<Piece> {
    let mut at = 0;
    let style = line.style;
    let pieces = line.spans.into_iter().map(|span| {
        let start = at;
        at += span.content.len();
        Piece {
            at: Some(start),
            span: span.patch_style(style),
        }
    });
    // A line's own style lies below those of its parts.
    pieces.collect()
}

/// A line of code in a fence.
#[must_use]
pub fn code(line: &str, theme: &Theme) -> Vec<Piece> {
    vec![
        Piece::sign("│ ", Style::new().fg(theme.dim)),
        Piece::part(line, 0..line.len(), Style::new().fg(theme.safe)),
    ]
}

/// A line outside of fences.
#[must_use]
pub fn line(line: &str, theme: &Theme) -> Vec<Piece> {
    let dim = Style::new().fg(theme.dim);
    let base = theme.base();
    let indent = line.len() - line.trim_start().len();
    let rest = &line[indent..];
    if let Some(level) = heading(rest) {
        let text = rest[level..].trim_start();
        let from = indent + rest.len() - text.len();
        let to = from + text.trim_end_matches(['#', ' ']).len();
        let mut style = Style::new().fg(theme.accent).add_modifier(Modifier::BOLD);
        if level <= 2 {
            style = style.add_modifier(Modifier::UNDERLINED);
        }
        return inline::pieces(line, from..to, style, theme);
    }
    if is_rule(rest) {
        return vec![Piece::sign("─".repeat(RULE), dim)];
    }
    if table::is_row(rest) {
        return table::alone(line, theme);
    }
    if let Some(quoted) = rest.strip_prefix('>') {
        let from = line.len() - quoted.trim_start().len();
        let mut pieces = vec![Piece::sign("▏ ", dim)];
        let style = base.add_modifier(Modifier::ITALIC);
        pieces.extend(inline::pieces(line, from..line.len(), style, theme));
        return pieces;
    }
    let mut pieces = Vec::new();
    let mut from = 0;
    if rest.starts_with(['-', '*', '+']) && rest[1..].starts_with(' ') {
        let accent = Style::new().fg(theme.accent);
        pieces.push(Piece::part(line, 0..indent, base));
        pieces.push(Piece::sign("• ", accent));
        from = line.len() - rest[1..].trim_start().len();
    }
    pieces.extend(inline::pieces(line, from..line.len(), base, theme));
    pieces
}

/// Columns of a rule.
const RULE: usize = 24;

/// The signs of a heading.
fn heading(rest: &str) -> Option<usize> {
    let level = rest.bytes().take_while(|b| *b == b'#').count();
    let ends = rest[level..].is_empty() || rest[level..].starts_with(' ');
    ((1..=6).contains(&level) && ends).then_some(level)
}

fn is_rule(rest: &str) -> bool {
    let signs = rest.replace(' ', "");
    let all = |sign: char| signs.len() >= 3 && signs.chars().all(|c| c == sign);
    ['-', '*', '_'].into_iter().any(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(text: &str) -> (String, Vec<Piece>) {
        let pieces = line(text, &Theme::default_theme());
        let words = pieces.iter().map(|p| p.span.content.as_ref()).collect();
        (words, pieces)
    }

    #[test]
    fn markup_becomes_style_and_every_piece_knows_its_place() {
        for (raw, wanted) in [
            ("# Why ##", "Why"),
            ("1. **7** is *near*, __very__ _so_", "1. 7 is near, very so"),
            ("  - one `a*b` two", "  • one a*b two"),
            ("***both*** and **bold *in* it**", "both and bold in it"),
            ("> said **so**", "▏ said so"),
            ("| a | **b** |", "a │ b"),
            ("|---|:-:|", "──┼──"),
            (
                "see [the rule](https://x.org/a_b)",
                "see the rule (https://x.org/a_b)",
            ),
            ("***", "────────────────────────"),
            // What is no markup stays.
            (
                "2 * 3 * 4 = 24, a_b_c, 5 ** 2",
                "2 * 3 * 4 = 24, a_b_c, 5 ** 2",
            ),
            ("**open and `open", "**open and `open"),
            ("\\*literal\\* #5 of 3", "*literal* #5 of 3"),
            ("ü **größer** als", "ü größer als"),
            ("", ""),
        ] {
            let (words, pieces) = shown(raw);
            assert_eq!(words, wanted, "{raw}");
            for piece in pieces {
                if let Some(at) = piece.at {
                    let there = raw[at..].starts_with(piece.span.content.as_ref());
                    assert!(there, "{raw}: {piece:?}");
                }
            }
        }
        let (_, pieces) = shown("is **very** near");
        let bold = pieces
            .iter()
            .find(|p| p.span.content == "very")
            .map(|p| p.span.style.add_modifier.contains(Modifier::BOLD));
        assert_eq!(bold, Some(true));
    }
}
