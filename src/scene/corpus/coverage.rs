//! How many windows there are of each manoeuvre, on each road, of each severity.

use std::collections::BTreeMap;

use crate::metrics::SEVERITY_NAMES;

/// Severities from 0 (contact) to 5 (none).
pub const SEVERITIES: usize = SEVERITY_NAMES.len();

/// A row of the table.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Cell {
    /// Word of a manoeuvre.
    pub manoeuvre: String,
    /// Word of a road.
    pub road: String,
}

/// Windows by manoeuvre, road and severity.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Coverage {
    rows: BTreeMap<Cell, [u64; SEVERITIES]>,
}

impl Coverage {
    /// Counts a window; a severity beyond the table counts as the least one.
    pub fn add(&mut self, cell: Cell, severity: usize) {
        let row = self.rows.entry(cell).or_default();
        row[severity.min(SEVERITIES - 1)] += 1;
    }

    /// Counts several windows; none leave no row.
    pub fn add_many(&mut self, cell: Cell, severity: usize, windows: u64) {
        if windows > 0 {
            let row = self.rows.entry(cell).or_default();
            row[severity.min(SEVERITIES - 1)] += windows;
        }
    }

    /// The rows, with their windows by severity.
    pub fn rows(&self) -> impl Iterator<Item = (&Cell, &[u64; SEVERITIES])> {
        self.rows.iter()
    }

    /// Windows by severity.
    #[must_use]
    pub fn totals(&self) -> [u64; SEVERITIES] {
        let mut totals = [0; SEVERITIES];
        for row in self.rows.values() {
            for (total, count) in totals.iter_mut().zip(row) {
                *total += count;
            }
        }
        totals
    }

    /// The most windows of any cell.
    #[must_use]
    pub fn largest(&self) -> u64 {
        self.rows.values().flatten().copied().max().unwrap_or(0)
    }
}
