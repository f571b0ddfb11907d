//! Tables of tracks: a row a road user and moment, in text or in columns, of whatever columns, units and conventions.
//!
//! The user's `--columns` say which column is what, else `[tracks.NAME]` of the configuration, a known data set, or the
//! names of the columns. Units and conventions that nothing says are found out, and each is a note of the scenario.

mod arrow;
mod batch;
mod check;
mod columns;
mod forecast;
mod gather;
mod guess;
mod kept;
mod known;
mod large;
mod middles;
mod motion;
mod names;
mod said;
mod scenario;
mod states;
pub(super) mod table;
#[cfg(test)]
mod tests;
mod text;
mod times;

use std::borrow::Cow;
use std::collections::{BTreeMap, HashMap};
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use nearmiss_base::system;
use nearmiss_scene::scenario::{HashedBeginning, Scenario};

use super::assembly::{self, Ids};
use super::openscenario::EGOS;
use super::{Leftovers, Report, esmini, report_of};
use crate::commonroad::builder::SourceLocation;
use crate::commonroad::{ReadError, beginning_of_file};
use crate::dispatch::{Address, Applies, Format, HEAD, Parts};
pub(super) use kept::cached;
use known::Known;
use large::Outline;
use table::{Decided, Recorded, Said, Track, Trust};

pub use arrow::Form as ColumnForm;
use arrow::PARQUET;
pub use batch::Wanted;
pub(super) use batch::{Batch, Dictionary, Values};
pub(super) use columns::Role;
use columns::Source;
pub use columns::{Columns, ColumnsError};
pub use forecast::{Forecast, read_forecasts};
pub(super) use gather::Rows;
use said::options;
pub use said::{
    NamedTable, TableOptions, check_table_options, read_tables_with, reading_tables_with,
    usual_table_options,
};
pub use text::{BadCell, without_header};

/// The format.
pub struct Tables;

/// How a table is packed and written.
#[derive(Debug)]
enum Written {
    Text(text::Layout, Packing),
    Columns(arrow::Form),
    /// A log of esmini, entities side by side.
    Log(Packing),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Packing {
    Plain,
    Gzip,
    Zstd,
}

impl Packing {
    fn detect(head: &[u8]) -> Self {
        match head {
            [0x1f, 0x8b, ..] => Self::Gzip,
            [0x28, 0xb5, 0x2f, 0xfd, ..] => Self::Zstd,
            _ => Self::Plain,
        }
    }

    fn unpack<'r>(self, packed: impl Read + 'r) -> std::io::Result<Box<dyn Read + 'r>> {
        Ok(match self {
            Self::Plain => Box::new(packed),
            Self::Gzip => Box::new(flate2::read::MultiGzDecoder::new(packed)),
            Self::Zstd => Box::new(zstd::Decoder::new(packed)?),
        })
    }

    /// The beginning of what is packed in a file that begins so.
    fn head(self, packed: &[u8]) -> Vec<u8> {
        let mut head = Vec::new();
        if let Ok(unpacked) = self.unpack(packed) {
            // The end of it is cut off.
            let _ = unpacked.take(HEAD as u64).read_to_end(&mut head);
        }
        head
    }
}

/// How a table is to be read.
#[derive(Debug)]
struct Plan {
    written: Written,
    names: Vec<String>,
    columns: Columns,
    /// Columns that the user names and the table does not have.
    missing: Vec<String>,
    known: Option<&'static Known>,
    rate: Option<f64>,
    map: Option<PathBuf>,
    /// Who says which column is what.
    by: String,
    /// Each road user has a file of its own.
    is_of_one: bool,
}

/// `id=file` says that each road user has a file of its own, named as it is, where no column is called so.
const FILE: &str = "file";

impl Plan {
    /// For a file that begins with `head` and the wanted roles of its columns; nothing where it is no table of tracks.
    fn of(
        path: &Path,
        head: &[u8],
        options: &TableOptions,
        is_wanted: fn(Role) -> bool,
    ) -> Option<Self> {
        let (written, names) = match arrow::Form::detect(head) {
            Some(form) => (Written::Columns(form), form.names(path).ok()?),
            None => {
                let packing = Packing::detect(head);
                let unpacked = match packing {
                    Packing::Plain => Cow::Borrowed(head),
                    packing => Cow::Owned(packing.head(head)),
                };
                if esmini::is_log(&unpacked) {
                    return Some(Self::of_log(packing, options));
                }
                let named = options.named.iter().map(|named| &named.columns);
                let said: Vec<&Columns> = options.columns.iter().chain(named).collect();
                let layout = text::Layout::detect(&unpacked, &said)?;
                let names = layout.names.clone();
                (Written::Text(layout, packing), names)
            }
        };
        let mut plan = Self {
            written,
            columns: Columns::by_name(&names).only(is_wanted),
            missing: Vec::new(),
            known: None,
            rate: options.rate,
            map: options.map.clone(),
            by: "names".into(),
            is_of_one: false,
            names,
        };
        if let Some(columns) = &options.columns {
            let said = columns.clone().only(is_wanted);
            let by_file = said.of.get(&Role::Id).is_some_and(|id| id.column == FILE);
            let (own, mut missing) = said.in_table(&plan.names, true);
            plan.is_of_one = by_file && missing.iter().any(|name| name == FILE);
            plan.columns = own.or(plan.columns);
            if plan.is_of_one {
                missing.retain(|name| name != FILE);
                plan.columns.of.remove(&Role::Id);
            }
            plan.missing = missing;
            plan.by = "--columns".into();
            return Some(plan);
        }
        let fitting = options.named.iter().find_map(|named| {
            let columns = named.columns.clone().only(is_wanted);
            let (columns, missing) = columns.in_table(&plan.names, false);
            missing.is_empty().then_some((named, columns))
        });
        if let Some((named, columns)) = fitting {
            plan.columns = columns.or(plan.columns);
            plan.rate = plan.rate.or(named.rate);
            plan.map = plan.map.or_else(|| named.map.clone());
            plan.by = format!("[tracks.{}]", named.name);
            return plan.columns.is_enough().then_some(plan);
        }
        if let Some(known) = Known::find(&plan.names) {
            let columns: Columns = known.columns.parse().unwrap_or_default();
            plan.columns = columns.in_table(&plan.names, false).0;
            plan.known = Some(known);
            plan.by = known.source.into();
        }
        plan.columns.is_enough().then_some(plan)
    }

    /// For a log of esmini.
    fn of_log(packing: Packing, options: &TableOptions) -> Self {
        Self {
            written: Written::Log(packing),
            names: Vec::new(),
            columns: known::ESMINI.columns.parse().unwrap_or_default(),
            missing: Vec::new(),
            known: Some(&known::ESMINI),
            rate: None,
            map: options.map.clone(),
            by: known::ESMINI.source.into(),
            is_of_one: false,
        }
    }

    /// The same for a file.
    fn of_file(
        path: &Path,
        options: &TableOptions,
        report: &Report,
        is_wanted: fn(Role) -> bool,
    ) -> Result<Option<Self>, ReadError> {
        let io = |error| ReadError::io(report.file(), &error);
        let mut head = Vec::new();
        let file = system::open_file(path).map_err(io)?;
        file.take(HEAD as u64).read_to_end(&mut head).map_err(io)?;
        if let Some(why) = arrow::Form::damage(&head, path) {
            return Err(report.fail(why));
        }
        Ok(Self::of(path, &head, options, is_wanted))
    }

    /// Whether all that the user names is there, and enough for tracks.
    fn is_whole(&self) -> bool {
        let lacks: &[&str] = if self.is_of_one { &["id"] } else { &[] };
        self.missing.is_empty() && self.columns.missing() == lacks
    }

    /// The files of the road users of a recording of which one is at `path`, by name.
    fn of_each(path: &Path, options: &TableOptions) -> impl Iterator<Item = PathBuf> {
        let folder = path.parent().filter(|folder| *folder != Path::new(""));
        let found = std::fs::read_dir(folder.unwrap_or(Path::new(".")));
        let found = found.into_iter().flatten().flatten();
        let named = found.map(|file| path.with_file_name(file.file_name()));
        let mut files: Vec<PathBuf> = named
            .filter(|file| file.extension() == path.extension())
            .collect();
        files.sort();
        let report = Report::about(path.display().to_string());
        files.into_iter().filter(move |file| {
            let plan = Self::of_file(file, options, &report, Role::is_of_recordings);
            matches!(plan, Ok(Some(plan)) if plan.is_of_one && plan.is_whole())
        })
    }

    /// Why it cannot be read, if it cannot.
    fn check(&self, report: &Report) -> Result<(), ReadError> {
        if !self.is_whole() && has_other_letters(&self.names) {
            return Err(report.fail(text::NOT_UTF8));
        }
        if !self.missing.is_empty() {
            return Err(report.fail(format!(
                "no column `{}`; the table has {}",
                self.missing.join("`, `"),
                shown(&self.names)
            )));
        }
        match self.columns.lacking() {
            Some(lacking) if !self.is_whole() => {
                let names = shown(&self.names);
                Err(report.fail(format!("the table has {names}; {lacking}")))
            }
            _ => Ok(()),
        }
    }

    /// The columns that are read.
    fn wanted(&self) -> (Vec<Role>, Vec<Wanted>) {
        let all = self.columns.of.iter().map(|(role, source)| {
            let wanted = Wanted {
                name: source.column.clone(),
                is_text: role.is_text(),
            };
            (*role, wanted)
        });
        all.unzip()
    }

    /// Adds the rows of a file.
    fn rows(&self, path: &Path, report: &Report, rows: &mut Rows) -> Result<(), ReadError> {
        let (roles, wanted) = self.wanted();
        rows.whose = path
            .file_stem()
            .unwrap_or_default()
            .to_string_lossy()
            .into();
        let mut take = |batch| rows.add(&roles, batch);
        let read = match &self.written {
            Written::Columns(form) => form.read(path, &wanted, &mut take),
            Written::Text(layout, packing) => {
                let io = |error| ReadError::io(report.file(), &error);
                let file = system::open_file(path).map_err(io)?;
                let mut source = packing.unpack(file).map_err(io)?;
                layout.read(&mut source, &wanted, &mut take)
            }
            // Its rows are no rows of tracks.
            Written::Log(_) => Ok(()),
        };
        read.map_err(|bad| self.wrong(report, bad))
    }

    /// Words for a mistake in a cell.
    fn wrong(&self, report: &Report, bad: BadCell) -> ReadError {
        let column = match bad.column.as_str() {
            "" => String::new(),
            name => format!("column {name}"),
        };
        report.row(bad.line, column).fail(bad.message)
    }

    fn said(&self) -> Said {
        Said {
            rate: self.rate,
            kind: self.known.and_then(|known| known.kind),
            trust: self.known.map_or(Trust::Nothing, Known::trust),
            ..Said::default()
        }
    }

    /// The table of tracks that were read so from a file.
    fn table(
        &self,
        recorded: Recorded,
        path: &Path,
        hashed: HashedBeginning,
        leftovers: Leftovers,
    ) -> Table {
        let mut notes = vec![format!("columns are known by {}", self.by)];
        for Source { column, .. } in self.columns.of.values() {
            let count = self.names.iter().filter(|name| *name == column).count();
            if count > 1 {
                let name = batch::shown(column);
                notes.push(format!(
                    "{count} columns are called `{name}`; the first is used"
                ));
            }
        }
        let about = AboutTable {
            source: self.known.map_or(SOURCE, |known| known.source),
            tags: self.known.map_or(&[], |known| known.tags),
            how: format!("{} {:?}", self.columns.how(), self.rate),
            notes,
        };
        let map = self.map.clone().or_else(|| self.known?.map?(path));
        Table::with(
            recorded,
            about,
            map.map(MapOfTable::File),
            hashed,
            leftovers,
        )
    }
}

/// So many columns are named.
const MAX_LISTED: usize = 30;

/// Names of columns in words.
fn shown(columns: &[String]) -> String {
    let names = columns.iter().take(MAX_LISTED);
    let names: Vec<String> = names
        .map(|name| format!("`{}`", batch::shown(name)))
        .collect();
    let more = match columns.len() - names.len() {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    format!("the columns {}{more}", names.join(", "))
}

/// A table that lacks columns for tracks.
pub struct Lacking {
    /// Its columns in words.
    pub columns: String,
    /// What is found and missing, and what to do.
    pub instead: String,
    /// Whether it has all but one.
    pub is_near: bool,
    /// Whether it has any of what is needed.
    pub has_some: bool,
}

/// What a table with these columns lacks for tracks.
pub fn lacking(columns: &[String]) -> Lacking {
    let found = Columns::by_name(columns).only(Role::is_of_recordings);
    let missing = found.missing();
    let instead = match names::side_by_side(columns)[..] {
        _ if has_other_letters(columns) => text::NOT_UTF8.into(),
        [one, other, ..] if missing.contains(&"x") => format!(
            "road users stand side by side (`{}`, `{}`); write a row for each road user and moment, with columns time, id, x, y",
            batch::shown(one),
            batch::shown(other)
        ),
        _ => found.lacking().unwrap_or_default(),
    };
    Lacking {
        columns: shown(columns),
        instead: format!("{instead} (`nearmiss help tracks`)"),
        is_near: missing.len() == 1,
        has_some: missing.len() < Columns::default().missing().len(),
    }
}

/// Whether names have letters of another encoding than UTF-8.
fn has_other_letters(names: &[String]) -> bool {
    names
        .iter()
        .any(|name| name.contains(char::REPLACEMENT_CHARACTER))
}

/// The columns of objects of JSON, in lines or in an array, that begin so; nothing of other JSON.
pub fn json_columns(text: &str) -> Option<Vec<String>> {
    text::Layout::detect(text.as_bytes(), &[]).map(|layout| layout.names)
}

/// What is in a file, with all that is needed for its windows.
#[derive(Debug)]
pub struct Table {
    recorded: Recorded,
    about: AboutTable,
    map: Option<MapOfTable>,
    /// Its bytes.
    hashed: HashedBeginning,
    leftovers: Leftovers,
    ids: HashMap<usize, i64>,
    /// Steps of the whole table before the first one of this stretch.
    before: i64,
}

/// Whose data it is, and how it is read.
#[derive(Debug)]
pub struct AboutTable {
    /// The data set, as scenarios name their source.
    pub source: &'static str,
    /// Tags of its scenarios.
    pub tags: &'static [&'static str],
    /// How its bytes are read, spelled out for hashes.
    pub how: String,
    /// Notes of each of its scenarios.
    pub notes: Vec<String>,
}

/// The map of a recording.
#[derive(Debug)]
pub enum MapOfTable {
    /// A file.
    File(PathBuf),
    /// OpenDRIVE in the recording itself.
    Inside(Vec<u8>),
}

/// How a file is to be read.
fn plan(path: &Path, report: &Report) -> Result<Plan, ReadError> {
    let plan = Plan::of_file(path, &options(), report, Role::is_of_recordings)?;
    let plan = plan.ok_or_else(|| report.fail("no table of tracks: it needs columns for time, id, x and y; --columns id=car,time=t[s] names them"))?;
    plan.check(report)?;
    Ok(plan)
}

/// Whether a table is one of tracks: what it lacks, else.
///
/// # Errors
/// Columns are missing, or a role is none of theirs.
pub fn check_table(path: &Path) -> Result<(), ReadError> {
    plan(path, &Report::about(path.display().to_string())).map(drop)
}

/// What is where in a table that is larger than memory; nothing of others.
fn outline(path: &Path) -> Result<Option<Arc<Outline>>, ReadError> {
    let report = Report::about(path.display().to_string());
    large::outline(path, || plan(path, &report))
}

/// The data in a file.
fn read(path: &Path) -> Result<Arc<Table>, ReadError> {
    let report = Report::about(path.display().to_string());
    let plan = plan(path, &report)?;
    let all: Vec<PathBuf> = if plan.is_of_one {
        Plan::of_each(path, &options()).collect()
    } else {
        let beside = plan.known.and_then(|known| known.beside?(path));
        std::iter::once(path.to_path_buf()).chain(beside).collect()
    };
    let files: Vec<&Path> = all.iter().map(PathBuf::as_path).collect();
    cached(&files, || Table::read(plan, &files, &options(), &report))
}

impl Table {
    /// Reads files of the same recording; `plan` is that of the first one.
    fn read(
        plan: Plan,
        files: &[&Path],
        options: &TableOptions,
        report: &Report,
    ) -> Result<Self, ReadError> {
        if let Written::Log(packing) = plan.written {
            return Self::of_log(plan, packing, files, report);
        }
        let mut rows = Rows::default();
        let mut plans = vec![plan];
        for path in &files[1..] {
            let report = Report::about(path.display().to_string());
            plans.extend(Plan::of_file(
                path,
                options,
                &report,
                Role::is_of_recordings,
            )?);
        }
        for (plan, path) in plans.iter().zip(files) {
            plan.rows(path, &Report::about(path.display().to_string()), &mut rows)?;
        }
        let plan = plans.swap_remove(0);
        let mut leftovers = Leftovers::default();
        let used: Vec<&String> = plan.columns.of.values().map(|s| &s.column).collect();
        for name in plan.names.iter().filter(|name| !used.contains(name)) {
            let column = if name.is_empty() {
                "column without a name".into()
            } else {
                format!("column {name}")
            };
            leftovers.add_times(&column, rows.count(), || 1);
        }
        let recorded = Recorded::new(rows, &plan.columns, plan.said(), report.file())?;
        let hashed = hashed(files, report)?;
        Ok(plan.table(recorded, files[0], hashed, leftovers))
    }

    /// Tracks that were read from files; `leftovers` is what of these is not used.
    ///
    /// # Errors
    /// One of the files cannot be read.
    pub(super) fn new(
        recorded: Recorded,
        about: AboutTable,
        map: Option<MapOfTable>,
        files: &[&Path],
        leftovers: Leftovers,
    ) -> Result<Self, ReadError> {
        let report = Report::about(files[0].display().to_string());
        let hashed = hashed(files, &report)?;
        // What the user says of every table is said of these, too.
        let map = options().map.clone().map(MapOfTable::File).or(map);
        Ok(Self::with(recorded, about, map, hashed, leftovers))
    }

    fn with(
        recorded: Recorded,
        about: AboutTable,
        map: Option<MapOfTable>,
        hashed: HashedBeginning,
        leftovers: Leftovers,
    ) -> Self {
        let names = recorded.tracks.iter().map(|t| (&*t.scenario, &*t.name));
        Self {
            ids: numbers(names).into_iter().enumerate().collect(),
            before: 0,
            recorded,
            about,
            map,
            hashed,
            leftovers,
        }
    }

    /// The scenarios in it.
    ///
    /// # Errors
    /// A shape in it is impossible.
    pub(super) fn parts(&self, path: &Path) -> Result<Parts, ReadError> {
        let mut scenarios: Vec<&str> = Vec::new();
        for track in &self.recorded.tracks {
            if scenarios.last() != Some(&track.scenario.as_str())
                && !scenarios.contains(&track.scenario.as_str())
            {
                scenarios.push(&track.scenario);
            }
        }
        if scenarios.len() > 1 {
            let names = scenarios.into_iter().map(str::to_string);
            return Ok(Parts::Named(names.collect()));
        }
        if !self.is_long(scenarios.first().copied().unwrap_or_default()) {
            return Ok(Parts::One);
        }
        let report = Report::about(path.display().to_string());
        Ok(Parts::Long(Box::new(self.long_recording(report)?)))
    }

    /// The scenario at an address in it.
    ///
    /// # Errors
    /// There is none, or several.
    pub(super) fn open_at(&self, address: &Address) -> Result<Scenario, ReadError> {
        self.open(&address.file, address.part.as_deref(), report_of(address))
    }
}

impl Table {
    /// A log of esmini.
    fn of_log(
        plan: Plan,
        packing: Packing,
        files: &[&Path],
        report: &Report,
    ) -> Result<Self, ReadError> {
        let io = |error| ReadError::io(report.file(), &error);
        let packed = system::open_file(files[0]).map_err(io)?;
        let mut text = Vec::new();
        let source = packing.unpack(packed).map_err(io)?;
        source
            .take(system::LARGEST)
            .read_to_end(&mut text)
            .map_err(io)?;
        let said = Report::about(report.file());
        let log = esmini::read(&String::from_utf8_lossy(&text), &said)?.bodies(None, &said);
        said.note(format!("recorded by {}", log.player));
        let mut leftovers = Leftovers::default();
        let count = log.entities.values().map(Vec::len).sum();
        for name in &log.unused {
            leftovers.add_times(&format!("column {name}"), count, || 1);
        }
        let tracks = log.entities.iter().map(|(name, states)| {
            let size = states.first().map_or((0.0, 0.0), |first| first.size);
            Track {
                name: name.clone(),
                scenario: String::new(),
                kind: assembly::kind_by_size(size),
                is_ego: EGOS.contains(&name.to_lowercase().as_str()),
                size,
                states: log.states(states),
            }
        });
        let tracks: Vec<Track> = tracks.collect();
        if tracks.is_empty() {
            return Err(report.fail("no entity in it"));
        }
        let recorded = Recorded {
            tracks,
            start: 0.0,
            time_step: log.time_step,
            plane: None,
            diagnostics: said.into_diagnostics(),
            decided: Decided::default(),
        };
        let about = AboutTable {
            source: plan.known.map_or(SOURCE, |known| known.source),
            tags: plan.known.map_or(&[], |known| known.tags),
            how: plan.columns.to_string(),
            notes: vec![format!("columns are known by {}", plan.by)],
        };
        Self::new(
            recorded,
            about,
            plan.map.map(MapOfTable::File),
            files,
            leftovers,
        )
    }
}

/// The source of scenarios from a table that no data set is known for.
const SOURCE: &str = "table of tracks";

/// The bytes of files, one after the other.
fn hashed(files: &[&Path], report: &Report) -> Result<HashedBeginning, ReadError> {
    let io = |error| ReadError::io(report.file(), &error);
    let mut all: Box<dyn Read> = Box::new(std::io::empty());
    for path in files {
        all = Box::new(all.chain(system::open_file(path).map_err(io)?));
    }
    HashedBeginning::read(&mut all).map_err(io)
}

/// Ids of tracks, of which these are the scenarios and names: the names where they are numbers, or the numbers at their
/// ends where no other track of the scenario has the same.
fn numbers<'t>(tracks: impl Iterator<Item = (&'t str, &'t str)>) -> Vec<i64> {
    let positive = |text: &str| text.parse::<i64>().ok().filter(|id| *id > 0);
    let mut of_scenario: BTreeMap<&str, Vec<(usize, &str)>> = BTreeMap::new();
    for (place, (scenario, name)) in tracks.enumerate() {
        of_scenario.entry(scenario).or_default().push((place, name));
    }
    let mut found = vec![0; of_scenario.values().map(Vec::len).sum()];
    for tracks in of_scenario.into_values() {
        // Of `12`, `012` and `+12` only the first one is called so.
        let exact = |name: &str| positive(name).filter(|id| id.to_string() == name);
        let number = |name: &str| {
            let end = name.trim_end_matches(|c: char| c.is_ascii_digit()).len();
            // Longer ones are no numbers of road users.
            let is_short = name.len() - end <= LONGEST_NUMBER;
            exact(name).or_else(|| positive(&name[end..]).filter(|_| is_short))
        };
        let mut counts: HashMap<i64, usize> = HashMap::new();
        for number in tracks.iter().filter_map(|(_, name)| number(name)) {
            *counts.entry(number).or_default() += 1;
        }
        let own = |name: &str| {
            let number = number(name)?;
            (exact(name).is_some() || counts[&number] == 1).then_some(number)
        };
        let known = tracks.iter().filter_map(|(_, name)| own(name));
        let mut ids = Ids::beyond(known.clone());
        known.for_each(|id| {
            ids.take(id);
        });
        for (place, name) in &tracks {
            found[*place] = own(name).unwrap_or_else(|| ids.fresh());
        }
    }
    found
}

/// So many digits are a number at the end of a name.
const LONGEST_NUMBER: usize = 9;

/// The id of the road user that a table calls so.
pub fn id_of(path: &Path, name: &str) -> Option<i64> {
    let address = Address::from_path(path);
    let head = beginning_of_file(&address.file, HEAD).ok()?;
    if !Tables.recognises(&address.file, &head) {
        return None;
    }
    if let Some(outline) = outline(&address.file).ok()? {
        return outline.id_of(name);
    }
    let table = read(&address.file).ok()?;
    let part = address.part.as_deref();
    let scenario = table.only_scenario().or(part)?;
    let (place, _) = table
        .tracks(scenario)
        .find(|(_, track)| track.name == name)?;
    table.ids.get(&place).copied()
}

impl Format for Tables {
    /// Also damaged ones, so that this is said of them.
    fn recognises(&self, path: &Path, head: &[u8]) -> bool {
        Plan::of(path, head, &options(), Role::is_of_recordings).is_some()
            || arrow::Form::damage(head, path).is_some()
    }

    fn is_found(&self, path: &Path, head: &[u8]) -> bool {
        let is_beside = |plan: &Plan| {
            matches!(plan.written, Written::Log(_)) && path.with_extension("xosc").is_file()
                || plan.known.is_some_and(|known| known.is_beside(path))
                || plan.is_of_one && Plan::of_each(path, &options()).next().as_deref() != Some(path)
                || path.with_file_name(crate::ego::RECORDING).is_file()
        };
        // The log of a scenario, the other table of a recording and results of an ego are read with it.
        match Plan::of(path, head, &options(), Role::is_of_recordings) {
            Some(plan) => plan.is_whole() && !is_beside(&plan),
            None => head.starts_with(PARQUET) && arrow::Form::damage(head, path).is_some(),
        }
    }

    fn applies(&self, path: &Path, head: &[u8]) -> Applies {
        let plan = Plan::of(path, head, &options(), Role::is_of_recordings);
        match plan.map(|plan| plan.written) {
            Some(Written::Log(_)) => Applies::Map,
            _ => Applies::All,
        }
    }

    fn parts(&self, path: &Path) -> Result<Parts, ReadError> {
        match outline(path)? {
            Some(outline) => Ok(outline.parts()),
            None => read(path)?.parts(path),
        }
    }

    fn open(&self, address: &Address) -> Result<Scenario, ReadError> {
        match outline(&address.file)? {
            Some(outline) => outline.open_at(address, report_of(address)),
            None => read(&address.file)?.open_at(address),
        }
    }
}
