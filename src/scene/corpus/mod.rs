//! What a corpus of recordings holds: windows of pairs of road users, their manoeuvre, road and severity.
//!
//! [`for_each_window`] measures the windows of one scenario, [`Coverage`] counts them, and [`Sampler`] draws windows so
//! that they cover what is there. [`for_each_window`] finds what is worth looking at in a long recording. [`Part`] reads a part of
//! an index, and [`CorpusIndex`] all of them. [`events()`] has what happens to one ego, once each, with its parameters.

mod events;
mod lanes;
mod manoeuvre;
mod parts;
mod sampler;
mod windows;

pub use events::{Driven, Egos, Event, EventKind, Exposure, Parameter, ScenarioDriven};
pub use manoeuvre::{Manoeuvre, RoadType};
pub use parts::{Columns, IndexError, Part, PartRow, part_files};
pub use sampler::{
    Axis, Candidate, Cell, Coverage, DrawingOrder, RowCell, SEVERITIES, SampledWindow, Sampler,
    in_cells,
};
pub use windows::{
    IndexOptions, IndexedWindow, WindowEgo, WorstMoment, dangerous_follower, events,
    for_each_window, window_of_moment, worst_moments,
};

use std::collections::{HashMap, HashSet};
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::sync::Arc;

use super::scenario::ObstacleType;

const TEXTS: [&str; 7] = [
    "scenario",
    "file",
    "sha256",
    "ego_source",
    "manoeuvre",
    "road",
    "obstacle_type",
];

/// The columns of an index with whole numbers about a window: its severity, the ids and the steps.
pub const WINDOW_INTEGERS: [&str; 6] = [
    "severity",
    "ego_id",
    "obstacle_id",
    "first_step",
    "last_step",
    "worst_step",
];

/// The windows of a scenario that have the same manoeuvre, road, severity and type of obstacle.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CellWindows {
    /// What the obstacle does.
    pub manoeuvre: Manoeuvre,
    /// The road under the ego.
    pub road: RoadType,
    /// The severity of their most severe steps, 0 (contact) to 5 (none).
    pub severity: u8,
    /// The obstacle's type.
    pub actor: ObstacleType,
    /// How many windows.
    pub windows: u64,
    /// How many of them were asked about.
    pub asked: u64,
    /// The first of them.
    pub example: WindowPlace,
}

/// Where a window is in its scenario.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct WindowPlace {
    /// The ego.
    pub ego: WindowEgo,
    /// The ego's id.
    pub ego_id: i64,
    /// The obstacle.
    pub obstacle: i64,
    /// First and last step.
    pub steps: (i64, i64),
    /// Its most severe step.
    pub worst_step: i64,
}

/// A scenario of an index.
#[derive(Debug, Clone)]
pub struct IndexedScenario {
    /// The file's name without its ending.
    pub name: String,
    /// Path as it was found.
    pub file: String,
    /// SHA-256 of the file.
    pub hash: String,
    /// Its windows by cell and type of obstacle, in the order of manoeuvre, road and severity.
    pub windows: Arc<[CellWindows]>,
}

/// Windows of a cell by severity.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct CellCounts {
    /// All of them.
    pub windows: [u64; SEVERITIES],
    /// Those that were asked about.
    pub asked: [u64; SEVERITIES],
}

const MANOEUVRES: usize = Manoeuvre::ALL.len();

const ROADS: usize = RoadType::ALL.len();

/// An index that was read.
#[derive(Debug, Clone)]
pub struct CorpusIndex {
    /// Its folder.
    pub folder: PathBuf,
    /// Windows by manoeuvre and road.
    cells: [[CellCounts; ROADS]; MANOEUVRES],
    /// Its scenarios, in the order in which they were found.
    scenarios: Vec<IndexedScenario>,
    by_hash: HashMap<String, usize>,
    names: HashSet<String>,
}

/// A window in a part, as it is looked up among the answers.
#[derive(Debug, Clone, Copy)]
pub struct WindowKey<'a> {
    /// SHA-256 of the scenario's file.
    pub hash: &'a str,
    /// The scenario's name.
    pub name: &'a str,
    /// Where it is.
    pub place: WindowPlace,
}

/// How a scenario is related to an index.
#[derive(Debug, Clone, Copy)]
pub enum InIndex<'a> {
    /// Its contents are in the index.
    Same(&'a IndexedScenario),
    /// The index has other contents of this name.
    Changed,
    /// The index has neither.
    Missing,
}

/// Rows between two looks at whether to go on.
const ROWS_A_LOOK: u64 = 8192;

impl CorpusIndex {
    /// Reads an index from its parts; `asked` says which windows were asked about, `progress` is told rows and rows in
    /// all and may break off, which gives nothing.
    ///
    /// # Errors
    /// See [`IndexError`].
    pub fn read(
        folder: PathBuf,
        parts: &[PathBuf],
        asked: &dyn Fn(WindowKey<'_>) -> bool,
        progress: &mut dyn FnMut(u64, u64) -> ControlFlow<()>,
    ) -> Result<Option<Self>, IndexError> {
        let mut all = 0;
        // Every part can be read before the first is.
        for part in parts {
            all += Part::open(part)?.rows();
        }
        let mut reading = Reading::default();
        let mut rows = 0;
        for part in parts {
            let columns = Columns::new(&TEXTS, &WINDOW_INTEGERS);
            let done = Part::open(part)?.read(&columns, &mut |row| {
                reading.take(row, asked)?;
                rows += 1;
                Ok(match rows % ROWS_A_LOOK {
                    0 => progress(rows, all),
                    _ => ControlFlow::Continue(()),
                })
            })?;
            if done.is_break() {
                return Ok(None);
            }
        }
        if progress(all, all).is_break() {
            return Ok(None);
        }
        Ok(Some(reading.end(folder)))
    }

    /// An index of windows that were measured: each with the name and hash of its scenario, and whether it was asked
    /// about.
    #[must_use]
    pub fn of_windows(folder: PathBuf, windows: &[(&str, &str, IndexedWindow, bool)]) -> Self {
        let mut reading = Reading::default();
        for (name, hash, window, asked) in windows {
            let ego_id = match window.ego {
                WindowEgo::Recorded => 0,
                WindowEgo::Obstacle(id) => id,
            };
            let place = WindowPlace {
                ego: window.ego,
                ego_id,
                obstacle: window.obstacle,
                steps: window.steps,
                worst_step: window.worst_step,
            };
            let cell = RowCell {
                manoeuvre: window.manoeuvre,
                road: window.road,
                severity: window.severity,
                actor: ObstacleType::parse(window.kind).unwrap_or(ObstacleType::Unknown),
            };
            let scenario = reading.place_of(hash, name, name);
            reading.add(scenario, cell, place, *asked);
        }
        reading.end(folder)
    }

    /// The table of windows by manoeuvre, road and severity.
    #[must_use]
    pub fn coverage(&self) -> Coverage {
        let mut coverage = Coverage::default();
        for (manoeuvre, roads) in Manoeuvre::ALL.into_iter().zip(&self.cells) {
            for (road, counts) in RoadType::ALL.into_iter().zip(roads) {
                for (severity, windows) in counts.windows.into_iter().enumerate() {
                    let cell = Cell {
                        manoeuvre: manoeuvre.name().into(),
                        road: road.name().into(),
                    };
                    coverage.add_many(cell, severity, windows);
                }
            }
        }
        coverage
    }

    /// Windows of the cells of a manoeuvre and a road, of all where one is not named.
    #[must_use]
    pub fn counts(&self, manoeuvre: Option<Manoeuvre>, road: Option<RoadType>) -> CellCounts {
        let mut sum = CellCounts::default();
        for (m, roads) in Manoeuvre::ALL.into_iter().zip(&self.cells) {
            for (r, counts) in RoadType::ALL.into_iter().zip(roads) {
                if manoeuvre.is_some_and(|wanted| wanted != m)
                    || road.is_some_and(|wanted| wanted != r)
                {
                    continue;
                }
                for severity in 0..SEVERITIES {
                    sum.windows[severity] += counts.windows[severity];
                    sum.asked[severity] += counts.asked[severity];
                }
            }
        }
        sum
    }

    /// Its scenarios.
    #[must_use]
    pub fn scenarios(&self) -> &[IndexedScenario] {
        &self.scenarios
    }

    /// A scenario by the hash of its file, or by name where that is of other contents.
    #[must_use]
    pub fn find(&self, hash: &str, name: &str) -> InIndex<'_> {
        match self.by_hash.get(hash) {
            Some(place) => InIndex::Same(&self.scenarios[*place]),
            None if self.names.contains(name) => InIndex::Changed,
            None => InIndex::Missing,
        }
    }
}

/// An index while it is read.
#[derive(Default)]
struct Reading {
    cells: [[CellCounts; ROADS]; MANOEUVRES],
    /// Each with the cells that it has so far.
    scenarios: Vec<(IndexedScenario, Vec<CellWindows>)>,
    by_hash: HashMap<String, usize>,
    /// The scenario of the row before: those of one stand together.
    last: usize,
}

impl Reading {
    fn take(
        &mut self,
        row: &PartRow<'_>,
        asked: &dyn Fn(WindowKey<'_>) -> bool,
    ) -> Result<(), IndexError> {
        let (name, hash) = (row.text(0)?, row.text(2)?);
        let (ego_id, recorded) = (row.integer(1), row.text(3)? == "recorded");
        let place = WindowPlace {
            ego: if recorded {
                WindowEgo::Recorded
            } else {
                WindowEgo::Obstacle(ego_id)
            },
            ego_id,
            obstacle: row.integer(2),
            steps: (row.integer(3), row.integer(4)),
            worst_step: row.integer(5),
        };
        let cell = RowCell::read(row, 4)?;
        let key = WindowKey { hash, name, place };
        let scenario = self.place_of(hash, name, row.text(1)?);
        self.add(scenario, cell, place, asked(key));
        Ok(())
    }

    /// Counts a window of a scenario.
    fn add(&mut self, scenario: usize, cell: RowCell, example: WindowPlace, asked: bool) {
        let RowCell {
            manoeuvre,
            road,
            severity,
            actor,
        } = cell;
        let asked = u64::from(asked);
        // Both are in the order of their lists.
        let counts = &mut self.cells[manoeuvre as usize][road as usize];
        counts.windows[usize::from(severity)] += 1;
        counts.asked[usize::from(severity)] += asked;
        let cells = &mut self.scenarios[scenario].1;
        let same = |c: &&mut CellWindows| {
            (c.manoeuvre, c.road, c.severity, c.actor) == (manoeuvre, road, severity, actor)
        };
        match cells.iter_mut().find(same) {
            Some(cell) => {
                cell.windows += 1;
                cell.asked += asked;
            }
            None => cells.push(CellWindows {
                manoeuvre,
                road,
                severity,
                actor,
                windows: 1,
                asked,
                example,
            }),
        }
    }

    /// The place of a scenario, which may be new.
    fn place_of(&mut self, hash: &str, name: &str, file: &str) -> usize {
        let last = self.scenarios.get(self.last);
        if last.is_some_and(|(scenario, _)| scenario.hash == hash) {
            return self.last;
        }
        self.last = match self.by_hash.get(hash) {
            Some(place) => *place,
            None => {
                self.by_hash.insert(hash.into(), self.scenarios.len());
                let scenario = IndexedScenario {
                    name: name.into(),
                    file: file.into(),
                    hash: hash.into(),
                    windows: Arc::new([]),
                };
                self.scenarios.push((scenario, Vec::new()));
                self.scenarios.len() - 1
            }
        };
        self.last
    }

    fn end(self, folder: PathBuf) -> CorpusIndex {
        let scenarios = self.scenarios.into_iter().map(|(scenario, mut cells)| {
            cells.sort_by_key(|cell| (cell.manoeuvre, cell.road, cell.severity, cell.actor));
            IndexedScenario {
                windows: cells.into(),
                ..scenario
            }
        });
        let scenarios: Vec<IndexedScenario> = scenarios.collect();
        CorpusIndex {
            folder,
            cells: self.cells,
            names: scenarios.iter().map(|s| s.name.clone()).collect(),
            scenarios,
            by_hash: self.by_hash,
        }
    }
}
