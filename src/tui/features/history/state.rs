//! The run history: the loaded part of the list, and the selected run.

use crate::action::Action;
use crate::model::{Model, PageId};
use nearmiss_formats::{Entry, bundled};
use nearmiss_scene::scenario::Transform;
use nearmiss_store::{Cursor, Edge, Filter, Page, Run, RunId, Summary};

/// The history of runs.
#[derive(Debug, Default)]
pub struct History {
    /// Words and filters as they are typed.
    pub line: String,
    /// The filter in force; an invalid line keeps that of the last valid one.
    pub filter: Filter,
    /// Why the line means nothing.
    pub wrong: Option<String>,
    /// The newest list that was asked for.
    pub asked: PageId,
    /// Which part of it is on its way.
    pub loading: Option<Edge>,
    /// Whether the store changed meanwhile.
    pub stale: bool,
    /// Runs at hand, the newest first: a stretch of the list around the selected one.
    pub rows: Vec<Summary>,
    /// Whether there are newer ones.
    pub newer: bool,
    /// Whether there are older ones.
    pub older: bool,
    /// The selected one, as a place in `rows`.
    pub selected: usize,
    /// How many runs fit, counted no further than [`COUNTED`].
    pub total: Option<u64>,
    /// The run whose details were asked for.
    pub wanted: Option<RunId>,
    /// The selected run whole, once it is here.
    pub details: Option<Box<Run>>,
    /// The built-in judge's verdict on a run's question; the inner option is `None` if unknown.
    pub truth: Option<(RunId, Option<bool>)>,
    /// Lines that the details are scrolled.
    pub scroll: usize,
    /// Whether the keys move the details.
    pub on_details: bool,
    /// An action to perform on a run once it is loaded completely.
    pub then: Option<(RunId, Action)>,
    /// The input line.
    pub typing: Option<InputPurpose>,
    /// Undo stack of deleted (or restored) runs.
    pub undo: Vec<(RunId, bool)>,
    /// Why the store cannot be read.
    pub error: Option<String>,
}

/// Purpose of the input line in the history.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum InputPurpose {
    /// Words and filters.
    Search,
    /// A note on a run.
    Note(RunId, String),
    /// A file to write to.
    Export(String),
}

/// Runs that are read at once.
pub const PAGE: usize = 100;
/// Runs at hand at most.
const MAX_RUNS: usize = 6 * PAGE;
/// Runs that fit are counted this far where there is a filter.
pub const COUNTED: u64 = 10_000;

impl History {
    /// Searches for these words and filters when the history opens next.
    pub fn search_for(&mut self, line: String) {
        self.filter = Filter::read(&line).unwrap_or_default();
        self.line = line;
        self.wrong = None;
        self.rows.clear();
        self.selected = 0;
        self.total = None;
    }

    /// The selected run's number.
    #[must_use]
    pub fn current(&self) -> Option<RunId> {
        self.rows.get(self.selected).map(|run| RunId(run.run))
    }

    /// The details, if they are those of the selected run.
    #[must_use]
    pub fn shown(&self) -> Option<&Run> {
        self.details
            .as_deref()
            .filter(|run| Some(run.id) == self.current())
    }

    /// Whether anything narrows the list down.
    #[must_use]
    pub fn is_filtered(&self) -> bool {
        self.filter != Filter::default()
    }

    /// Moves the selection; it stops at the ends of what is at hand.
    pub fn move_by(&mut self, lines: isize) {
        let last = self.rows.len().saturating_sub(1);
        self.selected = self.selected.saturating_add_signed(lines).min(last);
    }

    /// The part that has to be read next, if the selection is near an end of what is at hand.
    #[must_use]
    pub fn missing(&self) -> Option<Edge> {
        let near = PAGE / 2;
        if self.loading.is_some() {
            None
        } else if self.older && self.selected + near >= self.rows.len() {
            self.rows.last().map(|run| Edge::Older(Cursor::from(run)))
        } else if self.newer && self.selected < near {
            self.rows.first().map(|run| Edge::Newer(Cursor::from(run)))
        } else {
            None
        }
    }

    /// The part that is at hand, to be read again; from its newest run on.
    #[must_use]
    pub fn again(&self) -> (Edge, usize) {
        let first = self.rows.first().filter(|_| self.newer);
        let edge = first.map_or(Edge::Newest, |run| Edge::From(Cursor::from(run)));
        (edge, self.rows.len().clamp(PAGE, MAX_RUNS))
    }

    /// Takes a part of the list. The selected run stays selected where it is still there.
    pub fn take(&mut self, edge: Edge, page: Page) {
        let kept = self.current();
        match edge {
            Edge::Newest | Edge::From(_) => {
                self.rows = page.rows;
                self.older = page.more;
                self.newer &= edge != Edge::Newest;
            }
            Edge::Oldest => {
                self.rows = page.rows;
                self.newer = page.more;
                self.older = false;
                self.selected = self.rows.len().saturating_sub(1);
                return;
            }
            Edge::Older(_) => {
                self.rows.extend(page.rows);
                self.older = page.more;
                let over = self.rows.len().saturating_sub(MAX_RUNS);
                self.rows.drain(..over);
                self.newer |= over > 0;
            }
            Edge::Newer(_) => {
                self.rows.splice(..0, page.rows);
                self.newer = page.more;
                self.older |= self.rows.len() > MAX_RUNS;
                self.rows.truncate(MAX_RUNS);
            }
        }
        let place = kept.and_then(|id| self.rows.iter().position(|run| run.run == id.0));
        let last = self.rows.len().saturating_sub(1);
        self.selected = place.unwrap_or(self.selected).min(last);
    }
}

impl Model {
    /// Files that may be the scenario of this name, which may tell of a change: those of the list, else the bundled
    /// one.
    #[must_use]
    pub fn files_of(&self, name: &str) -> Vec<Entry> {
        let (name, _) = Transform::of_name(name);
        let rows = self.list.rows.iter().map(|row| &row.entry);
        let mut found: Vec<Entry> = rows
            .filter(|entry| entry.name == name)
            .take(4)
            .cloned()
            .collect();
        if found.is_empty() {
            found.extend(bundled().into_iter().find(|entry| entry.name == name));
        }
        found
    }
}
