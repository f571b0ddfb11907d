//! Finds scenarios; of long recordings the most severe windows, of an index those that a filter matches.

use std::cell::OnceCell;
use std::collections::{BTreeSet, HashMap};
use std::fs::File;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use nearmiss_drive::planner::Cancel;
use nearmiss_formats as formats;
use nearmiss_formats::{
    EgoSelection, Entry, LibraryError, LongRecording, PassedOver, RankedMoment, SearchResults,
};
use nearmiss_scene::corpus::{
    CellWindows, Columns, CorpusIndex, IndexError, Part, RowCell, WINDOW_INTEGERS, WindowEgo,
    WindowKey, WindowPlace, part_files, worst_moments,
};
use nearmiss_scene::metrics::{Measure, Thresholds, measures};
use nearmiss_scene::scenario::obstacle_taken;
use nearmiss_store::{Origin, StoredVerdict};

use super::journal::FOLDER;
use super::scenario_filter::{
    Agreement, Facts, Filter, Filterable, Indexed, Matching, Number, Property, Verdicts, WordMatch,
    country_code,
};

/// Pairs farther apart are not measured, metres: as far as `nearmiss corpus index` looks where nothing else is said.
pub const INDEX_RADIUS: f64 = 50.0;

/// The scenarios at `paths`, as [`formats::find`] finds them; of long recordings the windows around the most severe
/// moments, those first.
///
/// # Errors
/// As [`formats::find`].
pub fn find(paths: &[PathBuf]) -> Result<SearchResults, LibraryError> {
    formats::find_ranked(paths, &worst_windows)
}

/// The same in pieces, as [`formats::find_in_pieces`].
///
/// # Errors
/// As [`formats::find`].
pub fn find_in_pieces(
    paths: &[PathBuf],
    give: &mut dyn FnMut(Vec<Entry>),
) -> Result<Vec<PassedOver>, LibraryError> {
    formats::find_in_pieces(paths, &worst_windows, give)
}

/// The windows of a long recording that are listed. They are the same for all users: their own thresholds grade windows
/// that are open, and do not change what can be named.
fn worst_windows(recording: &LongRecording) -> Vec<RankedMoment> {
    let moments = worst_moments(
        &recording.scenario,
        &recording.egos(),
        INDEX_RADIUS,
        Thresholds::shipped(),
    );
    let ranked = moments.iter().map(|m| RankedMoment {
        track: m.ego,
        step: m.moment.step,
        rank: m.moment.rank(),
    });
    let windows: Vec<RankedMoment> = ranked.collect();
    if windows.is_empty() {
        recording.beginnings()
    } else {
        windows
    }
}

/// What is searched, and with what.
#[derive(Debug)]
pub struct IndexSearch<'a> {
    /// Folder of the index.
    pub folder: &'a Path,
    /// The filter, as it was written.
    pub filter: &'a str,
    /// Windows that are kept, the most severe ones; all are counted.
    pub most: usize,
    /// Stored answers, for terms about them.
    pub answers: Vec<StoredVerdict>,
    /// Thresholds of the built-in judge, for the same terms.
    pub thresholds: &'a Thresholds,
}

/// A window that the filter lets through.
#[derive(Debug, Clone)]
pub struct FoundWindow {
    /// Name of its scenario.
    pub scenario: String,
    /// Its file, as it was indexed.
    pub file: String,
    /// Manoeuvre, road, severity, obstacle's type, and where it is.
    pub window: CellWindows,
    /// Its measures, in the order of [`FoundWindows::measures`].
    pub values: Vec<Option<f64>>,
}

/// The windows that were found.
#[derive(Debug, Default)]
pub struct FoundWindows {
    /// The measures of the filter.
    pub measures: Vec<&'static Measure>,
    /// Of these, those that no window of the manoeuvres, roads and road users in the filter has.
    pub nowhere: Vec<&'static Measure>,
    /// Windows in the index.
    pub of: u64,
    /// How many were found.
    pub count: u64,
    /// Scenarios that they are in.
    pub scenarios: usize,
    /// The most severe of them, in the order of severity and of the index.
    pub windows: Vec<FoundWindow>,
    /// Scenarios whose files a term asks for and that cannot be read: no term about them holds.
    pub unreadable: usize,
}

/// Why nothing was searched.
#[derive(Debug, thiserror::Error)]
pub enum SearchError {
    /// The filter is wrong.
    #[error("filter: {0}")]
    Filter(String),
    /// The index cannot be read.
    #[error(transparent)]
    Index(#[from] IndexError),
}

/// The filter of a search, checked: terms, and at most one word of a scenario's name.
///
/// # Errors
/// A term is wrong, has no value yet, or nothing is left of it, or it is a sentence: in words.
pub fn checked_filter(text: &str) -> Result<Filter, String> {
    let filter = Filter::read_of_all(text);
    if let Some(why) = filter.wrong.first() {
        return Err(why.clone());
    }
    if filter.incomplete {
        Err(format!("`{text}`: a term has no value"))
    } else if !filter.filters() {
        Err(format!("expected terms, such as {EXAMPLE}"))
    } else if filter.is_sentence() {
        Err(format!(
            "`{text}` reads as a sentence; expected terms, such as {EXAMPLE}"
        ))
    } else {
        Ok(filter)
    }
}

/// Terms that show how they are written.
const EXAMPLE: &str = "manoeuvre:cut_in ttc<1.5 road:highway";

/// The measures that an index has.
///
/// # Errors
/// It cannot be read.
pub fn index_measures(folder: &Path) -> Result<Vec<&'static Measure>, IndexError> {
    let parts = index_parts(folder)?;
    let there = match parts.first() {
        Some(path) => Part::open(path)?.measures(),
        None => Vec::new(),
    };
    let is_there = |measure: &&Measure| there.iter().any(|id| id == measure.id);
    Ok(measures().filter(is_there).collect())
}

const TEXTS: [&str; 6] = [
    "scenario",
    "file",
    "ego_source",
    "manoeuvre",
    "road",
    "obstacle_type",
];

/// Rows between two reports of progress.
const ROWS_A_REPORT: u64 = 8192;

/// Searches an index; `on_rows` is told how many windows were read. Nothing if it was cancelled.
///
/// # Errors
/// The filter is wrong, or compares a measure that the index does not have; or the index cannot be read.
pub fn search_index(
    search: IndexSearch<'_>,
    cancel: &Cancel,
    on_rows: &mut dyn FnMut(u64),
) -> Result<Option<FoundWindows>, SearchError> {
    let filter = checked_filter(search.filter).map_err(SearchError::Filter)?;
    let parts = index_parts(search.folder)?;
    let mut measures: Vec<&'static Measure> = Vec::new();
    for measure in filter.measures() {
        if !measures.iter().any(|known| known.id == measure.id) {
            measures.push(measure);
        }
    }
    let names: Vec<&str> = measures.iter().map(|m| m.id).collect();
    let mut searching = Searching {
        scenarios: Scenarios {
            verdicts: Verdicts::from(search.answers),
            thresholds: search.thresholds,
            known: HashMap::new(),
        },
        filter,
        most: search.most,
        found: FoundWindows {
            measures: measures.clone(),
            nowhere: measures.clone(),
            ..FoundWindows::default()
        },
        in_scenarios: BTreeSet::new(),
        matching: Matching::default(),
    };
    for path in parts {
        let part = Part::open(&path)?;
        has_measures(&part, &measures)?;
        let columns = Columns {
            texts: &TEXTS,
            integers: &WINDOW_INTEGERS,
            numbers: &names,
        };
        let done = part.read(&columns, &mut |row| {
            let recorded = row.text(2)? == "recorded";
            let ego_id = row.integer(1);
            let cell = RowCell::read(row, 3)?;
            let window = CellWindows {
                manoeuvre: cell.manoeuvre,
                road: cell.road,
                severity: cell.severity,
                actor: cell.actor,
                windows: 1,
                asked: 0,
                example: WindowPlace {
                    ego: if recorded {
                        WindowEgo::Recorded
                    } else {
                        WindowEgo::Obstacle(ego_id)
                    },
                    ego_id,
                    obstacle: row.integer(2),
                    steps: (row.integer(3), row.integer(4)),
                    worst_step: row.integer(5),
                },
            };
            let values = (0..names.len()).map(|at| row.number(at)).collect();
            searching.take(row.text(0)?, row.text(1)?, window, values);
            let rows = searching.found.of;
            if rows.is_multiple_of(ROWS_A_REPORT) {
                on_rows(rows);
            }
            // A row may have a scenario read.
            Ok(if cancel.is_asked() {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            })
        })?;
        if done.is_break() {
            return Ok(None);
        }
    }
    Ok(Some(searching.end()))
}

/// Whether a part has these measures.
fn has_measures(part: &Part, wanted: &[&'static Measure]) -> Result<(), SearchError> {
    let there = part.measures();
    match wanted.iter().find(|m| !there.iter().any(|t| t == m.id)) {
        None => Ok(()),
        Some(missing) => Err(SearchError::Filter(format!(
            "this index has no measure {}; it has {}; `nearmiss corpus index PATH… -o FOLDER --measure {},…` measures it",
            missing.id,
            there.join(", "),
            missing.id
        ))),
    }
}

/// A search on its way.
struct Searching<'a> {
    filter: Filter,
    scenarios: Scenarios<'a>,
    most: usize,
    found: FoundWindows,
    in_scenarios: BTreeSet<String>,
    matching: Matching,
}

impl Searching<'_> {
    fn take(&mut self, name: &str, file: &str, window: CellWindows, values: Vec<Option<f64>>) {
        self.found.of += 1;
        let measures = &self.found.measures;
        let value = |measure: &Measure| {
            let at = measures.iter().position(|m| m.id == measure.id);
            at.and_then(|at| values[at])
        };
        if !self.found.nowhere.is_empty() && self.filter.is_of_kind(&window) {
            self.found
                .nowhere
                .retain(|measure| value(measure).is_none());
        }
        if !self.filter.holds_of_window(&window, value) {
            return;
        }
        if self.filter.asks_of_scenarios() {
            self.scenarios.learn(file);
            let Some(scenario) = self.scenarios.known.get(file) else {
                return;
            };
            let row = Row {
                scenario,
                indexed: Indexed::Windows(Arc::new([window.clone()])),
                value: &value,
                verdicts: &self.scenarios.verdicts,
                thresholds: self.scenarios.thresholds,
            };
            let score = self.filter.score(&row, WordMatch::Part, &mut self.matching);
            if score.is_none() {
                return;
            }
        }
        self.found.count += 1;
        if !self.in_scenarios.contains(file) {
            self.in_scenarios.insert(file.to_string());
        }
        self.found.windows.push(FoundWindow {
            scenario: name.to_string(),
            file: file.to_string(),
            window,
            values,
        });
        if self.found.windows.len() > 2 * self.most.max(512) {
            self.keep_worst();
        }
    }

    fn keep_worst(&mut self) {
        self.found.windows.sort_by_key(|one| one.window.severity);
        self.found.windows.truncate(self.most);
    }

    fn end(mut self) -> FoundWindows {
        self.keep_worst();
        self.found.scenarios = self.in_scenarios.len();
        let known = self.scenarios.known.values();
        let failed = known.filter(|one| matches!(one.facts.get(), Some(Err(_))));
        self.found.unreadable = failed.count();
        self.found
    }
}

/// The scenarios of an index, read where a term asks about them.
struct Scenarios<'a> {
    verdicts: Verdicts,
    thresholds: &'a Thresholds,
    known: HashMap<String, IndexedFile>,
}

struct IndexedFile {
    entry: Entry,
    facts: OnceCell<Result<Facts, String>>,
}

impl Scenarios<'_> {
    fn learn(&mut self, file: &str) {
        if self.known.contains_key(file) {
            return;
        }
        // A bundled scenario is meant by its name.
        let path = PathBuf::from(file.trim_end_matches(" (bundled)"));
        let known = IndexedFile {
            entry: Entry::of_argument(&path),
            facts: OnceCell::new(),
        };
        self.known.insert(file.to_string(), known);
    }
}

/// A window and its scenario as a filter sees them.
struct Row<'a> {
    scenario: &'a IndexedFile,
    indexed: Indexed,
    value: &'a dyn Fn(&Measure) -> Option<f64>,
    verdicts: &'a Verdicts,
    thresholds: &'a Thresholds,
}

impl Row<'_> {
    fn facts(&self) -> Option<&Facts> {
        let facts = self.scenario.facts.get_or_init(|| {
            let (entry, ego) = (&self.scenario.entry, EgoSelection::Beside);
            Facts::read(entry, &ego, self.thresholds, self.verdicts)
        });
        facts.as_ref().ok()
    }
}

impl Filterable for Row<'_> {
    fn entry(&self) -> &Entry {
        &self.scenario.entry
    }

    fn tags(&self) -> impl Iterator<Item = &str> {
        let tags = self.facts().into_iter().flat_map(|facts| &facts.tags);
        tags.map(String::as_str)
    }

    fn country(&self) -> &str {
        // The name says it without the file being read.
        country_code(&self.scenario.entry.name)
    }

    fn has(&self, property: Property) -> Option<bool> {
        match property {
            Property::Error => Some(self.facts().is_none()),
            Property::Index => Some(true),
            property => self.facts()?.has(property),
        }
    }

    fn agreement(&self) -> Option<Agreement> {
        Some(self.facts()?.agreement())
    }

    fn number(&self, number: Number) -> Option<f64> {
        match number {
            Number::Of(measure) => (self.value)(measure),
            number => self.facts()?.number(number),
        }
    }

    fn indexed(&self) -> &Indexed {
        &self.indexed
    }
}

/// The parts of an index, in order.
///
/// # Errors
/// There is no index in the folder, or `nearmiss corpus index` is still writing it.
pub fn index_parts(folder: &Path) -> Result<Vec<PathBuf>, IndexError> {
    let parts = part_files(folder);
    // Before its first part is there, an index is one all the same.
    if is_being_written(folder) {
        Err(IndexError::BeingWritten(folder.to_path_buf()))
    } else {
        parts
    }
}

/// Whether a run of `nearmiss corpus index` has its journal open.
fn is_being_written(folder: &Path) -> bool {
    let entries = std::fs::read_dir(folder.join(FOLDER)).into_iter().flatten();
    let paths = entries.flatten().map(|entry| entry.path());
    let mut journals = paths.filter(|path| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        name.starts_with("index") && name.ends_with(".jsonl")
    });
    journals.any(|path| {
        let locked = File::open(path).map(|file| file.try_lock_shared());
        matches!(locked, Ok(Err(std::fs::TryLockError::WouldBlock)))
    })
}

/// Reads an index; `on_rows` is told rows that were read and rows in all. Nothing if it was cancelled.
///
/// # Errors
/// See [`IndexError`].
pub fn read_index(
    folder: &Path,
    answers: &[StoredVerdict],
    cancel: &Cancel,
    on_rows: &mut dyn FnMut(u64, u64),
) -> Result<Option<CorpusIndex>, IndexError> {
    let parts = index_parts(folder)?;
    let asked = AskedWindows::new(answers);
    let mut progress = |rows, all| {
        on_rows(rows, all);
        if cancel.is_asked() {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    };
    CorpusIndex::read(
        folder.to_path_buf(),
        &parts,
        &|window| asked.has(window),
        &mut progress,
    )
}

/// The windows that models were asked about.
struct AskedWindows<'a> {
    by_hash: HashMap<&'a str, Vec<&'a StoredVerdict>>,
    by_name: HashMap<&'a str, Vec<&'a StoredVerdict>>,
}

impl<'a> AskedWindows<'a> {
    /// Answers that were recorded or played back do not count: they were not asked for here.
    fn new(answers: &'a [StoredVerdict]) -> Self {
        let mut asked = Self {
            by_hash: HashMap::new(),
            by_name: HashMap::new(),
        };
        for one in answers.iter().filter(|one| one.origin == Origin::Asked) {
            let of = match &one.scenario_hash {
                Some(hash) => asked.by_hash.entry(hash.as_str()),
                None => asked.by_name.entry(one.scenario.as_str()),
            };
            of.or_default().push(one);
        }
        asked
    }

    /// Whether there is an answer about the same ego at a time of the window.
    fn has(&self, window: WindowKey<'_>) -> bool {
        let (by_hash, by_name) = (self.by_hash.get(window.hash), self.by_name.get(window.name));
        let mut answers = by_hash.into_iter().chain(by_name).flatten();
        answers.any(|answer| {
            let same_ego = match window.place.ego {
                WindowEgo::Obstacle(id) => obstacle_taken(&answer.ego) == Some(id),
                WindowEgo::Recorded => {
                    let id = format!("{}, ", window.place.ego_id);
                    let motion = answer.ego.strip_prefix(&id);
                    motion.is_some_and(|motion| {
                        ["recorded in", "driven by", "solution"]
                            .iter()
                            .any(|source| motion.starts_with(source))
                    })
                }
            };
            let (first, last) = window.place.steps;
            let overlaps = |(from, to): (i64, i64)| from <= last && first <= to;
            same_ego && answer.window.is_none_or(overlaps)
        })
    }
}
