//! Files: opening one, finding many, and tables over many.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, Once, PoisonError};

use nearmiss_drive::driver::{DRIVERS, DriverRecord};
use nearmiss_drive::planner::Cancel;
use nearmiss_formats::{
    EgoSelection, Entry, TableOptions, bundled, check_table, reading_tables_with, resolved,
};
use nearmiss_record::{Clock, Row, columns, row_of};
use nearmiss_workflow::tables::{encounter_table, index_table, left_out, meanings};
use nearmiss_workflow::{
    OpenRequest, OpenedScene, Overview, ScenarioRow, SimulatedEgo, StandIn, find,
    open as open_entry, read_as_said,
};
use pyo3::exceptions::PyUserWarning;
use pyo3::prelude::*;
use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use tempfile::TempDir;

use crate::arguments::{Ego, Names, Paths};
use crate::errors::{Problem, in_python};
use crate::scenario::{Scenario, index_options, measures_of};
use crate::settings::{User, named_measures};
use crate::table::Table;
use crate::window::json;
use crate::work;

/// What holds for all files of a call.
struct Reader {
    user: User,
    ego: Option<Ego>,
    tables: Option<TableOptions>,
}

impl Reader {
    fn new(
        ego: Option<Ego>,
        columns: Option<&str>,
        rate: Option<f64>,
        map: Option<PathBuf>,
    ) -> Result<Self, Problem> {
        static SAID: Once = Once::new();
        let user = User::read()?;
        let usual = user.tables(None, None, None)?;
        SAID.call_once(|| read_as_said(usual, &user.config, user.folders.as_ref()));
        let is_said = columns.is_some() || rate.is_some() || map.is_some();
        let tables = is_said
            .then(|| user.tables(columns, rate, map))
            .transpose()?;
        Ok(Self { user, ego, tables })
    }

    /// The scenario of an entry with its ego.
    fn open(&self, entry: &Entry) -> Result<Scenario, Problem> {
        self.reading(|| self.opened(entry))
    }

    /// Reads tables as they are said to be.
    fn reading<T>(&self, read: impl FnOnce() -> T) -> T {
        match &self.tables {
            None => read(),
            Some(tables) => reading_tables_with(tables.clone(), read),
        }
    }

    fn opened(&self, entry: &Entry) -> Result<Scenario, Problem> {
        let driving = self.user.driving();
        let asked = match &self.ego {
            None => SimulatedEgo::Follows(EgoSelection::Beside),
            Some(Ego::Id(id)) => SimulatedEgo::Follows(EgoSelection::Obstacle(*id)),
            Some(Ego::Named(said)) if said.as_os_str() == "planner" => SimulatedEgo::Planned,
            Some(Ego::Named(said)) => SimulatedEgo::Follows(EgoSelection::of_file(said)),
        };
        let stand_in = StandIn::Planner(&driving);
        let opened = match &asked {
            SimulatedEgo::Follows(ego) => open_entry(&OpenRequest {
                entry,
                ego,
                transform: None,
                strict: true,
                stand_in,
            })?,
            _ => {
                let scenario = entry.read()?;
                OpenedScene {
                    scene: stand_in.scene(entry, &scenario),
                    scenario,
                    stands_in: false,
                }
            }
        };
        Ok(Scenario {
            entry: entry.clone(),
            scenario: opened.scenario,
            opened: opened.scene,
            asked,
            stands_in: opened.stands_in,
            thresholds: Arc::new(self.user.thresholds.clone()),
            folder: None,
        })
    }
}

/// The entry that a path means, if it is one scenario.
fn entry(path: &Path) -> Result<Entry, Problem> {
    let file = nearmiss_formats::only_part(&resolved(path)?);
    if file.is_dir() {
        return Err(Problem::new(format!(
            "{}: is a folder; nearmiss.scenarios(folder) lists what is in it",
            file.display()
        )));
    }
    Ok(Entry::of_argument(&file))
}

/// Opens a scenario or recording of any format, with its ego.
///
/// path: a file, `FILE#PART` for one of several scenarios in it (see `nearmiss.scenarios`), or the name of a bundled scenario.
/// ego: id of an obstacle, a file with a trajectory, or "planner"; None for the recorded one, else the built-in planner, else
/// the follower of the most dangerous pair. map, columns, rate: of tables of tracks, as `nearmiss help tracks` tells.
#[pyfunction]
#[pyo3(signature = (path, *, ego=None, map=None, columns=None, rate=None))]
pub fn open(
    py: Python<'_>,
    path: PathBuf,
    ego: Option<Ego>,
    map: Option<PathBuf>,
    columns: Option<&str>,
    rate: Option<f64>,
) -> PyResult<Scenario> {
    let reader = Reader::new(ego, columns, rate, map)?;
    Ok(work::run(py, move |_| reader.open(&entry(&path)?))??)
}

/// The scenarios in files and folders, as `nearmiss.open` takes them; those that are bundled where no path is named.
///
/// Of a long recording these are its worst windows, the worst first. Files that are named like scenarios and are none are a
/// warning.
#[pyfunction]
#[pyo3(signature = (*paths))]
pub fn scenarios(py: Python<'_>, paths: Vec<Paths>) -> PyResult<Vec<String>> {
    let paths = Vec::from_iter(paths.into_iter().flat_map(Paths::all));
    let entries = if paths.is_empty() {
        bundled()
    } else {
        found(
            py,
            &Reader::new(None, None, None, None)?,
            Paths::Many(paths),
        )?
    };
    Ok(entries.iter().map(address).collect())
}

/// What opens an entry.
fn address(entry: &Entry) -> String {
    match &entry.place {
        nearmiss_formats::EntryLocation::File(path) => path.display().to_string(),
        nearmiss_formats::EntryLocation::Bundled(_) => entry.name.clone(),
    }
}

/// The entries at paths; what was passed over is a warning.
fn found(py: Python<'_>, _reader: &Reader, paths: Paths) -> PyResult<Vec<Entry>> {
    let paths = paths.all();
    let found = work::run(py, move |_| {
        let known = paths.iter().map(|path| resolved(path));
        find(&known.collect::<Result<Vec<_>, _>>()?).map_err(Problem::new)
    })??;
    if let Some(words) = found.passed_over_in_short() {
        warn(py, &words)?;
    }
    Ok(found.entries)
}

/// Warns; Python shows the same warning of a line once.
pub fn warn(py: Python<'_>, words: &str) -> PyResult<()> {
    let kind = py.get_type::<PyUserWarning>();
    let words = in_python(words).replace('\0', " ");
    let words = std::ffi::CString::new(words).map_err(Problem::new)?;
    PyErr::warn(py, &kind, &words, 1)
}

/// The threads of this process: those of the process that it was forked from are not there.
fn processors() -> Result<Arc<ThreadPool>, Problem> {
    static POOL: Mutex<Option<(u32, Arc<ThreadPool>)>> = Mutex::new(None);
    let own = std::process::id();
    let mut pool = POOL.lock().unwrap_or_else(PoisonError::into_inner);
    match &*pool {
        Some((process, pool)) if *process == own => Ok(Arc::clone(pool)),
        _ => {
            let made = ThreadPoolBuilder::new().build().map_err(Problem::new)?;
            let made = Arc::new(made);
            // Threads that are not there cannot be ended.
            std::mem::forget(pool.replace((own, Arc::clone(&made))));
            Ok(made)
        }
    }
}

/// A folder of a scenario in memory; a process that was forked leaves it to the one that made it.
pub struct OwnFolder {
    folder: Option<TempDir>,
    process: u32,
}

impl OwnFolder {
    fn new() -> Result<Self, Problem> {
        Ok(Self {
            folder: Some(tempfile::tempdir().map_err(Problem::new)?),
            process: std::process::id(),
        })
    }

    fn path(&self) -> &Path {
        self.folder.as_ref().map_or(Path::new(""), TempDir::path)
    }
}

impl Drop for OwnFolder {
    fn drop(&mut self) {
        if self.process != std::process::id() {
            let _ = self.folder.take().map(TempDir::keep);
        }
    }
}

/// What of each scenario is worked out at once, in their order; one that fails is a warning, and an error where all do.
fn of_each<T: Send + 'static>(
    py: Python<'_>,
    reader: Reader,
    entries: Vec<Entry>,
    work: impl Fn(&Scenario) -> Result<T, Problem> + Send + Sync + 'static,
) -> PyResult<Vec<T>> {
    let done = work::run(py, move |cancel: &Cancel| {
        let one = |entry: &Entry| {
            if cancel.is_asked() {
                return Err(Problem::new("interrupted"));
            }
            reader.open(entry).and_then(|scenario| work(&scenario))
        };
        let all = || entries.par_iter().map(one).collect::<Vec<_>>();
        processors().map(|pool| pool.install(all))
    })??;
    let (all, mut made, mut failed) = (done.len(), Vec::new(), Vec::new());
    for one in done {
        match one {
            Ok(one) => made.push(one),
            Err(problem) => failed.push(problem),
        }
    }
    if made.is_empty() && !failed.is_empty() {
        return Err(failed.remove(0).and_more(all - 1).into());
    }
    for problem in failed {
        warn(py, &problem.to_string())?;
    }
    Ok(made)
}

/// A row for each scenario at the paths, the most severe first, as `nearmiss inspect` has them: the moment that matters, what
/// makes it matter, the lowest time to collision and distance.
#[pyfunction]
pub fn inspect(py: Python<'_>, paths: Paths) -> PyResult<Table> {
    let reader = Reader::new(None, None, None, None)?;
    let entries = found(py, &reader, paths)?;
    let mut all = of_each(py, reader, entries, |scenario| Ok(scenario.overview()))?;
    all.sort_by(Overview::compare);
    let columns = columns::<ScenarioRow>();
    let rows = all.iter().map(|one| row_of(&columns, &one.row));
    let rows = rows
        .collect::<Result<Vec<Row>, _>>()
        .map_err(Problem::new)?;
    let mut table = nearmiss_record::Table::new("scenarios", columns);
    table.metadata = vec![("columns", meanings(&table).to_string())];
    Ok(Table::new(&table, rows)?)
}

/// Safety measures of all scenarios at the paths in one table, worked out on all processors: see `Scenario.measures`.
#[pyfunction]
#[pyo3(signature = (paths, names=None, *, radius=None, reasons=false))]
pub fn measures(
    py: Python<'_>,
    paths: Paths,
    names: Option<Names>,
    radius: Option<f64>,
    reasons: bool,
) -> PyResult<Table> {
    let reader = Reader::new(None, None, None, None)?;
    let measures = named_measures(names)?;
    let table = measures_of(&measures, &reader.user.thresholds, reasons);
    let entries = found(py, &reader, paths)?;
    let schema = table.arrow_schema(Clock::Durations);
    let parts = of_each(py, reader, entries, move |scenario| {
        scenario.measured(&table, radius, &measures)
    })?;
    Ok(Table::joined(parts, schema))
}

/// Windows of all pairs of road users in all scenarios at the paths in one table: see `Scenario.windows`.
#[pyfunction]
#[pyo3(signature = (paths, *, length=None, stride=None, radius=None, measures=None))]
pub fn windows(
    py: Python<'_>,
    paths: Paths,
    length: Option<f64>,
    stride: Option<f64>,
    radius: Option<f64>,
    measures: Option<Names>,
) -> PyResult<Table> {
    let reader = Reader::new(None, None, None, None)?;
    let options = index_options(length, stride, radius, measures)?;
    let entries = found(py, &reader, paths)?;
    let schema = index_table(&options, &reader.user.thresholds).arrow_schema(Clock::Durations);
    let parts = of_each(py, reader, entries, move |scenario| {
        scenario.index(&options)
    })?;
    Ok(Table::joined(parts, schema))
}

/// Encounters of all scenarios at the paths in one table, worked out on all processors: see `Scenario.encounters`.
#[pyfunction]
#[pyo3(name = "encounters")]
pub fn encounters_of(py: Python<'_>, paths: Paths) -> PyResult<Table> {
    let reader = Reader::new(None, None, None, None)?;
    let entries = found(py, &reader, paths)?;
    let schema = encounter_table().arrow_schema(Clock::Durations);
    let parts = of_each(py, reader, entries, Scenario::judged)?;
    if let Some(words) = left_out(parts.iter().map(|(_, early)| early).sum()) {
        warn(py, &words)?;
    }
    let parts = parts.into_iter().map(|(table, _)| table);
    Ok(Table::joined(parts.collect(), schema))
}

/// The models of drivers: a dict each, with id, name, formula, parameters, source and limits, as `nearmiss drivers --format
/// json` has them.
#[pyfunction]
pub fn drivers(py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
    let all: Vec<DriverRecord> = DRIVERS.iter().map(DriverRecord::from).collect();
    json(py, &all)
}

/// A scenario of tracks in memory: a row a road user and moment, with columns time, id, x and y at least.
///
/// table: what has the Arrow interface (pyarrow, polars, DuckDB) or a pandas DataFrame. name: of the scenario. columns, rate,
/// map: as of `nearmiss.open`, such as columns="time=t[ms],id=track". ego: id or name of a track.
#[pyfunction]
#[pyo3(signature = (table, *, name="tracks", ego=None, map=None, columns=None, rate=None))]
pub fn from_tracks(
    py: Python<'_>,
    table: &Bound<'_, PyAny>,
    name: &str,
    ego: Option<Ego>,
    map: Option<PathBuf>,
    columns: Option<&str>,
    rate: Option<f64>,
) -> PyResult<Scenario> {
    let table = Table::taken(table)?;
    let reader = Reader::new(ego, columns, rate, map)?;
    let name = name.to_string();
    Ok(work::run(py, move |_| reader.tracks(&table, &name))??)
}

/// The scenario of the bytes of a file, whose name tells the format; `nearmiss.from_commonroad` calls it.
#[pyfunction]
#[pyo3(signature = (data, name, *, ego=None))]
pub fn of_bytes(
    py: Python<'_>,
    data: Vec<u8>,
    name: String,
    ego: Option<Ego>,
) -> PyResult<Scenario> {
    let reader = Reader::new(ego, None, None, None)?;
    let opened = work::run(py, move |_| {
        reader.in_memory(&name, |file| {
            std::fs::write(file, data).map_err(Problem::new)
        })
    })?;
    Ok(opened?)
}

impl Reader {
    /// The scenario of tracks in memory, which its folder holds as a file.
    fn tracks(&self, table: &Table, name: &str) -> Result<Scenario, Problem> {
        self.in_memory(&format!("{name}.arrow"), |file| {
            table.save(file)?;
            // A table that is none of tracks is to be told what it lacks, not which files there are.
            Ok(self.reading(|| check_table(file))?)
        })
    }

    /// The scenario of a file that is written for it, and lasts as long as it does.
    fn in_memory(
        &self,
        name: &str,
        write: impl FnOnce(&Path) -> Result<(), Problem>,
    ) -> Result<Scenario, Problem> {
        if name.starts_with('.') || name.contains(['/', '\\', '#']) {
            return Err(Problem::new(format!(
                "name {name:?}: expected a plain name"
            )));
        }
        let folder = OwnFolder::new()?;
        let file = folder.path().join(name);
        let written = write(&file).and_then(|()| self.open(&Entry::of_file(&file)));
        let opened = written.map_err(|problem| problem.without_folder(folder.path()))?;
        Ok(Scenario {
            folder: Some(Arc::new(folder)),
            ..opened
        })
    }
}

/// What a batch of an engine holds.
enum Batch {
    /// Files, by a column `path`.
    Paths(Vec<PathBuf>),
    /// Tracks.
    Tracks(Table),
}

impl Batch {
    fn new(object: &Bound<'_, PyAny>) -> PyResult<Self> {
        let table = Table::taken(object)?;
        Ok(match table.texts("path")? {
            Some(paths) => Self::Paths(paths.into_iter().map(PathBuf::from).collect()),
            None => Self::Tracks(table),
        })
    }

    /// What is made of each scenario in it.
    fn each(
        self,
        py: Python<'_>,
        reader: Reader,
        work: impl Fn(&Scenario) -> Result<Table, Problem> + Send + Sync + 'static,
    ) -> PyResult<Vec<Table>> {
        match self {
            Self::Paths(paths) => {
                let entries = found(py, &reader, Paths::Many(paths))?;
                of_each(py, reader, entries, work)
            }
            Self::Tracks(table) => {
                let made = work::run(py, move |_| work(&reader.tracks(&table, "tracks")?))??;
                Ok(vec![made])
            }
        }
    }
}

/// The windows of the scenarios in a batch of paths or tracks; `nearmiss.index_batches` calls it.
#[pyfunction]
#[pyo3(signature = (batch, *, length=None, stride=None, radius=None, measures=None, columns=None, rate=None, map=None))]
#[allow(clippy::too_many_arguments)]
pub fn index_batch(
    py: Python<'_>,
    batch: &Bound<'_, PyAny>,
    length: Option<f64>,
    stride: Option<f64>,
    radius: Option<f64>,
    measures: Option<Names>,
    columns: Option<&str>,
    rate: Option<f64>,
    map: Option<PathBuf>,
) -> PyResult<Table> {
    let reader = Reader::new(None, columns, rate, map)?;
    let options = index_options(length, stride, radius, measures)?;
    let schema = index_table(&options, &reader.user.thresholds).arrow_schema(Clock::Durations);
    let parts = Batch::new(batch)?.each(py, reader, move |scenario| scenario.index(&options))?;
    Ok(Table::joined(parts, schema))
}

/// The measures of the scenarios in a batch of paths or tracks; `nearmiss.measure_batches` calls it.
#[pyfunction]
#[pyo3(signature = (batch, *, names=None, radius=None, columns=None, rate=None, map=None))]
pub fn measure_batch(
    py: Python<'_>,
    batch: &Bound<'_, PyAny>,
    names: Option<Names>,
    radius: Option<f64>,
    columns: Option<&str>,
    rate: Option<f64>,
    map: Option<PathBuf>,
) -> PyResult<Table> {
    let reader = Reader::new(None, columns, rate, map)?;
    let measures = named_measures(names)?;
    let table = measures_of(&measures, &reader.user.thresholds, false);
    let schema = table.arrow_schema(Clock::Durations);
    let parts = Batch::new(batch)?.each(py, reader, move |scenario| {
        scenario.measured(&table, radius, &measures)
    })?;
    Ok(Table::joined(parts, schema))
}
