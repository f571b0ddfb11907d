//! What all stored answers come to: a matrix, and the answers behind one of its cells.

use crate::evaluation::{Counted, Outcome, Results};
use crate::store::RunId;
use crate::tui::message::runs::PageId;

/// The screen of results.
#[derive(Debug, Default)]
pub struct ResultsView {
    /// The newest reading that was asked for.
    pub asked: PageId,
    /// Whether it is on its way.
    pub reading: bool,
    /// Why the store cannot be read.
    pub error: Option<String>,
    /// A row for each way of asking.
    pub rows: Vec<Results>,
    /// The selected row.
    pub selected: usize,
    /// The selected cell: 0 is the whole row, then the outcomes in their order.
    pub column: usize,
    /// The answer that is selected among those of the cell; nothing where the matrix is looked at.
    pub inside: Option<usize>,
    /// The run that is to be opened once it is here.
    pub wanted: Option<RunId>,
}

impl ResultsView {
    /// The selected row.
    #[must_use]
    pub fn row(&self) -> Option<&Results> {
        self.rows.get(self.selected)
    }

    /// The outcome of the selected cell; nothing for the whole row.
    #[must_use]
    pub fn outcome(&self) -> Option<Outcome> {
        Outcome::ALL.get(self.column.checked_sub(1)?).copied()
    }

    /// The answers of the selected cell.
    #[must_use]
    pub fn answers(&self) -> Vec<&Counted> {
        let wanted = self.outcome();
        let all = self.row().map_or(&[][..], |row| &row.answers);
        let fits = |a: &&Counted| wanted.is_none_or(|outcome| a.outcome == outcome);
        all.iter().filter(fits).collect()
    }

    /// Takes what was read. What was selected stays selected where it is still there.
    pub fn take(&mut self, rows: Vec<Results>) {
        let way = self.row().map(|row| row.way.clone());
        self.rows = rows;
        let place = self
            .rows
            .iter()
            .position(|row| Some(&row.way) == way.as_ref());
        let last = self.rows.len().saturating_sub(1);
        self.selected = place.unwrap_or(self.selected).min(last);
        self.settle();
    }

    /// Keeps the selected answer one of those that are listed.
    pub fn settle(&mut self) {
        let count = self.answers().len();
        self.inside = match self.inside {
            Some(_) if count == 0 => None,
            Some(place) => Some(place.min(count - 1)),
            None => None,
        };
    }

    /// Moves the selection by so many lines.
    pub fn move_by(&mut self, lines: isize) {
        match self.inside {
            Some(place) => self.inside = Some(place.saturating_add_signed(lines)),
            None => {
                let last = self.rows.len().saturating_sub(1);
                self.selected = self.selected.saturating_add_signed(lines).min(last);
            }
        }
        self.settle();
    }
}
