//! Emphasis, code and links within a line of Markdown.

use std::ops::Range;

use ratatui::style::{Modifier, Style};

use super::Piece;
use crate::theme::Theme;

/// The pieces of a part of a line.
pub fn pieces(line: &str, range: Range<usize>, style: Style, theme: &Theme) -> Vec<Piece> {
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
