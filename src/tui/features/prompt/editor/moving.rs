//! Moves the cursor, finds, and undoes.

use std::time::Duration;

use edtui::actions::{Execute, SwitchMode};
use edtui::{EditorMode, Index2};
use nearmiss_settings::Keys;

use super::{Editor, rows, width_of};

impl Editor {
    /// Moves the cursor; with `select`, the selection follows.
    pub fn go(&mut self, row: usize, col: usize, select: bool) {
        self.selecting(select);
        self.state.cursor = Index2::new(row, col);
        self.clamp();
        self.history.rest();
    }

    /// Begins a selection at the cursor, or ends it, before a motion.
    pub fn selecting(&mut self, select: bool) {
        if self.keys == Keys::Vim {
            if select && self.state.mode != EditorMode::Visual {
                SwitchMode(EditorMode::Visual).execute(&mut self.state);
            }
        } else if select {
            self.anchor = self.anchor.or(Some(self.state.cursor));
        } else if !self.marking {
            self.anchor = None;
        }
    }

    /// Sets the mark, from where motions select.
    pub fn mark(&mut self) {
        self.marking = true;
        self.anchor = Some(self.state.cursor);
    }

    /// Clears the selection.
    pub fn unselect(&mut self) {
        self.anchor = None;
        self.marking = false;
        if self.state.mode == EditorMode::Visual {
            SwitchMode(EditorMode::Normal).execute(&mut self.state);
        }
        self.state.selection = None;
    }

    /// Selects everything.
    pub fn select_all(&mut self) {
        self.go(0, 0, false);
        self.selecting(true);
        let last = self.line_count() - 1;
        self.go(last, usize::MAX, true);
        if let Some(selection) = &mut self.state.selection {
            selection.end = self.state.cursor;
        }
    }

    /// A row of the screen up or down: long lines are wrapped, and the cursor goes where it looks as if it would.
    pub fn go_rows(&mut self, by: isize, select: bool) {
        let width = usize::from(self.drawn.borrow().area.2);
        let (mut row, col) = self.cursor();
        if width == 0 {
            return self.go(row.saturating_add_signed(by), col, select);
        }
        let wrapped = |row: usize| {
            let line = self.lines().nth(row).map_or(&[][..], Vec::as_slice);
            rows(line, width)
        };
        let mut parts = wrapped(row);
        let mut part = parts.iter().rposition(|p| p.start <= col).unwrap_or(0);
        let across = col - parts[part].start;
        for _ in 0..by.unsigned_abs() {
            if by < 0 && part > 0 {
                part -= 1;
            } else if by < 0 && row > 0 {
                row -= 1;
                parts = wrapped(row);
                part = parts.len() - 1;
            } else if by > 0 && part + 1 < parts.len() {
                part += 1;
            } else if by > 0 && row + 1 < self.line_count() {
                row += 1;
                parts = wrapped(row);
                part = 0;
            }
        }
        let shown = &parts[part];
        // The end of a wrapped row is the beginning of the next one.
        let last = if part + 1 < parts.len() {
            shown.end.saturating_sub(1).max(shown.start)
        } else {
            shown.end
        };
        let to = (shown.start + across).min(last);
        self.go(row, to, select);
    }

    /// Whether a cell of the screen shows the text.
    #[must_use]
    pub fn is_at(&self, x: u16, y: u16) -> bool {
        let (left, top, columns, rows) = self.drawn.borrow().area;
        x >= left && y >= top && x < left + columns && y < top + rows
    }

    /// Goes to the cell of the screen; says whether it is one of the text.
    pub fn go_to_cell(&mut self, x: u16, y: u16, select: bool) -> bool {
        let drawn = self.drawn.borrow().clone();
        let (left, top, ..) = drawn.area;
        if !self.is_at(x, y) {
            return false;
        }
        let Some((row, part)) = drawn.rows.get(usize::from(y - top)).or(drawn.rows.last()) else {
            return false;
        };
        let mut across = usize::from(x - left);
        let line = self.lines().nth(*row).cloned().unwrap_or_default();
        let mut col = part.start;
        for c in &line[part.start.min(line.len())..part.end.min(line.len())] {
            let width = width_of(*c);
            if across < width {
                break;
            }
            across -= width;
            col += 1;
        }
        self.go(*row, col, select);
        if select && let Some(selection) = &mut self.state.selection {
            selection.end = self.state.cursor;
        }
        true
    }
}

/// A word that is looked for; small letters stand for capitals too.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Find {
    /// The search text.
    pub text: String,
    /// Line and column where the search began.
    pub from: (usize, usize),
}

impl Find {
    /// Columns in a line where it begins.
    #[must_use]
    pub fn in_line(&self, line: &[char]) -> Vec<usize> {
        let pattern: Vec<char> = self.text.chars().collect();
        if pattern.is_empty() {
            return Vec::new();
        }
        let exact = pattern.iter().any(|c| c.is_uppercase());
        let same =
            |(a, b): (&char, &char)| a == b || !exact && a.to_lowercase().eq(std::iter::once(*b));
        let windows = line.windows(pattern.len()).enumerate();
        windows
            .filter(|(_, window)| window.iter().zip(&pattern).all(same))
            .map(|(at, _)| at)
            .collect()
    }

    /// Lines and columns of a text where it begins.
    #[must_use]
    pub fn places(&self, editor: &Editor) -> Vec<(usize, usize)> {
        let lines = editor.lines().enumerate();
        lines
            .flat_map(|(row, line)| self.in_line(line).into_iter().map(move |col| (row, col)))
            .collect()
    }
}

/// The place in `all` that comes after `from`, or before it; from the end on from the beginning.
#[must_use]
pub fn next(all: &[(usize, usize)], from: (usize, usize), forward: bool) -> Option<usize> {
    if all.is_empty() {
        return None;
    }
    Some(if forward {
        all.iter().position(|&at| at > from).unwrap_or(0)
    } else {
        let before = all.iter().rposition(|&at| at < from);
        before.unwrap_or(all.len() - 1)
    })
}

type Before = (String, Index2);

/// What changed a text.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Change {
    /// A typed character.
    Typed(char),
    /// A character that was taken away beside the cursor.
    Erased,
    /// Anything else, such as pasting or cutting: always a step of its own.
    Whole,
}

/// Changes that are undone together.
#[derive(Debug, Clone, Copy)]
struct Run {
    /// The last change of it.
    last: Change,
    /// Where the cursor was then; what follows there may belong to it.
    cursor: Index2,
    /// When that was.
    time: Duration,
}

/// Texts before and after.
#[derive(Debug, Default)]
pub struct History {
    back: Vec<Before>,
    forward: Vec<Before>,
    /// The run that may go on.
    run: Option<Run>,
}

/// Bytes of texts that are kept.
const MAX_HISTORY_BYTES: usize = 16 << 20;

/// A pause of this length ends a run.
const PAUSE: Duration = Duration::from_secs(1);

impl Run {
    /// Whether a change with the cursor at a place belongs to it.
    fn takes(&self, change: Change, cursor: Index2, now: Duration) -> bool {
        if self.cursor != cursor || now.saturating_sub(self.time) >= PAUSE {
            return false;
        }
        match (self.last, change) {
            // The space after a word belongs to the word; the next word is the next step.
            (Change::Typed(last), Change::Typed(next)) => {
                next != '\n' && last != '\n' && (!last.is_whitespace() || next.is_whitespace())
            }
            (Change::Erased, Change::Erased) => true,
            _ => false,
        }
    }
}

impl History {
    /// Remembers the text before a change: `old` with the cursor at `before`, which is at `after` now.
    pub fn record(
        &mut self,
        old: String,
        (before, after): (Index2, Index2),
        change: Change,
        now: Duration,
    ) {
        self.forward.clear();
        let goes_on = self
            .run
            .take()
            .is_some_and(|run| run.takes(change, before, now));
        if change != Change::Whole {
            self.run = Some(Run {
                last: change,
                cursor: after,
                time: now,
            });
        }
        if goes_on && !self.back.is_empty() {
            return;
        }
        self.back.push((old, before));
        let mut bytes: usize = self.back.iter().map(|(text, _)| text.len()).sum();
        let mut dropped = 0;
        while bytes > MAX_HISTORY_BYTES && dropped + 1 < self.back.len() {
            bytes -= self.back[dropped].0.len();
            dropped += 1;
        }
        self.back.drain(..dropped);
    }

    /// The cursor moved elsewhere: further typing starts a new step.
    pub fn rest(&mut self) {
        self.run = None;
    }

    /// A step back or forward from `now`.
    pub fn step(&mut self, back: bool, now: Before) -> Option<Before> {
        self.run = None;
        let (from, to) = if back {
            (&mut self.back, &mut self.forward)
        } else {
            (&mut self.forward, &mut self.back)
        };
        let before = from.pop()?;
        to.push(now);
        Some(before)
    }
}
