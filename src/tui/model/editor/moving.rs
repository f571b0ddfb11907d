//! Cursor movement and selection.

use edtui::actions::{Execute, SwitchMode};
use edtui::{EditorMode, Index2};

use super::{Editor, rows, width_of};
use nearmiss_settings::Keys;

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
