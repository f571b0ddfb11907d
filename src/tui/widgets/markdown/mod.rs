//! Markdown of answers as it is read: markup becomes style, and every piece knows where it stands in the text.

pub mod table;

use std::ops::Range;

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

    /// It without what stands from a byte of the line on.
    #[must_use]
    pub fn until(mut self, end: usize) -> Self {
        if let Some(left) = self.at.map(|at| end.saturating_sub(at))
            && let Some(words) = self.span.content.get(..left)
        {
            self.span.content = words.to_string().into();
        }
        self
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
        return inline_pieces(line, from..to, style, theme);
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
        pieces.extend(inline_pieces(line, from..line.len(), style, theme));
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
    pieces.extend(inline_pieces(line, from..line.len(), base, theme));
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

/// The pieces of a part of a line.
fn inline_pieces(line: &str, range: Range<usize>, style: Style, theme: &Theme) -> Vec<Piece> {
    let mut inline = Inline {
        line,
        theme,
        pieces: Vec::new(),
    };
    inline.read(range, style, 0);
    inline.pieces
}

/// Emphasis in emphasis is read this deep.
const DEEPEST: usize = 8;

struct Inline<'a> {
    line: &'a str,
    theme: &'a Theme,
    pieces: Vec<Piece>,
}

impl Inline<'_> {
    fn read(&mut self, range: Range<usize>, style: Style, depth: usize) {
        let (mut plain, mut at) = (range.start, range.start);
        while at < range.end {
            let taken = match self.line.as_bytes()[at] {
                b'\\' => self.escaped(at..range.end),
                b'`' => self.code(at..range.end, style),
                b'*' | b'_' if depth < DEEPEST => self.emphasis(at..range.end, style, depth),
                b'[' if depth < DEEPEST => self.link(at..range.end),
                _ => None,
            };
            let Some(Taken { end, content }) = taken else {
                at += 1;
                continue;
            };
            self.push(plain..at, style);
            match content {
                Content::Literal(part) => self.push(part, style),
                Content::Styled(part, style) => self.push(part, style),
                Content::Nested(part, style) => self.read(part, style, depth + 1),
                Content::Link(part, target) => {
                    let style = style.add_modifier(Modifier::UNDERLINED);
                    self.read(part, style, depth + 1);
                    let dim = Style::new().fg(self.theme.dim);
                    self.pieces.push(Piece::sign(" (", dim));
                    self.push(target, dim);
                    self.pieces.push(Piece::sign(")", dim));
                }
            }
            (plain, at) = (end, end);
        }
        self.push(plain..range.end, style);
    }

    fn push(&mut self, part: Range<usize>, style: Style) {
        if !part.is_empty() {
            self.pieces.push(Piece::part(self.line, part, style));
        }
    }

    /// A sign that is meant as itself.
    fn escaped(&self, range: Range<usize>) -> Option<Taken> {
        let next = *self.line.as_bytes()[range.clone()].get(1)?;
        let end = range.start + 2;
        next.is_ascii_punctuation().then_some(Taken {
            end,
            content: Content::Literal(range.start + 1..end),
        })
    }

    fn code(&self, range: Range<usize>, style: Style) -> Option<Taken> {
        let text = &self.line[range.clone()];
        let signs = run(text, b'`');
        let mut from = signs;
        loop {
            let found = from + text[from..].find('`')?;
            let closing = run(&text[found..], b'`');
            if closing == signs {
                let inside = range.start + signs..range.start + found;
                return Some(Taken {
                    end: range.start + found + signs,
                    content: Content::Styled(inside, style.fg(self.theme.safe)),
                });
            }
            from = found + closing;
        }
    }

    fn emphasis(&self, range: Range<usize>, style: Style, depth: usize) -> Option<Taken> {
        let (line, start) = (self.line, range.start);
        let text = &line[range];
        let sign = text.as_bytes()[0];
        let signs = run(text, sign).min(3);
        let before = line[..start].chars().next_back();
        // `a_b` is a name, `2 * 3` a product.
        let opens = !text[signs..].starts_with(char::is_whitespace)
            && before.is_none_or(|c| c != char::from(sign))
            && (sign == b'*' || !before.is_some_and(char::is_alphanumeric));
        if !opens || depth >= DEEPEST {
            return None;
        }
        let closing = closing(text, sign, signs)?;
        let modifier = match signs {
            1 => Modifier::ITALIC,
            2 => Modifier::BOLD,
            _ => Modifier::BOLD | Modifier::ITALIC,
        };
        Some(Taken {
            end: start + closing + signs,
            content: Content::Nested(start + signs..start + closing, style.add_modifier(modifier)),
        })
    }

    /// `[text](target)`.
    fn link(&self, range: Range<usize>) -> Option<Taken> {
        let (start, text) = (range.start, &self.line[range]);
        let middle = text.find("](")?;
        let end = middle + text[middle..].find(')')?;
        let inner = &text[1..middle];
        if inner.is_empty() || inner.contains('[') {
            return None;
        }
        Some(Taken {
            end: start + end + 1,
            content: Content::Link(start + 1..start + middle, start + middle + 2..start + end),
        })
    }
}

/// What was read, and where what follows begins.
struct Taken {
    end: usize,
    content: Content,
}

enum Content {
    Literal(Range<usize>),
    Styled(Range<usize>, Style),
    Nested(Range<usize>, Style),
    Link(Range<usize>, Range<usize>),
}

/// How many of a sign a text begins with.
fn run(text: &str, sign: u8) -> usize {
    text.bytes().take_while(|b| *b == sign).count()
}

/// Where emphasis that a text begins with is closed: by as many signs after a word.
fn closing(text: &str, sign: u8, signs: usize) -> Option<usize> {
    let bytes = text.as_bytes();
    let mut at = signs;
    while at < bytes.len() {
        match bytes[at] {
            b'\\' => at += 2,
            b'`' => {
                // Code holds no emphasis.
                let ticks = run(&text[at..], b'`');
                let after = at + ticks;
                let end = text[after..].find(&"`".repeat(ticks));
                at = end.map_or(after, |end| after + end + ticks);
            }
            found if found == sign => {
                let many = run(&text[at..], sign);
                let word = text[..at].chars().next_back();
                let ends = word.is_some_and(|c| !c.is_whitespace());
                let next = text[at + many..].chars().next();
                let apart = sign == b'*' || !next.is_some_and(char::is_alphanumeric);
                let fits = many == signs || (many == 3 && signs < 3);
                if ends && apart && fits && at > signs {
                    // Of three signs the inner ones close what stands inside.
                    return Some(at + many - signs);
                }
                at += many;
            }
            _ => at += 1,
        }
    }
    None
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
