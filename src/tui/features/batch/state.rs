//! Marked scenarios, and the batch over them that awaits confirmation.

use std::collections::HashSet;
use std::sync::Arc;

use crate::model::{JobId, List};
use nearmiss_ask::prompts::{Library, Techniques};
use nearmiss_formats::{Entry, EntryLocation};
use nearmiss_scene::description::Frame;
use nearmiss_scene::metrics::Thresholds;
use nearmiss_scene::verdict::Task;
use nearmiss_study::evaluation::batch::{Estimate, Experiment};

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
pub struct BatchProposal {
    /// Its number.
    pub id: JobId,
    /// The batch to ask.
    pub batch: Arc<Batch>,
    /// Counts so far.
    pub counts: Counts,
    /// Whether the scenarios were marked, or are all that are listed.
    pub marked: bool,
}

impl BatchProposal {
    /// Whether everything was counted.
    #[must_use]
    pub fn is_counted(&self) -> bool {
        self.counts.looked >= self.batch.entries.len()
    }
}

/// One question to one model about many scenarios.
#[derive(Debug)]
pub struct Batch {
    /// The task.
    pub task: Task,
    /// From where scenes are described.
    pub frame: Frame,
    /// How it is asked.
    pub techniques: Techniques,
    /// All that is asked.
    pub experiment: Experiment,
    /// Steps in a window.
    pub history: usize,
    /// The templates.
    pub library: Library,
    /// The text of the template where it is not saved: its file and the text.
    pub draft: Option<(String, String)>,
    /// The thresholds of risk scores.
    pub thresholds: Arc<Thresholds>,
    /// The model, `provider/model`.
    pub model: String,
    /// About which scenarios.
    pub entries: Vec<Entry>,
}

/// The estimate of a batch before it is asked.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Counts {
    /// Recordings that were read to draw windows, and how many there are.
    pub read: (usize, usize),
    /// Scenarios that were looked at.
    pub looked: usize,
    /// How many safe scenarios have no window to ask about, and why.
    pub left_out: Option<String>,
    /// Those of them whose truth is unknown: they are left out.
    pub unlabelled: usize,
    /// The size of the questions.
    pub estimate: Estimate,
    /// Why nothing would be sent, as things stand.
    pub refused: Option<String>,
    /// Requests at once.
    pub at_once: usize,
    /// US dollars left of the session's budget, if there is one.
    pub budget: Option<f64>,
}
