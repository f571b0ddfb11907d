//! Results of stored answers: a matrix, the answers behind a cell, and the list of sources to count.

use ratatui::layout::{Position, Rect};

use crate::evaluation::batch::{AnswerSet, CountingChoice};
use crate::evaluation::{AnswerOutcome, Outcome, Results};
use crate::store::RunId;
use crate::tui::message::runs::{CountedAnswers, PageId};

/// The screen of results.
#[derive(Debug, Default)]
pub struct ResultsView {
    /// The newest reading that was asked for.
    pub asked: PageId,
    /// Whether it is on its way.
    pub reading: bool,
    /// Whether the built-in judge is still at work on the truth of what is shown.
    pub judging: bool,
    /// Why the store cannot be read.
    pub error: Option<String>,
    /// The source the user chose to count.
    pub chosen: Option<AnswerSet>,
    /// The answers counted in the rows; `None` until they are read.
    pub counting: Option<AnswerSet>,
    /// The choices on offer.
    pub offers: Vec<CountingChoice>,
    /// The line of that list, while it is open.
    pub choosing: Option<usize>,
    /// A row for each way of asking.
    pub rows: Vec<Results>,
    /// Questions of the batch that were not asked; they are not counted.
    pub unasked: usize,
    /// The selected row.
    pub selected: usize,
    /// The selected cell: 0 is the whole row, then the outcomes in their order.
    pub column: usize,
    /// The answer that is selected among those of the cell; `None` if the matrix is looked at.
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

    /// The outcome of the selected cell; `None` for the whole row.
    #[must_use]
    pub fn outcome(&self) -> Option<Outcome> {
        Outcome::ALL.get(self.column.checked_sub(1)?).copied()
    }

    /// The answers of the selected cell.
    #[must_use]
    pub fn answers(&self) -> Vec<&AnswerOutcome> {
        let wanted = self.outcome();
        let all = self.row().map_or(&[][..], |row| &row.answers);
        let fits = |a: &&AnswerOutcome| wanted.is_none_or(|outcome| a.outcome == outcome);
        all.iter().filter(fits).collect()
    }

    /// Describes what is counted, with its ground truth.
    #[must_use]
    pub fn offer(&self) -> Option<&CountingChoice> {
        let counting = self.counting?;
        self.offers.iter().find(|offer| offer.counting == counting)
    }

    /// Takes what was read. What was selected stays selected where it is still there.
    pub fn take(&mut self, read: CountedAnswers) {
        let way = self.row().map(|row| row.way.clone());
        if self.counting != Some(read.counting) {
            self.inside = None;
        }
        self.reading = !read.whole;
        self.judging = !read.whole;
        self.counting = Some(read.counting);
        self.offers = read.offers;
        self.unasked = read.unasked;
        self.rows = read.rows;
        let place = self
            .rows
            .iter()
            .position(|row| Some(&row.way) == way.as_ref());
        let last = self.rows.len().saturating_sub(1);
        self.selected = place.unwrap_or(self.selected).min(last);
        self.settle();
    }

    /// Keeps what is selected one of those that are listed.
    pub fn settle(&mut self) {
        let last = self.offers.len().saturating_sub(1);
        self.choosing = self.choosing.map(|line| line.min(last));
        let count = self.answers().len();
        self.inside = match self.inside {
            Some(_) if count == 0 => None,
            Some(place) => Some(place.min(count - 1)),
            None => None,
        };
    }

    /// Moves the selection by this many lines.
    pub fn move_by(&mut self, lines: isize) {
        if let Some(line) = &mut self.choosing {
            *line = line.saturating_add_signed(lines);
            return self.settle();
        }
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

/// The screen of results as it was drawn.
#[derive(Debug, Clone, Default)]
pub struct ResultsDrawn {
    /// The rows of the list on top: of what can be counted, of answers, or of the matrix.
    pub list: Rect,
    /// The first row that is shown.
    pub top: usize,
    /// First columns and widths of the numbers of the matrix.
    pub cells: Vec<(u16, u16)>,
    /// The bars, and of which rows of the matrix they are.
    pub bars: (Rect, Vec<usize>),
}

impl ResultsDrawn {
    /// The row of the list at a position of the screen.
    #[must_use]
    pub fn row(&self, at: Position) -> Option<usize> {
        let inside = self.list.contains(at);
        inside.then(|| self.top + usize::from(at.y - self.list.y))
    }

    /// The number of the matrix at a column of the screen; beside them the first one, which is the whole row.
    #[must_use]
    pub fn cell(&self, x: u16) -> usize {
        let under = |(from, width): &(u16, u16)| (*from..from.saturating_add(*width)).contains(&x);
        self.cells.iter().position(under).unwrap_or(0)
    }

    /// The row of the matrix whose bar is at a position.
    #[must_use]
    pub fn bar(&self, at: Position) -> Option<usize> {
        let (area, rows) = &self.bars;
        let inside = area.contains(at);
        inside.then(|| rows.get(usize::from(at.y - area.y)).copied())?
    }
}
