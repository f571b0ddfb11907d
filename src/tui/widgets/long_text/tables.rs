//! Tables of a long text: rows in the columns of their table.

use ratatui::text::Line;

use super::outline::{Kind, Row};
use super::{MarkedClaims, Placed, Reading, marked};
use crate::theme::Theme;
use crate::widgets::markdown::table::{self, Layout};

impl Reading {
    /// Whether the table of a row has its columns side by side.
    pub(super) fn aligns(&self, row: Row) -> bool {
        !self.is_raw() && Layout::fits(row.columns, usize::from(self.width))
    }

    /// A row as it is written, and drawn without its columns.
    fn row(&self, at: usize, marks: &MarkedClaims<'_>, theme: &Theme) -> (&str, Line<'static>) {
        let Placed { from, to, .. } = self.lines[at];
        let written = &self.text[from..to];
        let here = self.claims_in(at, marks);
        let pieces = table::pieces(written, theme);
        (written, marked(pieces, &here, from, marks.picked, theme))
    }

    /// A row in the columns of its table.
    pub(super) fn aligned(
        &mut self,
        at: usize,
        row: Row,
        marks: &MarkedClaims<'_>,
        theme: &Theme,
    ) -> Line<'static> {
        let first = at - row.before;
        if !self.tables.iter().any(|(line, _)| *line == first) {
            let rows = self.lines[first..]
                .iter()
                .enumerate()
                .take_while(|(i, l)| matches!(l.kind, Kind::Row(r) if r.before == *i))
                .map(|(i, _)| self.row(first + i, marks, theme));
            let layout = Layout::new(rows, usize::from(self.width));
            self.tables.push((first, layout));
        }
        let (written, drawn) = self.row(at, marks, theme);
        let found = self.tables.iter().find(|(line, _)| *line == first);
        match found {
            Some((_, layout)) => layout.row(written, drawn, row.before == 0, theme),
            None => drawn,
        }
    }
}
