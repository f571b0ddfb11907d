//! Results of stored answers: a matrix, the answers behind a cell, and the list of sources to count.

use ratatui::layout::{Position, Rect};

use crate::model::PageId;
use nearmiss_store::RunId;
use nearmiss_study::evaluation::batch::{AnswerSet, CountingChoice};
use nearmiss_study::evaluation::{AnswerOutcome, Outcome, Results};
use nearmiss_workflow::TruthChoice;

/// The screen of results.
#[derive(Debug, Default)]
pub struct ResultsView {
    /// The newest reading that was asked for.
    pub asked: PageId,
    /// Whether it is on its way.
    pub reading: bool,
    /// While scenarios are opened to find out what is true about what is shown: how many of how many are done.
    pub judging: Option<(usize, usize)>,
    /// The truth that the user chose.
    pub chosen_truth: TruthChoice,
    /// What the answers in the rows are compared with.
    pub truth: TruthChoice,
    /// What else they could be compared with.
    pub truths: Vec<TruthChoice>,
    /// The column that rows are sorted by, and whether the lowest come first; `None` is the order of prompts.
    pub order: Option<(usize, bool)>,
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
    /// Runs that are not counted: how many, and why.
    pub left_out: Vec<String>,
    /// How far the test split is that may not be counted yet; there are no rows then.
    pub locked: Option<String>,
    /// The selected row.
    pub selected: usize,
    /// The selected column: 0 is the whole row, then the outcomes in their order, then precision, recall, F1 and what is
    /// right of all asked.
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

    /// What the answers are compared with, in words.
    #[must_use]
    pub fn truth_words(&self) -> String {
        match (self.counting, self.offer()) {
            (Some(AnswerSet::Batch(..)), Some(offer)) if self.truth == TruthChoice::Usual => {
                offer.truth.clone()
            }
            _ => self.truth.label().into(),
        }
    }

    /// Takes the next truth; gives `false` where there is no other one.
    pub fn next_truth(&mut self) -> bool {
        let place = self.truths.iter().position(|truth| *truth == self.truth);
        let next = place.map_or(0, |place| (place + 1) % self.truths.len().max(1));
        match self.truths.get(next) {
            Some(truth) if *truth != self.truth => {
                self.chosen_truth = *truth;
                true
            }
            _ => false,
        }
    }

    /// Sorts by the selected column: the highest first, then the lowest, then by prompt again.
    pub fn sort_by_column(&mut self) {
        self.order = match self.order {
            Some((column, false)) if column == self.column => Some((column, true)),
            Some((column, true)) if column == self.column => None,
            _ => Some((self.column, false)),
        };
        self.sort();
    }

    /// Puts the rows into their order; the selected row stays selected.
    fn sort(&mut self) {
        let way = self.row().map(|row| row.configuration.clone());
        self.rows
            .sort_by(|a, b| a.configuration.cmp(&b.configuration));
        if let Some((column, lowest)) = self.order {
            self.rows.sort_by(|a, b| {
                // What has no value comes last either way.
                match (value(a, column), value(b, column)) {
                    (Some(a), Some(b)) if lowest => a.total_cmp(&b),
                    (Some(a), Some(b)) => b.total_cmp(&a),
                    (a, b) => b.is_some().cmp(&a.is_some()),
                }
            });
        }
        let mut rows = self.rows.iter();
        if let Some(place) = rows.position(|row| Some(&row.configuration) == way.as_ref()) {
            self.selected = place;
        }
    }

    /// Describes what is counted, with its ground truth.
    #[must_use]
    pub fn offer(&self) -> Option<&CountingChoice> {
        let counting = self.counting?;
        self.offers.iter().find(|offer| offer.counting == counting)
    }

    /// Takes what was read. What was selected stays selected where it is still there.
    pub fn take(&mut self, read: CountedAnswers) {
        let way = self.row().map(|row| row.configuration.clone());
        if self.counting != Some(read.counting) {
            self.inside = None;
        }
        self.reading = read.judging.is_some();
        self.judging = read.judging;
        (self.truth, self.truths) = (read.truth, read.truths);
        self.counting = Some(read.counting);
        self.offers = read.offers;
        self.unasked = read.unasked;
        self.left_out = read.left_out;
        self.locked = read.locked;
        self.rows = read.rows;
        let place = self
            .rows
            .iter()
            .position(|row| Some(&row.configuration) == way.as_ref());
        let last = self.rows.len().saturating_sub(1);
        self.selected = place.unwrap_or(self.selected).min(last);
        self.sort();
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

/// Columns of numbers: the whole row, the outcomes, and four shares.
pub const COLUMNS: usize = 1 + Outcome::ALL.len() + 4;

/// The number of a row in a column; `None` where there is none.
fn value(row: &Results, column: usize) -> Option<f64> {
    let counts = row.confusion();
    match column.checked_sub(1) {
        None => Some(row.answers.len() as f64),
        Some(place) => match (
            Outcome::ALL.get(place),
            place - Outcome::ALL.len().min(place),
        ) {
            (Some(outcome), _) => Some(f64::from(row.count(*outcome))),
            (None, 0) => counts.precision(),
            (None, 1) => counts.recall(),
            (None, 2) => counts.f1(),
            (None, _) => row.right_of_all(),
        },
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

/// Counts over stored answers.
#[derive(Debug)]
pub struct CountedAnswers {
    /// Which are counted.
    pub counting: AnswerSet,
    /// The choices.
    pub offers: Vec<CountingChoice>,
    /// A row for each way of asking.
    pub rows: Vec<Results>,
    /// Questions of the batch that were not asked, or not yet, or cannot be asked; they are not counted.
    pub unasked: usize,
    /// Runs that are not counted: how many, and why.
    pub left_out: Vec<String>,
    /// How far the test split is that may not be counted yet.
    pub locked: Option<String>,
    /// What they are compared with.
    pub truth: TruthChoice,
    /// What else they could be compared with.
    pub truths: Vec<TruthChoice>,
    /// While scenarios are opened to find out what is true about them: how many of how many are done.
    pub judging: Option<(usize, usize)>,
}
