//! What is said of a cell of the coverage map: how many windows and scenarios, and its worst windows.

use std::collections::HashSet;
use std::sync::Arc;

use crate::model::List;
use nearmiss_scene::corpus::{CellCounts, CellWindows, CorpusIndex, Manoeuvre, RoadType};

/// Windows that are listed of a cell at most.
const MOST: usize = 100;

/// A cell; nothing of a kind means all of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CellChoice {
    pub manoeuvre: Option<Manoeuvre>,
    pub road: Option<RoadType>,
    pub severity: Option<u8>,
}

/// A window of a cell, as the first of its scenario with that severity and type of obstacle.
#[derive(Debug, Clone)]
pub struct WorstWindow {
    /// Its scenario, by the place in the index.
    pub scenario: usize,
    /// Where it is, and how many are like it.
    pub window: CellWindows,
}

/// What is said of a cell.
#[derive(Debug, Clone)]
pub struct CellDetail {
    index: Arc<CorpusIndex>,
    choice: CellChoice,
    /// How many scenarios of the list were listed and read then.
    known: (usize, usize),
    /// Windows, and those that were asked about.
    pub windows: u64,
    pub asked: u64,
    /// Scenarios, and those of them that are in the list.
    pub scenarios: usize,
    pub listed: usize,
    /// The worst windows, one a scenario, severity and type of obstacle.
    pub worst: Vec<WorstWindow>,
}

impl CellChoice {
    fn holds(self, window: &CellWindows) -> bool {
        self.manoeuvre
            .is_none_or(|wanted| wanted == window.manoeuvre)
            && self.road.is_none_or(|wanted| wanted == window.road)
            && self.severity.is_none_or(|wanted| wanted == window.severity)
    }

    /// The filter of the list for it.
    pub fn filter(self) -> String {
        let manoeuvre = self
            .manoeuvre
            .map(|one| format!("manoeuvre:{}", one.name()));
        let road = self.road.map(|one| format!("road:{}", one.name()));
        let severity = self.severity.map(|one| format!("severity={one}"));
        let terms = [manoeuvre, road, severity].into_iter().flatten();
        match terms.collect::<Vec<_>>() {
            terms if terms.is_empty() => "has:index".into(),
            terms => terms.join(" "),
        }
    }

    /// Its windows and those asked about.
    pub fn sums(self, counts: &CellCounts) -> (u64, u64) {
        match self.severity.map(usize::from) {
            Some(severity) => (counts.windows[severity], counts.asked[severity]),
            None => (counts.windows.iter().sum(), counts.asked.iter().sum()),
        }
    }
}

impl CellDetail {
    /// Looks through the scenarios of an index.
    pub fn of(index: &Arc<CorpusIndex>, choice: CellChoice, list: &List) -> Self {
        let facts = list.rows.iter().filter_map(|row| row.facts());
        let listed: HashSet<&str> = facts.map(|facts| facts.hash.as_str()).collect();
        let (windows, asked) = choice.sums(&index.counts(choice.manoeuvre, choice.road));
        let mut detail = Self {
            index: Arc::clone(index),
            choice,
            known: (list.rows.len(), list.known),
            windows,
            asked,
            scenarios: 0,
            listed: 0,
            worst: Vec::new(),
        };
        for (place, scenario) in index.scenarios().iter().enumerate() {
            let mut found = scenario
                .windows
                .iter()
                .filter(|w| choice.holds(w))
                .peekable();
            if found.peek().is_none() {
                continue;
            }
            detail.scenarios += 1;
            detail.listed += usize::from(listed.contains(scenario.hash.as_str()));
            detail.worst.extend(found.map(|window| WorstWindow {
                scenario: place,
                window: window.clone(),
            }));
            // Only the worst are kept, so that a cell of many scenarios takes no room.
            if detail.worst.len() > 2 * MOST {
                detail.keep_worst();
            }
        }
        detail.keep_worst();
        detail
    }

    fn keep_worst(&mut self) {
        self.worst
            .sort_by_key(|one| (one.window.severity, one.scenario));
        self.worst.truncate(MOST);
    }

    /// Whether it is still what would be said.
    pub fn is_of(&self, index: &Arc<CorpusIndex>, choice: CellChoice, list: &List) -> bool {
        Arc::ptr_eq(&self.index, index)
            && self.choice == choice
            && self.known == (list.rows.len(), list.known)
    }
}
