//! Places signs and words along one line so that none lies over another and words never touch; who comes first has the
//! place.

use std::ops::Range;

use ratatui::style::Style;
use ratatui::text::Span;

/// A cell that is taken: what stands there, and whether it belongs to a word.
#[derive(Clone)]
struct Taken {
    sign: char,
    style: Style,
    word: bool,
}

/// A line of so many columns. All signs and letters are one column wide.
pub struct LinePlacer {
    cells: Vec<Option<Taken>>,
}

impl LinePlacer {
    /// An empty line.
    pub fn new(width: usize) -> Self {
        Self {
            cells: vec![None; width],
        }
    }

    /// A sign at a column, unless something stands there already. Signs may stand side by side.
    pub fn sign(&mut self, at: usize, sign: char, style: Style) -> bool {
        let beside = |at: Option<usize>| {
            let cell = at.and_then(|at| self.cells.get(at));
            cell.is_some_and(|cell| cell.as_ref().is_some_and(|taken| taken.word))
        };
        if beside(at.checked_sub(1)) || beside(at.checked_add(1)) {
            return false;
        }
        match self.cells.get_mut(at) {
            Some(cell @ None) => {
                *cell = Some(Taken {
                    sign,
                    style,
                    word: false,
                });
                true
            }
            _ => false,
        }
    }

    /// Words at the first of these columns where they are whole and a cell stays free on both sides.
    pub fn words(
        &mut self,
        places: impl IntoIterator<Item = usize>,
        words: &str,
        style: Style,
    ) -> bool {
        let count = words.chars().count();
        let Some(from) = places.into_iter().find(|&from| self.has_room(from, count)) else {
            return false;
        };
        for (cell, sign) in self.cells[from..from + count].iter_mut().zip(words.chars()) {
            *cell = Some(Taken {
                sign,
                style,
                word: true,
            });
        }
        count > 0
    }

    fn has_room(&self, from: usize, count: usize) -> bool {
        let Some(to) = from.checked_add(count).filter(|to| *to <= self.cells.len()) else {
            return false;
        };
        let around = from.saturating_sub(1)..(to + 1).min(self.cells.len());
        self.cells[around].iter().all(Option::is_none)
    }

    /// Words behind a sign, else before it.
    pub fn words_beside(&mut self, at: usize, words: &str, style: Style) -> bool {
        let before = at.checked_sub(words.chars().count() + 1);
        self.words([at + 2].into_iter().chain(before), words, style)
    }

    /// Words in the middle below a column, else moved by up to their own length, the least move first.
    pub fn words_around(&mut self, at: usize, words: &str, style: Style) -> bool {
        let count = words.chars().count();
        let last = self.cells.len().saturating_sub(count);
        let middle = at.saturating_sub(count / 2).min(last);
        let moves = (0..=count).flat_map(|by| [middle.checked_sub(by), Some(middle + by)]);
        self.words(moves.flatten(), words, style)
    }

    /// A sign in every cell of a range that is still free.
    pub fn fill(&mut self, range: Range<usize>, sign: char, style: Style) {
        let to = range.end.min(self.cells.len());
        let free = self.cells[range.start.min(to)..to].iter_mut();
        for cell in free.filter(|cell| cell.is_none()) {
            *cell = Some(Taken {
                sign,
                style,
                word: false,
            });
        }
    }

    /// The line, a span for each column.
    pub fn spans(self) -> impl Iterator<Item = Span<'static>> {
        self.cells.into_iter().map(|cell| match cell {
            Some(taken) => Span::styled(taken.sign.to_string(), taken.style),
            None => Span::raw(" "),
        })
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn text(line: LinePlacer) -> String {
        line.spans().map(|span| span.content.into_owned()).collect()
    }

    /// What is placed, where, how long it is, and in which way.
    fn pieces() -> impl Strategy<Value = Vec<(usize, usize, u8)>> {
        prop::collection::vec((0..140_usize, 1..12_usize, 0..4_u8), 0..26)
    }

    proptest! {
        #[test]
        fn nothing_is_covered_cut_or_touched(width in 0..120_usize, pieces in pieces()) {
            let mut line = LinePlacer::new(width);
            let mut placed = Vec::new();
            for (i, (at, length, way)) in pieces.into_iter().enumerate() {
                // Every piece has a letter of its own.
                let letter = char::from(b'a' + u8::try_from(i).unwrap_or(0));
                let words = letter.to_string().repeat(length);
                let style = Style::new();
                let (done, length) = match way {
                    0 => (line.sign(at, letter, style), 1),
                    1 => (line.words([at], &words, style), length),
                    2 => (line.words_beside(at, &words, style), length),
                    _ => (line.words_around(at, &words, style), length),
                };
                placed.push((letter, if done { length } else { 0 }, way == 0));
            }
            let text = text(line);
            prop_assert_eq!(text.chars().count(), width);
            for (letter, length, sign) in placed {
                let there: Vec<usize> = text.char_indices().filter(|(_, c)| *c == letter).map(|(i, _)| i).collect();
                prop_assert_eq!(there.len(), length, "{} in {:?}", letter, &text);
                let (Some(first), Some(last)) = (there.first(), there.last()) else { continue };
                prop_assert_eq!(last - first + 1, length, "{} in {:?}", letter, &text);
                if !sign {
                    let free = |at: Option<usize>| at.and_then(|at| text.chars().nth(at)).is_none_or(|c| c == ' ');
                    prop_assert!(free(first.checked_sub(1)) && free(Some(last + 1)), "{} in {:?}", letter, &text);
                }
            }
        }
    }

    #[test]
    fn words_step_aside_and_who_comes_first_has_the_place() {
        let mut line = LinePlacer::new(20);
        let style = Style::new();
        assert!(line.sign(8, 'X', style) && !line.sign(8, 'm', style));
        assert!(line.words_beside(8, "contact", style));
        assert!(line.words_around(8, "8s", style), "before the sign");
        assert!(!line.words_around(19, "12s", style));
        line.fill(0..20, '-', style);
        assert_eq!(text(line), "-----8s-X-contact---");
    }
}
