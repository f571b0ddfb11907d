//! Marked scenarios, and the batch over them that awaits confirmation.

use std::collections::HashSet;
use std::sync::Arc;

use super::List;
use crate::message::JobId;
use crate::message::runs::{Batch, Counts};
use nearmiss_formats::{Entry, EntryLocation};

/// The marked scenarios, by where they lie: the list may be read again.
#[derive(Debug, Default)]
pub struct MarkedScenarios(HashSet<EntryLocation>);

impl MarkedScenarios {
    /// Whether a scenario is marked.
    #[must_use]
    pub fn has(&self, entry: &Entry) -> bool {
        self.0.contains(&entry.place)
    }

    /// Marks a scenario, or takes the mark away.
    pub fn toggle(&mut self, entry: &Entry) {
        if !self.0.remove(&entry.place) {
            self.0.insert(entry.place.clone());
        }
    }

    /// Takes all marks away.
    pub fn clear(&mut self) {
        self.0.clear();
    }

    /// How many scenarios of the list are marked, whatever the filter.
    #[must_use]
    pub fn count(&self, list: &List) -> usize {
        if self.0.is_empty() {
            0
        } else {
            list.rows.iter().filter(|row| self.has(&row.entry)).count()
        }
    }

    /// The marked scenarios in the list's order; all that the filter lets through where none is marked.
    #[must_use]
    pub fn chosen(&self, list: &List) -> Vec<Entry> {
        let rows = list.rows.iter().map(|row| &row.entry);
        let marked: Vec<Entry> = rows.filter(|entry| self.has(entry)).cloned().collect();
        if !marked.is_empty() {
            return marked;
        }
        let shown = list.visible.iter();
        shown.map(|&place| list.rows[place].entry.clone()).collect()
    }
}

/// A batch that waits for a yes.
#[derive(Debug)]
pub struct Card {
    /// Its number.
    pub id: JobId,
    /// The batch to ask.
    pub batch: Arc<Batch>,
    /// Counts so far.
    pub counts: Counts,
    /// Whether the scenarios were marked, or are all that are listed.
    pub marked: bool,
}

impl Card {
    /// Whether everything was counted.
    #[must_use]
    pub fn is_counted(&self) -> bool {
        self.counts.looked >= self.batch.entries.len()
    }
}
