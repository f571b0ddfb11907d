//! Windows by manoeuvre, road, severity and type: how many there are of each, and draws that cover a corpus.
//!
//! Each window has a random number that follows from the seed and the window alone, so that neither the order of
//! reading nor the division into parts changes what is drawn. Of each scenario a cell keeps one window, the one with the
//! lowest number.

use std::collections::{BTreeMap, HashMap, HashSet, VecDeque};

use strum::{IntoStaticStr, VariantArray};

use nearmiss_base::system::unknown;

use super::parts::{IndexError, PartRow};
use super::{Manoeuvre, RoadType};
use crate::metrics::SEVERITY_NAMES;
use crate::scenario::{ContentHash, ObstacleType};

/// What windows are told apart by.
#[derive(Debug, Clone, Copy, PartialEq, Eq, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "lowercase")]
pub enum Axis {
    /// The manoeuvre.
    Manoeuvre,
    /// The road.
    Road,
    /// The severity.
    Severity,
}

nearmiss_record::named!(Axis, "axis");

/// A window that may be drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct Candidate {
    /// The path of its scenario.
    pub path: String,
    /// What tells it from all others: scenario, ego, obstacle and steps.
    pub window: String,
    /// Its words on the axes.
    pub cell: Vec<String>,
}

/// A window that was drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct SampledWindow<T> {
    /// The window.
    pub candidate: Candidate,
    /// What was kept with it.
    pub row: T,
    /// Windows in its cell.
    pub windows: u64,
    /// Windows drawn from its cell.
    pub drawn: usize,
}

/// Draws windows.
#[derive(Debug)]
pub struct Sampler<T> {
    seed: u64,
    most: usize,
    cells: BTreeMap<Vec<String>, Retained<T>>,
}

/// What is kept of a cell.
#[derive(Debug)]
struct Retained<T> {
    windows: u64,
    /// By random number.
    best: BTreeMap<Number, (Candidate, T)>,
    /// The number of the window that is kept of a scenario.
    of_scenario: HashMap<String, Number>,
}

/// A random number that no two windows share.
type Number = [u8; 32];

impl<T> Sampler<T> {
    /// One that draws at most `most` windows.
    #[must_use]
    pub fn new(seed: u64, most: usize) -> Self {
        Self {
            seed,
            most,
            cells: BTreeMap::new(),
        }
    }

    /// Offers a window.
    pub fn offer(&mut self, candidate: Candidate, row: T) {
        let number = number(self.seed, &candidate.window);
        let kept = self
            .cells
            .entry(candidate.cell.clone())
            .or_insert_with(Retained::new);
        kept.windows += 1;
        if let Some(before) = kept.of_scenario.get(&candidate.path) {
            if *before <= number {
                return;
            }
            kept.best.remove(before);
        }
        kept.of_scenario.insert(candidate.path.clone(), number);
        kept.best.insert(number, (candidate, row));
        if kept.best.len() > self.most
            && let Some((_, (last, _))) = kept.best.pop_last()
        {
            kept.of_scenario.remove(&last.path);
        }
    }

    /// Cells that have windows.
    #[must_use]
    pub fn cells(&self) -> usize {
        self.cells.len()
    }

    /// Draws one window from every cell, then a second, and so on; scenarios that were not drawn before come first.
    #[must_use]
    pub fn draw(self) -> Vec<SampledWindow<T>> {
        let most = self.most;
        in_cells(self.into_order().take(most).collect())
    }

    /// The windows in the order of drawing, until there are none; how many of each cell are drawn is not said.
    #[must_use]
    pub fn into_order(self) -> DrawingOrder<T> {
        let mut cells = Vec::new();
        // Where there are more cells than draws, chance says which have one.
        let mut order: Vec<(Number, usize)> = Vec::new();
        for (place, (cell, kept)) in self.cells.into_iter().enumerate() {
            order.push((number(self.seed, &cell.join("\n")), place));
            cells.push(Undrawn {
                windows: kept.windows,
                unseen: kept.best.into_values().collect(),
                seen: VecDeque::new(),
            });
        }
        order.sort_unstable();
        DrawingOrder {
            cells,
            order: order.into_iter().map(|(_, place)| place).collect(),
            next: 0,
            scenarios: HashSet::new(),
        }
    }
}

/// Windows in the order of drawing.
#[derive(Debug)]
pub struct DrawingOrder<T> {
    cells: Vec<Undrawn<T>>,
    /// Places of cells.
    order: Vec<usize>,
    /// The place in `order` of the next cell.
    next: usize,
    /// Paths of scenarios that were drawn.
    scenarios: HashSet<String>,
}

/// What was not drawn of a cell.
#[derive(Debug)]
struct Undrawn<T> {
    windows: u64,
    /// Windows in order.
    unseen: VecDeque<(Candidate, T)>,
    /// Of these, windows that were passed over since their scenarios were drawn before.
    seen: VecDeque<(Candidate, T)>,
}

impl<T> Undrawn<T> {
    /// The next window of a scenario that was not drawn before, else the next one.
    fn draw(&mut self, scenarios: &HashSet<String>) -> Option<(Candidate, T)> {
        while let Some(one) = self.unseen.pop_front() {
            if !scenarios.contains(&one.0.path) {
                return Some(one);
            }
            self.seen.push_back(one);
        }
        self.seen.pop_front()
    }
}

impl<T> Iterator for DrawingOrder<T> {
    type Item = SampledWindow<T>;

    fn next(&mut self) -> Option<Self::Item> {
        for _ in 0..self.order.len() {
            let cell = &mut self.cells[self.order[self.next]];
            self.next = (self.next + 1) % self.order.len();
            if let Some((candidate, row)) = cell.draw(&self.scenarios) {
                self.scenarios.insert(candidate.path.clone());
                return Some(SampledWindow {
                    candidate,
                    row,
                    windows: cell.windows,
                    drawn: 0,
                });
            }
        }
        None
    }
}

/// Drawn windows by their cells, with how many of each are among them.
#[must_use]
pub fn in_cells<T>(mut drawn: Vec<SampledWindow<T>>) -> Vec<SampledWindow<T>> {
    drawn.sort_by(|a, b| a.candidate.cell.cmp(&b.candidate.cell));
    let mut counts: HashMap<Vec<String>, usize> = HashMap::new();
    for one in &drawn {
        *counts.entry(one.candidate.cell.clone()).or_default() += 1;
    }
    for one in &mut drawn {
        one.drawn = counts[&one.candidate.cell];
    }
    drawn
}

impl<T> Retained<T> {
    fn new() -> Self {
        Self {
            windows: 0,
            best: BTreeMap::new(),
            of_scenario: HashMap::new(),
        }
    }
}

fn number(seed: u64, window: &str) -> Number {
    ContentHash::of_parts([&seed.to_le_bytes()[..], window.as_bytes()]).bytes()
}

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

/// What a window is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RowCell {
    /// What the obstacle does.
    pub manoeuvre: Manoeuvre,
    /// The road under the ego.
    pub road: RoadType,
    /// The severity of its most severe step, 0 (contact) to 5 (none).
    pub severity: u8,
    /// The obstacle's type.
    pub actor: ObstacleType,
}

impl RowCell {
    /// Reads it from the text columns `manoeuvre`, `road` and `obstacle_type`, the first of which is at `column`, and the
    /// integer column `severity`, which is the first.
    ///
    /// # Errors
    /// A word or number that no index has.
    pub fn read(row: &PartRow<'_>, column: usize) -> Result<Self, IndexError> {
        let word = row.text(column)?;
        let manoeuvre = Manoeuvre::parse(word).ok_or_else(|| {
            let known = Manoeuvre::ALL.map(Manoeuvre::name);
            row.foreign(unknown("manoeuvre", word, known))
        })?;
        let word = row.text(column + 1)?;
        let road = RoadType::parse(word)
            .ok_or_else(|| row.foreign(unknown("road", word, RoadType::ALL.map(RoadType::name))))?;
        let word = row.text(column + 2)?;
        let actor = ObstacleType::parse(word).ok_or_else(|| {
            let known = ObstacleType::ALL.map(ObstacleType::name);
            row.foreign(unknown("obstacle_type", word, known))
        })?;
        let severity = row.severity(0)?;
        Ok(Self {
            manoeuvre,
            road,
            severity,
            actor,
        })
    }
}
